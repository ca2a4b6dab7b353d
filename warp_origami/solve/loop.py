"""The loop that every run goes through, in time or in the load factor."""

import threading
from typing import Any, Protocol

from .result import Failure

MAKE_ROOM = "make room or let the folder be written to, then go on with --resume"


class Run(Protocol):
    """An analysis; what changes during it is in its state."""

    def at_end(self, state: Any) -> bool:
        """Whether nothing is left to do."""

    def advance(self, state: Any) -> tuple[Any, Failure | None]:
        """The state after the next step, or why there is none."""

    def finish(self, state: Any, status: str, failure: Failure | None) -> dict:
        """Hands out what there is and returns the summary."""

    def give_up(self, state: Any, failure: Failure) -> dict:
        """Returns the summary of a run whose results cannot be handed out any more."""


def loop(run: Run, state: Any, interrupted: threading.Event) -> dict:
    """Steps until the end, a failure or an interrupt; returns the summary.

    Where an observer cannot write (a full disk), the run ends there: what it has written last stays.
    """
    status, failure = "done", None
    try:
        while not run.at_end(state) and status == "done":
            if interrupted.is_set():
                status = "interrupted"
                continue
            state, failure = run.advance(state)
            status = "done" if failure is None else "failed"
        return run.finish(state, status, failure)
    except BrokenPipeError:  # of whoever watches, not of the results
        raise
    except OSError as error:
        return run.give_up(state, Failure(f"results cannot be written: {error}", MAKE_ROOM))
