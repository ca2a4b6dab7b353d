"""`python -m warp_origami`: the same as `warp-origami`."""

from .cli import main

main(prog_name="warp-origami")
