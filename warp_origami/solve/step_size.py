"""Step size from the local error, with hysteresis: changes of the step cost accuracy in the index-3 equations."""

from dataclasses import dataclass
from typing import Protocol

SAFETY = 0.9
LARGEST_GROWTH = 2.0
LARGEST_SHRINK = 0.3
GROW_ABOVE = 1.25

LONGEST_WAIT = 7
"""Accepted steps after which a longer one is tried again where these have created energy, at the most."""

PROPORTIONAL_BELOW = 5e-5
"""Tolerance below which the error of smooth motion is to be in proportion to it."""


def error_bound(tolerance: float) -> float:
    """What the local error of a step is kept below, both relative to the size of the sheet.

    Steps of a local error c h^3 each leave the error c h^2 T after a time T: with c h^3 = tolerance it would fall with
    the power 2/3 of the tolerance only. So small tolerances are undercut, by a bound that falls with the power 3/2.
    """
    return tolerance * min(1.0, (tolerance / PROPORTIONAL_BELOW) ** 0.5)


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
class Patience:
    """How long steps are kept from growing after longer ones have created energy.

    A sheet that rings at frequencies beyond the step creates energy above some step, whatever the local error: without
    patience every other step would be one too long, and refused. The wait doubles each time that growing has failed.

    Attributes:
        length: accepted steps to wait for after the next refusal.
        left: accepted steps that are still to be waited for.
    """

    length: int = 0
    left: int = 0

    def after_refusal(self) -> "Patience":
        """After a step whose longer trials were refused."""
        return Patience(min(2 * self.length + 1, LONGEST_WAIT), self.length)

    def after_step(self, grown: bool) -> "Patience":
        """After a step that was accepted at once; `grown`: it was longer than the one before."""
        if self.left > 0:
            return Patience(self.length, self.left - 1)
        return Patience(self.length // 2 if grown else self.length)


@dataclass(frozen=True)
class FixedStep:
    """The same step all along; a failed step ends the run."""

    first: float

    def judge(self, step: float, error: float) -> tuple[bool, float]:
        return True, self.first

    def after_failure(self, step: float) -> float | None:
        return None
