"""What a measured run leaves in its folder."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warp_origami.solve.records import HISTORY_COLUMNS

SCENE, VERTICES, ARRAYS, TOLD, LOG = "scene.toml", "vertices.npy", "arrays.npz", "measurement.json", "log.txt"
"""Files in the folder of a run."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a run left.

    Attributes:
        status: done, failed, refused (wrong input), timed out, or not run.
        message: why it is not done.
        summary: content of summary.json, empty where the run did not begin.
        values: of the scene's [verification], in their order.
        times: (n,) of frames, s or load factor.
        seconds, processor: (n,) wall time and processor time since the process had imported what it needs.
        processor_seconds: of the whole run.
        imports: s of wall time from the start of the process until then.
        memory: (n,) peak memory so far, bytes.
        positions: (n, k, 3) of the compared vertices; NaN where the mesh has none, m.
        history: column of history.csv -> values.
    """

    status: str
    message: str
    summary: dict
    values: tuple[float, ...]
    times: np.ndarray
    seconds: np.ndarray
    processor: np.ndarray
    memory: np.ndarray
    positions: np.ndarray
    history: dict[str, np.ndarray]
    processor_seconds: float = float("nan")
    imports: float = float("nan")

    @classmethod
    def read(cls, folder: Path) -> "Measurement":
        """The measurement that a process left in its folder."""
        told = json.loads((folder / TOLD).read_text(encoding="utf-8"))
        if told["status"] == "refused":
            return cls.without(told["status"], told["message"])
        values = tuple(float("nan") if value is None else value for value in told["values"])
        with np.load(folder / ARRAYS) as kept:
            history = dict(zip(HISTORY_COLUMNS, kept["history"].T, strict=True))
            measured = [kept[name] for name in ("times", "seconds", "processor", "memory", "positions")]
        return cls(
            told["status"],
            told["message"],
            told["summary"],
            values,
            *measured,
            history,
            told["processor_seconds"],
            told["imports"],
        )

    @classmethod
    def without(cls, status: str, message: str) -> "Measurement":
        """Of a run that gave nothing."""
        none = np.zeros(0)
        return cls(status, message, {}, (), none, none, none, none, np.zeros((0, 0, 3)), {})
