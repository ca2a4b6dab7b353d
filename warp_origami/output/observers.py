"""Several observers of one run as one."""

from collections.abc import Iterable
from contextlib import ExitStack

import numpy as np

from warp_origami.model.submesh import Submesh
from warp_origami.scene import Scene
from warp_origami.solve.records import Frame, Observer, StepRecord


class Observers:
    """Tells each of several observers, in their order, what it is told."""

    def __init__(self, observers: Iterable[Observer]):
        self.observers = tuple(observers)

    def start(self, scene: Scene, surface: Submesh, resumed_at: float | None) -> None:
        """See Observer."""
        for observer in self.observers:
            observer.start(scene, surface, resumed_at)

    def phase(self, name: str) -> None:
        """See Observer."""
        for observer in self.observers:
            observer.phase(name)

    def step(self, record: StepRecord) -> None:
        """See Observer."""
        for observer in self.observers:
            observer.step(record)

    def frame(self, frame: Frame) -> None:
        """See Observer."""
        for observer in self.observers:
            observer.frame(frame)

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """See Observer."""
        for observer in self.observers:
            observer.checkpoint(arrays)

    def save(self) -> None:
        """See Observer."""
        for observer in self.observers:
            observer.save()

    def finish(self, summary: dict) -> None:
        """See Observer."""
        with ExitStack() as each:  # also if one of them fails
            for observer in reversed(self.observers):
                each.callback(observer.finish, summary)
