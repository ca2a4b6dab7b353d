"""The states of a run as a multi-frame FOLD file, from its folder: finished, stopped or killed."""

import json
from importlib.metadata import version
from pathlib import Path

from warp_origami.errors import InputError
from warp_origami.model.fold_writer import State, fold_document
from warp_origami.model.generators import build_pattern
from warp_origami.model.pattern import Pattern
from warp_origami.scene import load_scene

from .files import write_text
from .usd import read_nodes


def write_pattern(path: Path, pattern: Pattern, title: str) -> int:
    """Writes crease pattern and stowed state; returns the number of frames."""
    return _write(path, fold_document(pattern, title, _creator()))


def write_run(path: Path, folder: Path) -> int:
    """Writes crease pattern (of the elements), stowed state and all frames of the animation in a run's folder, in
    single precision as they are there; returns the number of frames.

    Raises:
        InputError: there is no run with an animation in the folder.
    """
    scene_file, animation = folder / "scene.toml", folder / "animation.usdc"
    for file in (scene_file, animation):
        if not file.is_file():
            raise InputError("SOURCE", f"the folder {str(folder)!r} without {file.name}", "the folder of a run")
    scene = load_scene(scene_file)
    pattern = build_pattern(scene.pattern.kind, scene.pattern.parameters(), scene.directory, scene.pattern.refine)
    states = [State(time, points) for time, points in read_nodes(animation)]
    if not states or len(states[0].points) != len(pattern.mesh.vertices):
        raise InputError(str(animation), "no frames of this scene", "the animation that this program wrote")
    return _write(path, fold_document(pattern, scene.name, _creator(), states))


def _creator() -> str:
    return f"warp_origami {version('warp-origami')}"


def _write(path: Path, document: dict) -> int:
    write_text(path, json.dumps(document, separators=(",", ":")) + "\n")
    return 1 + len(document.get("file_frames", []))
