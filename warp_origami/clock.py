"""Wall time by phase of a run."""

import time
from contextlib import AbstractContextManager

PHASES = ("compile", "setup", "assembly", "contact", "factorization", "solve", "output", "other")


class PhaseClock:
    """Adds up wall seconds per phase; phases nest, each second counts for the innermost one only.

    Attributes:
        seconds: phase -> wall seconds so far; "other" is what runs outside of any phase.
    """

    def __init__(self, started: float | None = None):
        """`started` is the time.perf_counter() that "other" counts from, now by default."""
        self.seconds = dict.fromkeys(PHASES, 0.0)
        self._stack = ["other"]
        self._since = time.perf_counter() if started is None else started

    def _switch(self) -> None:
        now = time.perf_counter()
        self.seconds[self._stack[-1]] += now - self._since
        self._since = now

    def phase(self, name: str) -> AbstractContextManager[None]:
        """Counts the block for phase `name`."""
        return _Phase(self, name)

    def _begin(self, name: str) -> None:
        self._switch()
        self._stack.append(name)

    def _end(self) -> None:
        self._switch()
        self._stack.pop()

    def total(self) -> float:
        """Wall seconds since the start; equals the sum of `seconds`."""
        self._switch()
        return sum(self.seconds.values())


class _Phase(AbstractContextManager):
    """A block of a phase; entered tens of times an iteration, so that a generator would be felt."""

    __slots__ = ("_clock", "_name")

    def __init__(self, clock: PhaseClock, name: str):
        self._clock, self._name = clock, name

    def __enter__(self) -> None:
        self._clock._begin(self._name)

    def __exit__(self, *_: object) -> None:
        self._clock._end()
