"""What a run hands out while it goes on: one record per accepted step, frames for the animation, the end."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from warp_origami.model.submesh import Submesh
from warp_origami.scene import Scene

HISTORY_COLUMNS = (
    "time",
    "step",
    "kinetic_energy",
    "strain_energy",
    "contact_energy",
    "dissipated",
    "external_work",
    "energy_error",
    "newton_iterations",
    "contacts_sts",
    "contacts_nts",
    "contacts_edge",
    "max_penetration",
    "taut",
    "wrinkled",
    "slack",
)
PROBE_COLUMNS = ("x", "y", "z", "vx", "vy", "vz", "von_mises", "s1", "s2")
REACTION_COLUMNS = ("fx", "fy", "fz", "mx", "my", "mz")
SPIN_COLUMNS = ("rate", "moment_of_inertia", "angular_momentum.x", "angular_momentum.y", "angular_momentum.z")


@dataclass(frozen=True)
class StepRecord:
    """The initial state or one accepted step.

    Attributes:
        history: value of each of HISTORY_COLUMNS (energies in J, step in s, penetration in m, area fractions).
        probes: name -> (9,) values of PROBE_COLUMNS (m, m/s, Pa).
        reactions: name of a support or driver -> (6,) force (N) and moment about the origin (N m) on the sheet.
        spin: value of each of SPIN_COLUMNS (rad/s, kg m^2, N m s); empty for a scene without hub and initial spin.
    """

    history: dict[str, float]
    probes: dict[str, np.ndarray]
    reactions: dict[str, np.ndarray]
    spin: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Frame:
    """The drawn surface at one time.

    Attributes:
        time: s.
        points: (np, 3) points of the drawn sub-mesh, m.
        nodes: (nv, 3) element corners in the order of the mesh's vertices, m.
        fields: name -> (np,) values of the scene's output fields at the points.
    """

    time: float
    points: np.ndarray
    nodes: np.ndarray
    fields: dict[str, np.ndarray]


class Observer(Protocol):
    """Whoever wants to know how a run goes: files, progress bar, memory. Every method may be called many times but
    `start` and `finish`."""

    def start(self, scene: Scene, surface: Submesh, resumed_at: float | None) -> None:
        """The run begins; with `resumed_at` everything newer than that time (s) is to be forgotten."""

    def phase(self, name: str) -> None:
        """What the program is busy with before the first step, e.g. "compiling kernels"."""

    def step(self, record: StepRecord) -> None:
        """An accepted step (or the initial state)."""

    def frame(self, frame: Frame) -> None:
        """A frame of the animation; times are increasing."""

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """State from which the run can go on with the same results; called after the rows and frames it covers."""

    def save(self) -> None:
        """The run is about to end: everything handed out so far is to be kept."""

    def finish(self, summary: dict) -> None:
        """The run ended, with whatever status; `summary` is the content of summary.json."""
