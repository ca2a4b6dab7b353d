"""Runs whose every accepted state is held against an independent oracle, and their table.

The oracle (ipctk) decides on a sub-mesh twice as fine as that of contact whether the sheet crosses itself in a state,
and whether it collides with itself on the straight way from one state to the next. Shared by no_crossing.py and
crumpling.py; needs the extra `test`.
"""

import csv
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import ipctk
import numpy as np

from warp_origami.api import simulate
from warp_origami.errors import NumericalFailure
from warp_origami.model.coordinates import number_coordinates
from warp_origami.model.generators import build_pattern
from warp_origami.model.submesh import build_submesh, default_divisions
from warp_origami.output.memory import Memory
from warp_origami.scene import Scene
from warp_origami.solve.records import Observer
from warp_origami.terms.shapes import tabulate

RESULTS = Path(__file__).parent / "results"
EXACT = ipctk.TightInclusionCCD(conservative_rescaling=1.0 - 1e-6)
"""As it comes, ipctk takes coming close, to a fifth of the distance before, for a collision."""

FINER = 2
"""Divisions of the oracle's sub-mesh over those of contact."""

COLUMNS = (
    "scene",
    "contact",
    "seed",
    "status",
    "steps",
    "rejected",
    "crossings",
    "passages",
    "first",
    "depth_over_thickness",
    "energy_gain",
    "contacts_sts",
    "contacts_nts",
    "contacts_edge",
    "finite",
    "iterations",
    "seconds",
)


class Watch(Memory):
    """Looks at the state after every accepted step.

    Attributes:
        steps: states looked at.
        crossings: times (s) of those in which the sheet crosses itself.
        passages: times (s) of those on the straight way to which it passes through itself, as flat layers may without
            ever crossing.
        finite: whether all numbers of all states were finite.
    """

    def __init__(self, scene: Scene):
        super().__init__()
        pattern = build_pattern(scene.pattern.kind, scene.pattern.parameters(), scene.directory, scene.pattern.refine)
        mesh = pattern.mesh
        submesh = build_submesh(mesh, FINER * default_divisions(len(mesh.triangles)))
        self._points = tabulate(mesh, submesh.elements, submesh.areas).interpolation(number_coordinates(mesh))
        triangles = submesh.triangles.astype(np.int32)
        flat = np.pad(submesh.flat, ((0, 0), (0, 1)))
        self._oracle = ipctk.CollisionMesh(flat, ipctk.edges(triangles), triangles)
        self.steps, self.crossings, self.passages, self.finite = 0, [], [], True
        self._time, self._before = 0.0, None

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """Called after every accepted step with its state."""
        time, q = float(arrays["kinematics.time"]), arrays["kinematics.q"]
        if time <= self._time:  # the last state is told twice
            return
        self._time = time
        self.steps += 1
        if not (np.isfinite(q).all() and np.isfinite(arrays["kinematics.v"]).all()):
            self.finite = False
            return
        points = self._points @ q
        if ipctk.has_intersections(self._oracle, points):
            self.crossings.append(time)
        if self._before is not None and not self._free_way(points):
            self.passages.append(time)
        self._before = points

    def _free_way(self, points: np.ndarray) -> bool:
        return ipctk.is_step_collision_free(self._oracle, self._before, points, narrow_phase_ccd=EXACT)


def without_contact(scene: Scene) -> Scene:
    """The scene with nothing to keep layers apart."""
    return scene.model_copy(update={"contact": None})


def with_random_velocities(scene: Scene, speed: float, seed: int) -> Scene:
    """The scene with velocities added at every vertex: each component normal, of standard deviation `speed` (m/s)."""
    pattern = build_pattern(scene.pattern.kind, scene.pattern.parameters(), scene.directory, scene.pattern.refine)
    vertices = pattern.mesh.vertices
    velocities = np.random.default_rng(seed).normal(scale=speed, size=(len(vertices), 3))
    loads = [
        {"kind": "initial_velocity", "at": {"box": [vertex, vertex]}, "value": velocity}
        for vertex, velocity in zip(vertices.tolist(), velocities.tolist(), strict=True)
    ]
    values = scene.model_dump(exclude_none=True)
    return Scene(**values | {"load": [*values["load"], *loads]})


def watch(scene: Scene, until: float | None = None, observers: Sequence[Observer] = ()) -> tuple[Watch, dict]:
    """The scene run under the oracle's eyes, and its summary; a run that fails has one too."""
    seen = Watch(scene)
    try:
        summary = simulate(scene, device="cpu", until=until, observers=[seen, *observers]).summary
    except NumericalFailure as failure:
        summary = failure.result.summary
    return seen, summary


def row(label: dict, scene: Scene, seen: Watch, summary: dict) -> dict:
    """A row of COLUMNS; `label` gives scene, contact and seed."""
    history, phases = seen.history, summary["phases"]
    thickness = scene.contact.thickness if scene.contact is not None else math.nan
    return label | {
        "status": summary["status"],
        "steps": seen.steps,
        "rejected": summary["steps_rejected"],
        "crossings": len(seen.crossings),
        "passages": len(seen.passages),
        "first": f"{min(passed):.6g}" if (passed := seen.crossings + seen.passages) else "",
        "depth_over_thickness": f"{summary['max_penetration'] / thickness:.4g}",
        "energy_gain": f"{summary['energy_gain']:.3g}",
        **{column: int(history[column].max()) for column in ("contacts_sts", "contacts_nts", "contacts_edge")},
        "finite": seen.finite,
        "iterations": summary["newton_iterations"],
        "seconds": round(summary["wall_seconds"] - phases.get("compile", 0.0), 1),
    }


def fill_table(path: Path, labels: list[dict], run: Callable[[dict], dict]) -> Iterator[dict]:
    """Rows of a table, each appended to the file as soon as its run has ended; rows that are there are not repeated."""
    done = {}
    if path.exists():
        with path.open(newline="") as file:
            done = {tuple(found[key] for key in COLUMNS[:3]): found for found in csv.DictReader(file)}
    else:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(",".join(COLUMNS) + "\n")
    for label in labels:
        found = done.get(tuple(str(label[key]) for key in COLUMNS[:3]))
        if found is None:
            found = run(label)
            with path.open("a", newline="") as file:
                csv.DictWriter(file, COLUMNS, lineterminator="\n").writerow(found)
        yield found
