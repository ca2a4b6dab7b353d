"""Wall time by phase of a run."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

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

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Counts the block for phase `name`."""
        self._switch()
        self._stack.append(name)
        try:
            yield
        finally:
            self._switch()
            self._stack.pop()

    def total(self) -> float:
        """Wall seconds since the start; equals the sum of `seconds`."""
        self._switch()
        return sum(self.seconds.values())
