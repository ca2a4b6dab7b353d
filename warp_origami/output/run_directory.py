"""The folder of a run: tables, animation, summary, checkpoint, readable at any moment."""

import json
import math
import time
from pathlib import Path

import numpy as np

from warp_origami.errors import InputError
from warp_origami.model.submesh import Submesh
from warp_origami.scene import Scene, load_scene
from warp_origami.solve.records import HISTORY_COLUMNS, PROBE_COLUMNS, REACTION_COLUMNS, Frame, StepRecord

from .checkpoint import pattern_identity, read_checkpoint, write_checkpoint
from .files import CsvFile, cut_rows, last_time, write_text
from .report.page import NAME, build_report
from .usd import Animation

SAVING_SHARE = 0.02
"""Share of the elapsed time that saving the animation and the checkpoint may take."""

TABLES = ("history", "probes", "reactions")

FILES = (
    "checkpoint.npz",  # first: without it nothing is mistaken for a run that can go on
    "summary.json",
    "animation.usdc",
    "history.csv",
    "probes.csv",
    "reactions.csv",
    "spin.csv",
    "scene.toml",
    NAME,
)


class RunDirectory:
    """Writes the files of a run (an Observer).

    Rows are appended as they come. The animation and the checkpoint it belongs to are saved together, at intervals that
    grow with the cost of saving, and at the end.

    Attributes:
        report_failure: why there is no report.html after `finish`; None if there is one.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self._tables: dict[str, CsvFile] | None = None
        self._pending: dict[str, np.ndarray] | None = None
        self._next_save = 0.0
        self.report_failure: str | None = None

    def start(self, scene: Scene, surface: Submesh, resumed_at: float | None) -> None:
        """Makes the folder, or replaces the files of an earlier run there, or cuts them at `resumed_at`.

        Raises:
            InputError: no folder can be made there, or what is there does not reach up to `resumed_at`.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError("--out", f"{str(self.path)!r} ({error.strerror})", "a folder that can be made") from None
        # modes are drawn from their beginning at the end of the run
        drawn_until = None if scene.analysis.kind == "modal" else resumed_at
        animation = Animation(self.path / "animation.usdc", scene, surface, drawn_until)
        if resumed_at is not None:
            tables = (*TABLES, "spin") if scene.turns else TABLES
            cut_rows([self.path / f"{name}.csv" for name in tables], resumed_at)
        stale = FILES if resumed_at is None else ("summary.json", NAME)
        for name in stale:
            (self.path / name).unlink(missing_ok=True)
        write_text(self.path / "scene.toml", scene.to_toml())
        self._identity = pattern_identity(scene)
        self._resumed = resumed_at is not None
        self._animation = animation

    def phase(self, name: str) -> None:
        """Nothing to write."""

    def step(self, record: StepRecord) -> None:
        """Appends a row to each table."""
        if self._tables is None:
            self._tables = self._open_tables(record)
        time = record.history["time"]
        self._tables["history"].append([record.history[column] for column in HISTORY_COLUMNS])
        self._tables["probes"].append([time, *(value for values in record.probes.values() for value in values)])
        self._tables["reactions"].append([time, *(value for values in record.reactions.values() for value in values)])
        if record.spin:
            self._tables["spin"].append([time, *record.spin.values()])

    def _open_tables(self, record: StepRecord) -> dict[str, CsvFile]:
        probes = [f"{name}.{column}" for name in record.probes for column in PROBE_COLUMNS]
        reactions = [f"{name}.{column}" for name in record.reactions for column in REACTION_COLUMNS]
        columns = {"history": HISTORY_COLUMNS, "probes": ("time", *probes), "reactions": ("time", *reactions)}
        if record.spin:
            columns["spin"] = ("time", *record.spin)
        return {name: CsvFile(self.path / f"{name}.csv", columns[name], self._resumed) for name in columns}

    def frame(self, frame: Frame) -> None:
        """Adds a frame to the animation."""
        self._animation.add(frame)

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """Saves the animation and the checkpoint if that is due, else keeps the arrays for the end."""
        self._pending = {name: np.array(values) for name, values in arrays.items()}
        now = time.monotonic()
        if now < self._next_save:
            return
        self.save()
        cost = time.monotonic() - now
        self._next_save = time.monotonic() + cost / SAVING_SHARE

    def save(self) -> None:
        """Saves the animation and, if there is a newer one, the checkpoint, after all that it stands for."""
        for table in (self._tables or {}).values():
            table.sync()
        self._animation.save()
        if self._pending is not None:
            write_checkpoint(self.path / "checkpoint.npz", self._pending, self._identity)
            self._pending = None

    def finish(self, summary: dict) -> None:
        """Writes the summary, and the page last: what goes wrong with it is no fault of the run."""
        for table in (self._tables or {}).values():
            table.close()
        write_text(self.path / "summary.json", json.dumps(_jsonable(summary), indent=2) + "\n")
        try:
            build_report(self.path)
        except KeyboardInterrupt:
            self.report_failure = "interrupted"
        except Exception as error:
            self.report_failure = f"{type(error).__name__}: {error}"


def _jsonable(value: object) -> object:
    """Plain JSON: NumPy values as numbers and lists, numbers that are not finite as null."""
    if isinstance(value, dict):
        return {str(key): _jsonable(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_jsonable(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def read_run(path: Path, scene: Scene) -> dict[str, np.ndarray] | None:
    """The checkpoint of the run in `path`; None if it has none.

    Raises:
        InputError: the run there is of another scene, or its checkpoint cannot be read.
    """
    checkpoint, written = path / "checkpoint.npz", path / "scene.toml"
    if not checkpoint.exists():
        return None
    if not written.exists() or load_scene(written) != scene:
        raise InputError("--resume", f"{path} with a run of another scene", f"the scene in {written}, unchanged")
    return read_checkpoint(checkpoint, pattern_identity(scene))


def is_finished(path: Path, until: float) -> bool:
    """Whether the run in `path` has ended well at `until` (s) or later."""
    summary = path / "summary.json"
    if not summary.exists():
        return False
    reached = last_time(path / "history.csv")
    try:
        done = json.loads(summary.read_text(encoding="utf-8")).get("status") == "done"
    except (ValueError, AttributeError):  # damaged: then the checkpoint decides
        done = False
    return done and reached is not None and reached >= until * (1.0 - 1e-12)
