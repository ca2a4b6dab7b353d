"""Measured runs as processes of their own, several at a time, whose results stay in a folder."""

import json
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warp_origami.machine import machine
from warp_origami.output.files import write_text
from warp_origami.scene import Scene

from .measurement import LOG, SCENE, TOLD, VERTICES, Measurement

GRACE = 30.0
"""Seconds after its limit at which a process that has not ended by itself (within a step) is killed."""


@dataclass(frozen=True)
class Job:
    """A run to be made.

    Attributes:
        label: what it is called; different for every job in a folder.
        scene: to run.
        vertices: (k,) numbers of the vertices to keep, -1 where there is none.
        until: end of the run, s or load factor.
        least: a run that got this far, made earlier, will do.
        limit: seconds of wall time.
    """

    label: str
    scene: Scene
    vertices: np.ndarray
    until: float
    least: float
    limit: float


@dataclass(frozen=True)
class Running:
    """A job under way, with the time.monotonic() of its start."""

    job: Job
    process: subprocess.Popen
    started: float

    @property
    def late(self) -> float:
        """Seconds past its limit."""
        return time.monotonic() - self.started - self.job.limit


class SideBySide:
    """Runs jobs, `count` at a time, and keeps their files in a folder, which is made if it is not there."""

    def __init__(self, folder: Path, count: int):
        self.folder, self.count = folder, count
        self.conditions = machine() | {"side_by_side": count}
        self.running: list[Running] = []

    def run(self, jobs: Iterator[Job]) -> Iterator[tuple[Job, Measurement, bool]]:
        """Jobs with their measurements as they end, and whether they were there already.

        The next job is asked for when a place is free. On any exception the processes under way are ended.
        """
        more = True
        try:
            while more or self.running:
                while more and len(self.running) < self.count:
                    job = next(jobs, None)
                    more = job is not None
                    kept = self._kept(job) if more else None
                    if kept is not None:
                        yield job, kept, True
                    elif more and job.limit <= 0.0:
                        yield job, Measurement.without("not run", "no time was left"), False
                    elif more:
                        self.running.append(self._start(job))
                for one in [one for one in self.running if one.process.poll() is not None]:
                    self.running.remove(one)
                    yield one.job, self._ended(one), False
                for one in self.running:
                    if one.late > GRACE:
                        one.process.kill()
                time.sleep(0.02)
        finally:
            for one in self.running:
                one.process.kill()
                one.process.wait()
            self.running.clear()

    def _folder(self, job: Job) -> Path:
        return self.folder / re.sub(r"[^\w.+-]+", "_", job.label)

    def _kept(self, job: Job) -> Measurement | None:
        """The measurement of an earlier run of the same scene under the same conditions, if it will do."""
        folder = self._folder(job)
        try:
            told = json.loads((folder / TOLD).read_text(encoding="utf-8"))
            same = (folder / SCENE).read_text(encoding="utf-8") == job.scene.to_toml()
            if not same or told["conditions"] != self.conditions:
                return None
            if not np.array_equal(np.load(folder / VERTICES), job.vertices):
                return None
            found = Measurement.read(folder)
        except (OSError, ValueError, KeyError):  # not there, or damaged
            return None
        if found.status == "timed out":
            reached = len(found.times) > 0 and found.times[-1] >= job.least
            return found if reached or told["limit"] >= 0.9 * job.limit else None
        return found if found.status != "done" or told["until"] >= job.least * (1.0 - 1e-12) else None

    def _start(self, job: Job) -> Running:
        folder = self._folder(job)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / TOLD).unlink(missing_ok=True)
        write_text(folder / SCENE, job.scene.to_toml())
        np.save(folder / VERTICES, job.vertices)
        arguments = [str(folder), repr(job.until), repr(job.limit), json.dumps(self.conditions)]
        with (folder / LOG).open("w", encoding="utf-8") as log:
            # in a session of its own: Ctrl-C reaches this program alone, which then ends what it started
            process = subprocess.Popen(
                [sys.executable, "-m", "warp_origami.study.measured.worker", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        return Running(job, process, time.monotonic())

    def _ended(self, one: Running) -> Measurement:
        folder = self._folder(one.job)
        if (folder / TOLD).exists():
            return Measurement.read(folder)
        lines = (folder / LOG).read_text(encoding="utf-8", errors="replace").strip().splitlines()
        message = f"exit code {one.process.returncode}" + (f": {lines[-1]}" if lines else "")
        return Measurement.without("timed out" if one.late > 0.0 else "failed", message)
