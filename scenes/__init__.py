"""Scenes that come with the program: TOML files, in folders by topic."""

from importlib import resources
from pathlib import Path


def bundled_scenes() -> dict[str, tuple[Path, str]]:
    """Name -> path and first comment line of every bundled scene, sorted by name.

    The name is the path in this folder without its ending, for example "leaf_in" or "verification/impact".
    """
    folder = Path(str(resources.files(__name__)))
    paths = {path.relative_to(folder).with_suffix("").as_posix(): path for path in folder.rglob("*.toml")}
    return {name: (paths[name], _first_comment(paths[name])) for name in sorted(paths)}


def _first_comment(path: Path) -> str:
    lines = path.read_text(encoding="utf-8").splitlines()
    return next((line.lstrip("# ") for line in lines if line.startswith("#")), "")
