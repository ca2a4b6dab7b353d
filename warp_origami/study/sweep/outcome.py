"""What came of a run of a study, as it is kept beside its results."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from warp_origami.output.files import write_text

FILE = "outcome.json"

DONE, FAILED, REFUSED = "done", "failed", "refused"
LATE, LOST, UNWRITTEN, WAITING = "out of time", "lost", "not written", "waiting"
FINAL = (DONE, FAILED, REFUSED)
"""Making the run again would give the same."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes:
        status: done, failed (the numerics), refused (it cannot be modelled); or, to be tried again when the study is
            started again: out of time, lost (its worker died each time), not written (a full disk), waiting.
        message: reason and advice.
    """

    status: str
    message: str = ""

    @property
    def is_final(self) -> bool:
        """Whether it is not to be tried again."""
        return self.status in FINAL

    def write(self, folder: Path) -> None:
        """Keeps it in the folder of the run."""
        write_text(folder / FILE, json.dumps(asdict(self), indent=1) + "\n")


def read_outcome(folder: Path) -> Outcome | None:
    """The outcome of an earlier run in a folder; None where there is none, or a damaged one."""
    try:
        told = json.loads((folder / FILE).read_text(encoding="utf-8"))
        return Outcome(str(told["status"]), str(told["message"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None
