"""The runs of a study: a scene for each point, and a folder named after what is in it."""

import copy
import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warp_origami.errors import InputError
from warp_origami.output.checkpoint import pattern_identity
from warp_origami.scene import Scene
from warp_origami.scene.files import load_tables, resolve_pattern_file, scene_folder, set_value
from warp_origami.scenes import bundled_scenes

from ..results import check_path
from ..results import paths as paths_of
from .document import Study
from .points import points

DIGITS = 16
"""Of the digest of a scene that names the folder of its run."""


@dataclass(frozen=True)
class Run:
    """One run.

    Attributes:
        number: from 0, in the order of the points.
        values: of the parameters, in their order.
        scene: to run; None where the values make no scene.
        digest: of the scene, its FOLD file and the end of the run; empty without a scene. Equal runs have equal ones.
        end: s, or load factor.
        fault: why there is no scene.
    """

    number: int
    values: tuple[Any, ...]
    scene: Scene | None
    digest: str
    end: float
    fault: str = ""


def plan(study: Study, folder: Path) -> list[Run]:
    """All runs of a study; those whose values the scene does not allow have a fault in place of a scene.

    Args:
        study: what to run.
        folder: where the path of its scene starts.

    Raises:
        InputError: there is no such scene, a key leads nowhere, no point gives a scene, or a result is none of it.
    """
    scene_path = _scene_of(study, folder)
    base, place = load_tables(scene_path), scene_folder(scene_path)
    for key, value in study.set.items():
        set_value(base, key, value, f"set.{key}")
    runs, first = [], None
    for number, values in enumerate(points(study)):
        tables = copy.deepcopy(base)
        try:
            for k, (parameter, value) in enumerate(zip(study.parameter, values, strict=True)):
                set_value(tables, parameter.key, value, f"parameter.{k}.key {parameter.key}")
            resolve_pattern_file(tables, place)
            scene = Scene(**tables)
        except InputError as error:
            first = first or error
            runs.append(Run(number, values, None, "", 0.0, str(error).replace("\n", "; ")))
            continue
        end = scene.analysis.end if study.until is None else min(study.until, scene.analysis.end)
        if scene.analysis.kind == "modal" and end < scene.analysis.end:
            raise InputError("until", study.until, "nothing before load factor 1, where modes are found")
        runs.append(Run(number, values, scene, _digest(scene, end), end))
    sound = [run.scene for run in runs if run.scene is not None]
    if not sound:
        raise first
    for k, result in enumerate(study.result):
        for path in paths_of(result.of):
            check_path(path, sound[0], f"result.{k}.of")
    return runs


def _scene_of(study: Study, folder: Path) -> Path | str:
    """Where the scene is: a bundled one by its name, else a path."""
    return study.scene if study.scene in bundled_scenes() else folder / study.scene


def _digest(scene: Scene, end: float) -> str:
    # the content of a FOLD file counts, not where it lies
    text = scene.to_toml()
    if scene.pattern.kind == "fold":
        text = text.replace(scene.pattern.file, "")
    return hashlib.sha256(f"{text}\n{pattern_identity(scene)}\n{end!r}".encode()).hexdigest()[:DIGITS]
