"""Newton's method on the incremental potential of a step, with a line search on its slope.

    minimize Phi(q) = 1/2 (b + alpha g) |q - q_hat|_M^2 + U(q) + U_contact(q) - W_ext(q)   over  C q = d(t)

The stiffness reduction model and contact make grad Phi piecewise smooth with stiffness jumps of 1e4, so that full steps
overshoot: the step length is found by secants on the slope d . grad Phi, until it has fallen below 0.3 of its start.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .result import Failure

MAXIMUM_ITERATIONS = 100
SLOPE_REDUCTION = 0.3
LONGEST_STEP = 4.0
MAXIMUM_SEARCH = 12


class Direction(Protocol):
    """Newton step -J^-1 grad within the constraints at one linearization point."""

    def __call__(self, gradient: np.ndarray) -> np.ndarray:
        """(3n,) step from the (3n,) gradient."""


class Potential(Protocol):
    """The function that a step minimizes, over q.ravel() (3n,)."""

    def gradient(self, q: np.ndarray) -> np.ndarray:
        """(3n,) gradient at q."""

    def linearize(self, q: np.ndarray) -> "tuple[np.ndarray, Direction] | Failure":
        """Gradient and Newton direction at q."""

    def size(self, step: np.ndarray) -> float:
        """How large a step is, m."""


@dataclass(frozen=True)
class NewtonResult:
    """Where the iteration ended.

    Attributes:
        q: (3n,) the last iterate.
        iterations: number of linearizations (each one factorization, or two where the first is not definite).
        failure: None if converged.
    """

    q: np.ndarray
    iterations: int
    failure: Failure | None = None


def minimize(potential: Potential, start: np.ndarray, tolerance: float) -> NewtonResult:
    """Iterates from `start` until a Newton step is smaller than `tolerance` (m)."""
    q = start
    for iteration in range(1, MAXIMUM_ITERATIONS + 1):
        found = newton_step(potential, q)
        if isinstance(found, Failure):
            return NewtonResult(q, iteration, found)
        step, slope = found
        if potential.size(step) < tolerance:
            return NewtonResult(q + step, iteration)
        q = q + line_search(potential, q, step, slope) * step
    return NewtonResult(
        q,
        MAXIMUM_ITERATIONS,
        Failure(f"Newton did not converge in {MAXIMUM_ITERATIONS} iterations", "smaller steps or tolerance"),
    )


def newton_step(potential: Potential, q: np.ndarray) -> tuple[np.ndarray, float] | Failure:
    """Newton step (3n,) at q and the slope of the potential along it."""
    linearized = potential.linearize(q)
    if isinstance(linearized, Failure):
        return linearized
    gradient, direction = linearized
    step = direction(gradient)
    if not np.isfinite(potential.size(step)):
        return Failure("the Newton step is not a number", "smaller steps")
    return step, float(gradient @ step)


def line_search(potential: Potential, q: np.ndarray, step: np.ndarray, slope: float) -> float:
    """Length of the step along which the slope of the potential has fallen to a third, by bracketed secants.

    The slope is negative at zero; where it is not (an indefinite system) the full step is taken and left to the next
    iteration to judge.
    """
    if slope >= 0.0:
        return 1.0
    low, slope_low = 0.0, slope
    high, slope_high = None, None
    length = 1.0
    for _ in range(MAXIMUM_SEARCH):
        slope_here = float(potential.gradient(q + length * step) @ step)
        if not np.isfinite(slope_here):
            slope_here = np.inf
        if abs(slope_here) <= SLOPE_REDUCTION * abs(slope):
            return length
        if slope_here < 0.0:
            if length >= LONGEST_STEP:
                return length
            low, slope_low = length, slope_here
        else:
            high, slope_high = length, slope_here
        if high is None:
            secant = low - slope_low * low / (slope_low - slope) if slope_low > slope else LONGEST_STEP
            length = min(max(secant, 1.5 * low), LONGEST_STEP)
        else:
            secant = low - slope_low * (high - low) / (slope_high - slope_low) if np.isfinite(slope_high) else low
            width = high - low
            length = min(max(secant, low + 0.1 * width), high - 0.1 * width)
    return length
