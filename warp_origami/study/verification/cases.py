"""The verification suite: scenes with a table [verification], and the pendulum, run over their meshes."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from warp_origami.api import simulate
from warp_origami.errors import InputError, NumericalFailure
from warp_origami.scene import Scene, load_scene
from warp_origami.scenes import bundled_scenes

from ..results import check_values, read_value, without_value
from .convergence import Claim, Convergence, Level
from .pendulum import swing

FOLDER = "verification/"
PENDULUM = FOLDER + "pendulum"
PENDULUM_STEPS = (100, 200, 400)
PENDULUM_ERRORS = {"error of q": 2.37e-5, "error of v": 1.05e-4, "error of lambda": 3.91e-4}
"""At the last of the steps, to be kept within; four times these at half as many."""


@dataclass(frozen=True)
class Case:
    """What can be verified.

    Attributes:
        name: of the case.
        source: where the exact values come from.
        claims: values that are known.
        quick: number of meshes of a quick check.
        run: the result on mesh k, counted from the coarsest.
        meshes: how many there are.
    """

    name: str
    source: str
    claims: tuple[Claim, ...]
    meshes: int
    quick: int
    run: Callable[[int], Level]

    def levels(self, quick: bool) -> Iterator[Level]:
        """Results on the meshes, as they come."""
        for k in range(self.quick if quick else self.meshes):
            yield self.run(k)

    def convergence(self, levels: list[Level]) -> Convergence:
        """The results so far, held against the claims."""
        return Convergence(self.name, self.source, self.claims, tuple(levels))


def case_names() -> list[str]:
    """Names of the cases that come with the program."""
    return sorted([*(name for name in bundled_scenes() if name.startswith(FOLDER)), PENDULUM])


def find_cases(name: str | None, device: str | None = None) -> list[Case]:
    """The case of a name ("drum", "verification/drum"), a bundled scene or the path of one; without a name all.

    Raises:
        InputError: there is no such case, it has no exact values, or these do not fit the scene.
    """
    names = case_names()
    if name is None:
        return [_case(one, device) for one in names]
    if FOLDER + name in names:
        name = FOLDER + name
    if name not in names and name not in bundled_scenes() and not (name.endswith(".toml") and Path(name).exists()):
        known = ", ".join(one.removeprefix(FOLDER) for one in names)
        raise InputError("NAME", repr(name), f"one of {known}, or the path of a scene with a table [verification]")
    return [_case(name, device)]


def _case(name: str, device: str | None) -> Case:
    return _pendulum() if name == PENDULUM else _scene_case(name, device)


def _scene_case(name: str, device: str | None) -> Case:
    known = load_scene(name).verification
    if known is None:
        raise InputError("verification", f"nothing in {name}", "a table with source and value: exact values")
    scenes = [load_scene(name, changes) for changes in known.refinement]
    for scene in scenes:
        check_values(((f"verification.value.{k}.of", value.of) for k, value in enumerate(known.value)), scene)
    labels = [" ".join(change.removeprefix("pattern.") for change in changes) for changes in known.refinement]
    meshes = len(scenes)
    claims = tuple(Claim(value.name, value.exact, value.tolerances(meshes)) for value in known.value)

    def run(k: int) -> Level:
        return _level(scenes[k], labels[k], device)

    return Case(name, known.source, claims, meshes, known.quick, run)


def _level(scene: Scene, label: str, device: str | None) -> Level:
    values = scene.verification.value
    failure = None
    try:
        result = simulate(scene, device=device)
    except NumericalFailure as error:
        result, failure = error.result, str(error)
    summary = result.summary
    if summary["status"] == "interrupted":
        raise KeyboardInterrupt
    obtained = tuple(float("nan") if failure else read_value(value.of, result) / value.over for value in values)
    remarks = () if failure else tuple(line for value in values for line in without_value(value.of, result))
    seconds = summary["wall_seconds"] - summary["phases"]["compile"]
    return Level(label, summary["elements"], summary["steps_accepted"], seconds, obtained, failure, remarks)


def _pendulum() -> Case:
    last = PENDULUM_STEPS[-1]
    claims = tuple(
        Claim(name, 0.0, tuple(error * (last / n) ** 2 for n in PENDULUM_STEPS))
        for name, error in PENDULUM_ERRORS.items()
    )

    def run(k: int) -> Level:
        n, start = PENDULUM_STEPS[k], time.perf_counter()
        errors = swing(0.8, [1.0 / n] * n)
        return Level(f"step=1/{n}", 0, n, time.perf_counter() - start, tuple(map(float, errors)))

    source = "Runge-Kutta solution of the angle to 1e-8; generalized-alpha, spectral radius 0.8, link as multiplier"
    return Case(PENDULUM, source, claims, len(PENDULUM_STEPS), len(PENDULUM_STEPS), run)
