"""Runs of the leaf-in square with the contact models of the paper, each once, with every accepted state kept.

A run lives in a folder of its own: the files of `warp-origami run`, and states.npz with q and v after every accepted
step. A run that is complete is read, not repeated.
"""

import csv
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from warp_origami.clock import PhaseClock
from warp_origami.model.submesh import Submesh, build_submesh
from warp_origami.output.memory import Memory
from warp_origami.output.observers import Observers
from warp_origami.output.run_directory import RunDirectory, is_finished
from warp_origami.scene import Scene, load_scene
from warp_origami.solve.dynamic import DynamicRun
from warp_origami.solve.interrupt import deferred_interrupt
from warp_origami.solve.loop import loop
from warp_origami.solve.records import PROBE_COLUMNS
from warp_origami.solve.sampling import Surface
from warp_origami.system import System
from warp_origami.terms.contact import Contact
from warp_origami.terms.shapes import tabulate


@dataclass(frozen=True)
class Case:
    """One run.

    Attributes:
        name: of its folder.
        label: in tables and figures.
        method: of contact; None without contact.
        pattern: overrides of the pattern's parameters.
        drive: overrides of all four drivers.
        until: end of the run, s.
        seed: of random velocities at the start, SPEED in a random direction at every vertex; None: none.
        whole_elements: slave points are the 12 integration points of whole elements, as in the paper, instead of those
            of their sub-triangles.
    """

    name: str
    label: str
    method: str | None
    pattern: dict[str, float] = field(default_factory=dict)
    drive: dict[str, object] = field(default_factory=dict)
    until: float = 4.0
    seed: int | None = None
    whole_elements: bool = False


SPEED = 0.05
"""m/s"""

MODELS = (
    Case("model1", "Model 1: no contact", None),
    Case("model2", "Model 2: surface-to-surface", "sts"),
    Case("model3", "Model 3: mixed", "mixed"),
)

UNFOLDED = 1.95
"""s: the layers are apart from then on."""

STOWED = ((9, 318), (9, 331), (3, 312))
"""Other stowed shapes: inset of the ring middles and distance of the corners from the axis, mm; the scene's: 5, 312."""

VARIATIONS = (
    Case("sts_whole", "Model 2, 12 points an element", "sts", until=UNFOLDED, whole_elements=True),
    Case(
        "sts_whole_seed1",
        "Model 2, 12 points an element, asymmetric",
        "sts",
        until=UNFOLDED,
        seed=1,
        whole_elements=True,
    ),
    Case("sts_seed1", "Model 2, asymmetric", "sts", until=UNFOLDED, seed=1),
    *(
        Case(
            f"sts_whole_inset{inset}_corner{corner}",
            f"Model 2, 12 points an element, inset {inset} mm, corners at {corner} mm",
            "sts",
            pattern={"inset": 1e-3 * inset, "corner_distance": 1e-3 * corner},
            until=UNFOLDED,
            whole_elements=True,
        )
        for inset, corner in STOWED
    ),
    Case(
        "early_drive",
        "Model 1, corners there at 3 s, overstretch 1e-3",
        None,
        drive={"overstretch": 1e-3, "profile": {"kind": "trapezoid", "start": 0.0, "end": 3.0}},
    ),
    *(
        Case(
            f"{method}_inset3_corner312",
            f"{label}, inset 3 mm, corners at 312 mm",
            method,
            pattern={"inset": 3e-3, "corner_distance": 0.312},
            until=UNFOLDED,
        )
        for method, label in (("sts", "Model 2"), ("mixed", "Model 3"))
    ),
    Case("mixed_seed1", "Model 3, asymmetric", "mixed", until=UNFOLDED, seed=1),
)
"""What the paper leaves open about Model 2: the number of integration points, symmetry, the stowed shape. Another
drive; and Model 3 without symmetry."""


class States(Memory):
    """Keeps time, q and v of every accepted step, and writes them when the run ends."""

    def __init__(self, path: Path):
        super().__init__()
        self.path, self.rows = path, []

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """Called after every accepted step with its state."""
        time = float(arrays["kinematics.time"])
        if not self.rows or time > self.rows[-1][0]:
            self.rows.append((time, np.array(arrays["kinematics.q"]), np.array(arrays["kinematics.v"])))

    def save(self) -> None:
        """Writes states.npz."""
        times, q, v = zip(*self.rows, strict=True)
        np.savez(self.path, times=times, q=q, v=v)


def scene_of(case: Case) -> Scene:
    """The bundled leaf-in with the contact model and the changes of the case."""
    overrides = [f"pattern.{key}={value}" for key, value in case.pattern.items()]
    scene = load_scene("leaf_in", overrides + ([f'contact.method="{case.method}"'] if case.method else []))
    values = scene.model_dump(exclude_none=True)
    values["driver"] = [driver | case.drive for driver in values["driver"]]
    if case.method is None:
        del values["contact"]
    if case.seed is not None:
        vertices = len(System(scene.model_copy(update={"contact": None}), "cpu", PhaseClock()).mesh.vertices)
        directions = np.random.default_rng(case.seed).normal(size=(vertices, 3))
        velocities = SPEED * directions / np.linalg.norm(directions, axis=1, keepdims=True)
        values["load"] = [
            {"kind": "initial_velocity", "at": {"vertices": [k]}, "value": velocity}
            for k, velocity in enumerate(velocities)
        ]
    return Scene(**values)


def system_of(case: Case) -> System:
    """The equations of motion of the case."""
    system = System(scene_of(case), "cpu", PhaseClock())
    if case.whole_elements:
        system.contact = Contact(
            system.mesh, system.coordinates, system.contact_settings, system.q0, divisions=1, sts_degree=6
        )
    return system


def simulate(case: Case, folder: Path, say: Callable[[str], None]) -> None:
    """Runs the case, unless its folder already has it complete."""
    path = folder / case.name
    if is_finished(path, case.until) and (path / "states.npz").exists():
        return
    say(f"running {case.name} to {case.until:g} s")
    system = system_of(case)
    observer = Observers([RunDirectory(path), States(path / "states.npz")])
    with threadpool_limits(1), deferred_interrupt() as interrupted:
        run = DynamicRun(system, observer, case.until)
        summary = loop(run, run.start(), interrupted)
    say(f"  {summary['status']}, {summary['steps_accepted']} steps, {summary['wall_seconds']:.0f} s")


class Result:
    """A run read back.

    Attributes:
        case: what was run.
        times: (n,) s, of the initial state and of every accepted step.
        q, v: (n, rows, 3) coordinates and their rates at these times.
        history: column of history.csv -> (n,).
        probes: name -> {column: (n,)}.
        summary: content of summary.json.
    """

    def __init__(self, case: Case, folder: Path):
        path = folder / case.name
        self.case = case
        with np.load(path / "states.npz") as states:
            self.times = np.concatenate([[0.0], states["times"]])
            self.q = np.concatenate([self.system.q0[None], states["q"]])
            self.v = np.concatenate([self.system.v0[None], states["v"]])
        self.history = _columns(path / "history.csv")
        probes = _columns(path / "probes.csv")
        names = dict.fromkeys(key.split(".")[0] for key in probes if "." in key)
        self.probes = {name: {c: probes[f"{name}.{c}"] for c in PROBE_COLUMNS} for name in names}
        self.summary = json.loads((path / "summary.json").read_text(encoding="utf-8"))

    @cached_property
    def system(self) -> System:
        """The equations of motion that the run was made with, its contact at the start."""
        return system_of(self.case)

    @property
    def contact(self) -> Contact | None:
        """The run's own contact, as it is at the start."""
        return system_of(self.case).contact

    @cached_property
    def surface(self) -> Surface:
        """The drawn sub-mesh with its fields."""
        return Surface(self.system)

    def submesh(self, divisions: int) -> tuple[Submesh, np.ndarray]:
        """A sub-mesh, and the (np, n) matrix that takes q to its points."""
        mesh = self.system.mesh
        submesh = build_submesh(mesh, divisions)
        return submesh, tabulate(mesh, submesh.elements, submesh.areas).interpolation(self.system.coordinates)

    def at(self, time: float) -> int:
        """Number of the accepted state nearest to a time (s)."""
        return int(np.argmin(np.abs(self.times - time)))


def _columns(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))
