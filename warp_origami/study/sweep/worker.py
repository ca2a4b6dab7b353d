"""A process that makes runs, one after the other.

    python -m warp_origami.study.sweep.worker

reads lines {"folder": ..., "until": ..., "limit": ...} and answers each, when the run in that folder (its scene.toml)
has ended, with its outcome. Runs go on from their checkpoints. Where whoever started it is gone, it saves and ends.
"""

import json
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from warp_origami.errors import InputError
from warp_origami.model.submesh import Submesh
from warp_origami.output.observers import Observers
from warp_origami.output.run_directory import RunDirectory, is_finished, read_run
from warp_origami.scene import Scene, load_scene
from warp_origami.solve.records import Frame, StepRecord
from warp_origami.solve.simulate import simulate

from .outcome import DONE, FAILED, LATE, REFUSED, UNWRITTEN, WAITING, Outcome

SCENE = "scene.toml"


class Watch:
    """Ends a run that is out of time, or that nobody waits for any more (an Observer)."""

    def __init__(self, limit: float | None):
        self.parent, self.late = os.getppid(), False
        self.deadline = np.inf if limit is None else time.monotonic() + limit

    def start(self, scene: Scene, surface: Submesh, resumed_at: float | None) -> None:
        """Nothing to watch."""

    def phase(self, name: str) -> None:
        """Nothing to watch."""

    def step(self, record: StepRecord) -> None:
        """Interrupts the run where it is time; it ends after this step, with a checkpoint."""
        self.late = time.monotonic() > self.deadline
        if self.late or os.getppid() != self.parent:
            signal.raise_signal(signal.SIGTERM)

    def frame(self, frame: Frame) -> None:
        """Nothing to watch."""

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """Nothing to watch."""

    def save(self) -> None:
        """Nothing to watch."""

    def finish(self, summary: dict) -> None:
        """Nothing to watch."""


def run_in(folder: Path, until: float, limit: float | None) -> Outcome:
    """Makes the run of a folder, or what is left of it, on one thread."""
    watch = Watch(limit)
    try:
        scene = load_scene(folder / SCENE)
        if is_finished(folder, until):
            return Outcome(DONE)
        told = simulate(
            scene, Observers([RunDirectory(folder), watch]), until=until, resume=read_run(folder, scene), threads=1
        )
    except InputError as error:
        return Outcome(REFUSED, str(error).replace("\n", "; "))
    except OSError as error:
        return Outcome(UNWRITTEN, str(error))
    message = "; ".join(told[key] for key in ("message", "advice") if told.get(key))
    if told["status"] == "interrupted":
        return Outcome(LATE, f"stopped after {limit:g} s; a larger limit") if watch.late else Outcome(WAITING)
    if told["status"] == "failed":
        return Outcome(UNWRITTEN if told.get("resumable") else FAILED, message)
    return Outcome(DONE, message)


def main() -> None:
    """Answers until there is nothing more to read."""
    import warp

    warp.config.log_level = warp.LOG_WARNING
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever else writes to the standard output does not answer
    _answer(answers, {"ready": True})
    for line in sys.stdin:
        asked = json.loads(line)
        outcome = run_in(Path(asked["folder"]), asked["until"], asked["limit"])
        _answer(answers, {"status": outcome.status, "message": outcome.message})
        if outcome.status == WAITING:  # interrupted
            return


def _answer(stream, content: dict) -> None:
    stream.write(json.dumps(content) + "\n")
    stream.flush()


if __name__ == "__main__":
    main()
