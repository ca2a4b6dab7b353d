"""Runs in processes on this machine, each on one thread."""

import json
import queue
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from warp_origami.terms.threads import available_cores

from .outcome import LOST, Outcome

COMMAND = [sys.executable, "-m", "warp_origami.study.sweep.worker"]
"""Starts a worker."""

TRIES = 3
"""How often a run is begun or resumed whose worker dies."""

STARTS = 3
"""So many workers in a row that die before they can work end the study."""

GRACE = 10.0
"""Seconds that workers have to save what they have when the study is interrupted."""


class NoWorkers(RuntimeError):
    """Workers cannot be started."""


@dataclass(frozen=True)
class Job:
    """A run to be made.

    Attributes:
        digest: names it.
        folder: with its scene.toml.
        until: end of the run, s or load factor.
        limit: s of wall time, None without one.
    """

    digest: str
    folder: Path
    until: float
    limit: float | None


@dataclass(eq=False)
class _Worker:
    """A process, what it is at, and what it has written to its standard error."""

    process: subprocess.Popen
    errors: BinaryIO
    job: Job | None = None
    ready: bool = False
    relay: threading.Thread | None = None

    def last_words(self) -> str:
        """Last line of the standard error."""
        self.errors.seek(0)
        lines = self.errors.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else ""


class LocalWorkers:
    """Makes runs, so many at a time."""

    def __init__(self, count: int | None = None):
        """`count` processes at the most, as many as there are cores by default."""
        self.count = count or available_cores()
        self._workers: list[_Worker] = []
        self._heard: queue.Queue[tuple[_Worker, bytes]] = queue.Queue()
        self._tries: dict[str, int] = {}
        self._stillborn = 0

    @property
    def processes(self) -> list[int]:
        """Identifiers of the processes at work."""
        return [worker.process.pid for worker in self._workers if worker.job is not None]

    def run(self, jobs: Sequence[Job]) -> Iterator[tuple[Job, Outcome]]:
        """Jobs with their outcomes as they end. On any exception, and when it is closed, the processes end.

        Raises:
            NoWorkers: workers die before they can work.
        """
        waiting, self._heard = deque(jobs), queue.Queue()
        try:
            while waiting or any(worker.job for worker in self._workers):
                while len(self._workers) < min(self.count, len(waiting) + len(self.processes)):
                    self._workers.append(_start(self._heard))
                for worker in self._workers:
                    if worker.ready and worker.job is None and waiting:
                        self._give(worker, waiting.popleft())
                with suppress(queue.Empty):  # waits in parts, so that Ctrl-C is heard everywhere
                    yield from self._listen(*self._heard.get(timeout=1.0), waiting)
        finally:
            self.close()

    def _give(self, worker: _Worker, job: Job) -> None:
        worker.job = job
        self._tries[job.digest] = self._tries.get(job.digest, 0) + 1
        asked = {"folder": str(job.folder.absolute()), "until": job.until, "limit": job.limit}
        with suppress(BrokenPipeError):  # it has died; its end will be heard
            worker.process.stdin.write(json.dumps(asked).encode() + b"\n")
            worker.process.stdin.flush()

    def _listen(self, worker: _Worker, line: bytes, waiting: deque[Job]) -> Iterator[tuple[Job, Outcome]]:
        """What follows from a line of a worker, or, where it is empty, from its death."""
        if not line:
            yield from self._bury(worker, waiting)
            return
        told = json.loads(line)
        if "ready" in told:
            worker.ready, self._stillborn = True, 0
        elif worker.job is not None:
            job, worker.job = worker.job, None
            yield job, Outcome(told["status"], told["message"])

    def _bury(self, worker: _Worker, waiting: deque[Job]) -> Iterator[tuple[Job, Outcome]]:
        """A worker has died: its run is put back, or given up after TRIES."""
        self._workers.remove(worker)
        code, words = worker.process.wait(), worker.last_words()
        _close(worker)
        how = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
        if not worker.ready:
            self._stillborn += 1
            if self._stillborn == STARTS:
                raise NoWorkers(f"workers die before they can work ({how}): {words}")
        job = worker.job
        if job is None:
            return
        if self._tries[job.digest] < TRIES:
            waiting.append(job)
            return
        yield job, Outcome(LOST, f"its worker died {TRIES} times, last {how}" + (f": {words}" if words else ""))

    def close(self) -> None:
        """Ends all processes; those at work save a checkpoint if they can do so within GRACE."""
        for worker in self._workers:
            worker.process.terminate()
        deadline = time.monotonic() + GRACE
        for worker in self._workers:
            with suppress(subprocess.TimeoutExpired):
                worker.process.wait(max(0.0, deadline - time.monotonic()))
            worker.process.kill()
            worker.process.wait()
            _close(worker)
        self._workers.clear()


def _start(heard: queue.Queue) -> _Worker:
    """A worker whose lines, and an empty one at its end, get into a queue."""
    errors = tempfile.TemporaryFile()
    process = subprocess.Popen(
        COMMAND,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        start_new_session=True,  # Ctrl-C reaches this program alone, which then ends what it started
    )
    worker = _Worker(process, errors)
    worker.relay = threading.Thread(target=_relay, args=(worker, heard), daemon=True)
    worker.relay.start()
    return worker


def _relay(worker: _Worker, heard: queue.Queue) -> None:
    for line in worker.process.stdout:
        if line.endswith(b"\n"):  # else it died while it wrote
            heard.put((worker, line))
    heard.put((worker, b""))


def _close(worker: _Worker) -> None:
    """Closes the pipes of a process that has ended."""
    worker.relay.join()
    with suppress(BrokenPipeError):
        worker.process.stdin.close()
    worker.process.stdout.close()
    worker.errors.close()
