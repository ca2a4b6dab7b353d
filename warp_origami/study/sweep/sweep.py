"""A study from its first run to its last: what is done is kept, the rest is made, table and plot are written."""

import contextlib
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from warp_origami.errors import InputError
from warp_origami.output.files import write_text

from .document import Study
from .local import Job
from .lock import locked
from .outcome import DONE, FINAL, REFUSED, WAITING, Outcome, read_outcome
from .plan import Run
from .plot import draw
from .results import numbers
from .table import Row, write_table
from .worker import SCENE

TABLE_EVERY = 5.0
"""Seconds between tables on the way, at the least."""

TABLE, PLOT = "sweep.csv", "sweep.png"


class Workers(Protocol):
    """Whoever makes the runs."""

    def run(self, jobs: Sequence[Job]) -> Iterator[tuple[Job, Outcome]]:
        """Jobs with their outcomes as they end."""


@dataclass(frozen=True)
class Progress:
    """How far a study is: runs in all, kept from before, and how many have which status."""

    runs: int
    kept: int
    statuses: dict[str, int]

    @property
    def ended(self) -> int:
        """Runs that nothing is waited for."""
        return sum(count for status, count in self.statuses.items() if status != WAITING)

    @property
    def is_final(self) -> bool:
        """Whether making any run again would give the same."""
        return set(self.statuses) <= set(FINAL)


class Sweep:
    """The runs of a study in a folder.

    Attributes:
        study, runs: what is to be done.
        folder: of the results: sweep.csv, sweep.png, and runs/<digest> for each different run.
    """

    def __init__(self, study: Study, runs: Sequence[Run], folder: Path):
        self.study, self.runs, self.folder = study, runs, folder
        self._outcomes: dict[str, Outcome] = {}
        self._numbers: dict[str, dict[str, float | None]] = {}
        self._kept: set[str] = set()
        self._next_table = 0.0

    def run(self, workers: Workers, told: Callable[[Progress], None]) -> Progress:
        """Makes what is not done yet; `told` hears of every run that ends. Table and plot are written in any case.

        Raises:
            InputError: another study is at work in the folder.
            OSError: the folder cannot be written to.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        with locked(self.folder):
            jobs = self._jobs()
            told(self.progress())
            try:
                with contextlib.closing(workers.run(jobs)) as ended:
                    for job, outcome in ended:
                        self._take(job, outcome)
                        told(self.progress())
                        self._write_now_and_then()
            finally:
                self._write()
        return self.progress()

    def progress(self) -> Progress:
        """How far it is."""
        statuses: dict[str, int] = {}
        for run in self.runs:
            status = self._outcome(run).status
            statuses[status] = statuses.get(status, 0) + 1
        return Progress(len(self.runs), sum(run.digest in self._kept for run in self.runs), statuses)

    def _jobs(self) -> list[Job]:
        """What is to be made: equal runs once, none that has its final outcome."""
        jobs = []
        for run in {run.digest: run for run in reversed(self.runs) if run.scene is not None}.values():
            folder = self._folder(run.digest)
            kept = read_outcome(folder)
            if kept is not None and kept.status in FINAL:
                self._outcomes[run.digest] = kept
                self._kept.add(run.digest)
                continue
            folder.mkdir(parents=True, exist_ok=True)
            if not (folder / SCENE).exists():
                write_text(folder / SCENE, run.scene.to_toml())
            jobs.append(Job(run.digest, folder, run.end, self.study.limit))
        return jobs[::-1]

    def _folder(self, digest: str) -> Path:
        return self.folder / "runs" / digest

    def _take(self, job: Job, outcome: Outcome) -> None:
        self._outcomes[job.digest] = outcome
        self._numbers.pop(job.digest, None)
        outcome.write(job.folder)

    def _outcome(self, run: Run) -> Outcome:
        if run.scene is None:
            return Outcome(REFUSED, run.fault)
        return self._outcomes.get(run.digest, Outcome(WAITING))

    def rows(self) -> list[Row]:
        """A row for each run; numbers of those that have any."""
        rows = []
        for run in self.runs:
            outcome = self._outcome(run)
            if outcome.status == DONE and run.digest not in self._numbers:
                self._numbers[run.digest] = numbers(self.study, self._folder(run.digest))
            rows.append(Row(run, outcome, self._numbers.get(run.digest, {})))
        return rows

    def _write_now_and_then(self) -> None:
        if time.monotonic() >= self._next_table:
            began = time.monotonic()
            write_table(self.folder / TABLE, self.study, self.rows())
            self._next_table = time.monotonic() + max(TABLE_EVERY, 20.0 * (time.monotonic() - began))

    def _write(self) -> None:
        rows = self.rows()
        write_table(self.folder / TABLE, self.study, rows)
        draw(self.folder / PLOT, self.study, rows)


def refuse_folder_of_runs(folder: Path) -> None:
    """Refuses the folder of a single run: a study would put its runs among its files.

    Raises:
        InputError: it is one.
    """
    if (folder / "checkpoint.npz").exists():
        raise InputError("--out", f"{str(folder)!r}, which holds a run", "another folder, or an empty one")
