"""A pattern by name: a generator's, a scene's or a FOLD file's, for what needs no scene."""

import difflib
from collections.abc import Iterable
from pathlib import Path

from warp_origami.errors import InputError
from warp_origami.model.generators import GENERATORS, build_pattern
from warp_origami.model.pattern import Pattern
from warp_origami.model.pattern_report import describe_pattern
from warp_origami.scenes import bundled_scenes

from .document import Scene
from .files import apply_override, load_scene

__all__ = ["describe_pattern", "load_pattern"]

EXAMPLES = {
    "miura": {"nx": 4, "ny": 4, "a": 0.1, "b": 0.1, "sector_angle": 1.0, "opening": 0.3},
    "disc": {"radius": 0.5, "rings": 4},
    "annulus": {"inner_radius": 0.25, "outer_radius": 0.5, "rings": 3},
}
"""Parameters of generators that have none by default."""


def load_pattern(name_or_path: str, overrides: Iterable[str] = ()) -> tuple[str, Pattern]:
    """Name and pattern, not refined.

    Args:
        name_or_path: a generator's name (its default parameters), a bundled scene's name, or the path of a .toml or a
            .fold file.
        overrides: "key=value" as in load_scene; keys of the pattern with or without "pattern." in front.

    Raises:
        InputError: there is nothing of that name, or it is not valid.
    """
    path = Path(name_or_path)
    if name_or_path in GENERATORS or path.suffix == ".fold":
        kind = {"kind": name_or_path} if name_or_path in GENERATORS else {"kind": "fold", "file": name_or_path}
        values = {"pattern": kind | EXAMPLES.get(name_or_path, {})}
        for override in overrides:
            apply_override(values, override if override.startswith("pattern.") else f"pattern.{override}")
        scene = Scene(**_FRAME | values)
        name = path.stem
    elif path.suffix == ".toml" or name_or_path in bundled_scenes():
        scene = load_scene(name_or_path, overrides)
        name = scene.name
    else:
        names = list(dict.fromkeys([*GENERATORS, *bundled_scenes()]))
        close = difflib.get_close_matches(name_or_path, names, cutoff=0.7)
        told = f"did you mean {' or '.join(close)}? " if close else ""
        wants = f"{told}a generator ({', '.join(GENERATORS)}), a scene (see list), or the path of a .toml or .fold file"
        raise InputError("PATTERN", repr(name_or_path), wants)
    return name, build_pattern(scene.pattern.kind, scene.pattern.parameters() | {"refine": 1}, scene.directory)


_FRAME = {
    "name": "pattern",
    "analysis": {"kind": "dynamic", "duration": 1.0},
    "material": {"density": 1.0, "youngs_modulus": 1.0, "poisson_ratio": 0.3, "thickness": 1.0},
}
"""What a scene needs besides its pattern, whose table is checked with it."""
