"""Step size from the local error, with hysteresis: changes of the step cost accuracy in the index-3 equations."""

from dataclasses import dataclass
from typing import Protocol

SAFETY = 0.9
LARGEST_GROWTH = 2.0
LARGEST_SHRINK = 0.3
GROW_ABOVE = 1.25


class StepSizeController(Protocol):
    """Decides on acceptance and on the next step; it has no state of its own."""

    first: float

    def judge(self, step: float, error: float) -> tuple[bool, float]:
        """Whether a step (s) with this relative local error (1 = tolerance) is accepted, and the step to go on with."""

    def after_failure(self, step: float) -> float | None:
        """The step to retry with after a failure (Newton, energy), None if there is none."""


@dataclass(frozen=True)
class AdaptiveStep:
    """Error per step held below the tolerance for a method whose local error is of third order.

    Attributes:
        first: s, the first step.
        smallest: s, below which the run gives up.
        largest: s.
    """

    first: float
    smallest: float
    largest: float

    def judge(self, step: float, error: float) -> tuple[bool, float]:
        factor = SAFETY * max(error, 1e-9) ** (-1.0 / 3.0)
        if error > 1.0:
            return False, max(step * max(min(factor, SAFETY), LARGEST_SHRINK), self.smallest)
        if factor < 1.0 or factor > GROW_ABOVE:
            return True, min(step * min(max(factor, LARGEST_SHRINK), LARGEST_GROWTH), self.largest)
        return True, step

    def after_failure(self, step: float) -> float | None:
        return 0.5 * step if 0.5 * step >= self.smallest else None


@dataclass(frozen=True)
class FixedStep:
    """The same step all along; a failed step ends the run."""

    first: float

    def judge(self, step: float, error: float) -> tuple[bool, float]:
        return True, self.first

    def after_failure(self, step: float) -> float | None:
        return None
