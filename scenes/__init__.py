"""Bundled scenes, one TOML file each; installed as ``warp_origami.scenes``."""
