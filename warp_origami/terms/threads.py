"""Threads that launch kernels on the CPU at the same time, each on a core of its own.

Warp's CPU kernels run on the thread that launches them, and recorded launches release the interpreter's lock. Threads
are kept on cores of their own while they are in use: an unpinned thread wakes up on the core of the one that waits for
it, and nothing runs at the same time.
"""

import math
import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

Task = Callable[[], None]

LOOK = 0.05
"""Seconds for which cores are watched before some of them are chosen."""

LATE, PAUSE = 3, 200
"""After so many times in a row that waiting for the others took longer than the own part, a core is busy with something
else: so many times this thread does all of the work."""


class Team:
    """The calling thread and `size` - 1 more."""

    def __init__(self, cores: Sequence[int] = (0,)) -> None:
        self.size = len(cores)
        self._workers = [_Worker(core) for core in cores[1:]]
        self._late, self._pause = 0, 0

    def begin(self) -> bool:
        """Whether it pays to divide the work that is to come now: not while other programs keep the cores."""
        if self._pause:
            self._pause -= 1
            return False
        return self.size > 1

    def run(self, work: Sequence[Sequence[Task]]) -> None:
        """Runs work[i] on thread i, the first on this one, and returns when all is done.

        What a thread raises is raised here. This thread also runs what is given beyond the size of the team.
        """
        given = [(worker, tasks) for worker, tasks in zip(self._workers, work[1:], strict=False) if tasks]
        start = time.perf_counter()
        for worker, tasks in given:
            worker.start(tasks)
        try:
            for tasks in (work[0], *work[self.size :]):
                _run(tasks)
        finally:
            done = time.perf_counter()
            errors = [worker.wait() for worker, _ in given]
        self._judge(done - start, time.perf_counter() - done)
        for error in errors:
            if error is not None:
                raise error

    def _judge(self, own: float, waited: float) -> None:
        self._late = self._late + 1 if waited > own else 0
        if self._late == LATE:
            self._late, self._pause = 0, PAUSE

    def end(self) -> None:
        """Ends the threads."""
        for worker in self._workers:
            worker.end()


class _Worker:
    """A thread that waits for tasks."""

    def __init__(self, core: int) -> None:
        self._tasks: queue.SimpleQueue = queue.SimpleQueue()
        self._done: queue.SimpleQueue = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._loop, args=(core,), name=f"kernels on core {core}", daemon=True)
        self._thread.start()

    def start(self, tasks: Sequence[Task]) -> None:
        self._tasks.put(tasks)

    def wait(self) -> BaseException | None:
        return self._done.get()

    def end(self) -> None:
        self._tasks.put(None)
        self._thread.join()

    def _loop(self, core: int) -> None:
        _pin({core})
        while (tasks := self._tasks.get()) is not None:
            try:
                _run(tasks)
                self._done.put(None)
            except BaseException as error:  # raised again by the thread that waits
                self._done.put(error)


_ALONE = Team()
_of_thread = threading.local()


def team() -> Team:
    """The team of the calling thread: every thread that simulates has its own."""
    return getattr(_of_thread, "team", _ALONE)


@contextmanager
def use_threads(count: int) -> Iterator[Team]:
    """Launches kernels of this thread on so many threads, at most as many as there are cores, until the end of the
    block."""
    before, home, cores = team(), _affinity(), _cores(count)
    found = _of_thread.team = Team(cores)
    if found.size > 1:
        _pin({cores[0]})
    try:
        yield found
    finally:
        _of_thread.team = before
        found.end()
        if found.size > 1:
            _pin(home)


def available_cores() -> int:
    """Number of cores that this process may use, by its affinity and by the quota of its container."""
    return max(1, min(len(_affinity()), _quota()))


def _quota() -> int:
    """Cores' worth of time that the container gives, many where it does not say."""
    try:
        time_given, period = Path("/sys/fs/cgroup/cpu.max").read_text().split()
        return math.ceil(int(time_given) / int(period))
    except (OSError, ValueError):  # no such file, or "max"
        return sys.maxsize


def _cores(count: int) -> list[int]:
    """So many of the cores that this process may use, those with the least to do; else in an order that differs from
    thread to thread and program to program, for the first one has most of the work."""
    cores = sorted(_affinity())
    first = threading.get_native_id() % len(cores)
    cores = cores[first:] + cores[:first]
    if 1 < count < len(cores):
        load = psutil.cpu_percent(LOOK, percpu=True)
        cores.sort(key=lambda core: load[core] if core < len(load) else 0.0)
    return cores[:count]


def _affinity() -> set[int]:
    if hasattr(os, "sched_getaffinity"):
        return os.sched_getaffinity(0)
    return set(range(os.cpu_count() or 1))


def _pin(cores: set[int]) -> None:
    """Keeps this thread on some cores, where the system can do that."""
    if hasattr(os, "sched_setaffinity"):
        with suppress(OSError):  # a core that has been taken away meanwhile
            os.sched_setaffinity(0, cores)


def _run(tasks: Sequence[Task]) -> None:
    for task in tasks:
        task()
