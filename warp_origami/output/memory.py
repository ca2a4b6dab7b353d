"""A run kept in memory, for use from Python."""

import numpy as np

from warp_origami.model.submesh import Submesh
from warp_origami.scene import Scene
from warp_origami.solve.records import HISTORY_COLUMNS, PROBE_COLUMNS, REACTION_COLUMNS, Frame, StepRecord


class Memory:
    """Collects what a run hands out (an Observer).

    Attributes:
        scene: the scene of the run.
        surface: the drawn sub-mesh; `frames` hold its points.
        frames: frames of the animation in order of time.
        summary: content of summary.json once the run has ended.
    """

    def __init__(self):
        self.scene: Scene | None = None
        self.surface: Submesh | None = None
        self.frames: list[Frame] = []
        self.summary: dict = {}
        self._records: list[StepRecord] = []

    @property
    def history(self) -> dict[str, np.ndarray]:
        """Column of history.csv -> (n,) values, a row for the initial state and each accepted step."""
        rows = [record.history for record in self._records]
        return {column: np.array([row[column] for row in rows]) for column in HISTORY_COLUMNS}

    @property
    def probes(self) -> dict[str, np.ndarray]:
        """Name of a probe -> (n, 9) values of PROBE_COLUMNS (m, m/s, Pa) in the rows of `history`."""
        names = self._records[0].probes if self._records else ()
        return {
            name: np.array([record.probes[name] for record in self._records]).reshape(-1, len(PROBE_COLUMNS))
            for name in names
        }

    @property
    def reactions(self) -> dict[str, np.ndarray]:
        """Name of a support or driver -> (n, 6) force (N) and moment about the origin (N m) it exerts on the sheet."""
        names = self._records[0].reactions if self._records else ()
        return {
            name: np.array([record.reactions[name] for record in self._records]).reshape(-1, len(REACTION_COLUMNS))
            for name in names
        }

    @property
    def spin(self) -> dict[str, np.ndarray]:
        """Column of spin.csv -> (n,) values in the rows of `history`; empty without hub and initial spin."""
        columns = self._records[0].spin if self._records else ()
        return {column: np.array([record.spin[column] for record in self._records]) for column in columns}

    def start(self, scene: Scene, surface: Submesh, resumed_at: float | None) -> None:
        """Takes note of the scene; forgets what is newer than `resumed_at` (everything if None)."""
        limit = -np.inf if resumed_at is None else resumed_at
        self.scene, self.surface = scene, surface
        self._records = [record for record in self._records if record.history["time"] <= limit]
        self.frames = [frame for frame in self.frames if frame.time <= limit]

    def phase(self, name: str) -> None:
        """Nothing to keep."""

    def step(self, record: StepRecord) -> None:
        """Keeps a row."""
        self._records.append(record)

    def frame(self, frame: Frame) -> None:
        """Keeps a frame."""
        self.frames.append(frame)

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """Nothing to keep."""

    def save(self) -> None:
        """Nothing to do."""

    def finish(self, summary: dict) -> None:
        """Keeps the summary."""
        self.summary = summary
