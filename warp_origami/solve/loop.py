"""The loop that every run goes through, in time or in the load factor."""

import threading
from typing import Any, Protocol

from .result import Failure


class Run(Protocol):
    """An analysis; what changes during it is in its state."""

    def at_end(self, state: Any) -> bool:
        """Whether nothing is left to do."""

    def advance(self, state: Any) -> tuple[Any, Failure | None]:
        """The state after the next step, or why there is none."""

    def finish(self, state: Any, status: str, failure: Failure | None) -> dict:
        """Hands out what there is and returns the summary."""


def loop(run: Run, state: Any, interrupted: threading.Event) -> dict:
    """Steps until the end, a failure or an interrupt; returns the summary."""
    status, failure = "done", None
    while not run.at_end(state) and status == "done":
        if interrupted.is_set():
            status = "interrupted"
            continue
        state, failure = run.advance(state)
        status = "done" if failure is None else "failed"
    return run.finish(state, status, failure)
