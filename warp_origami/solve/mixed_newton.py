"""Newton's method with strains of their own at the quadrature points: the mixed, strain-independent iteration.

    sigma = S(e) + C(e) (E(q) - e),      J d = -grad Phi with sigma for S, C(e) for C and S(e) in the geometric part
    q <- q + l d,                        e' = (1 - l) e + l (E(q) + E'(q) d)
    e  with  e + S(e) / m = e' + (S(e) + C(e) (e' - e))_before / m

A step d of q adds 1/2 |grad d|^2 to every strain: 1 mm makes a false strain of 2e-5, a hundred times that of a membrane
at work, and the plain iteration sees a false, taut sheet. The strains e do without it, and converge to E(q): where the
step vanishes, e = E(q) and the law is that of q. Where the law has kinks, e' alone is a poor guide to the next state: a
softened point goes far and comes back. So the stress that the linearized law had foretold has its say (kernels/srm.py).
The geometric part of J has the stress of the law at e: that of sigma has the false one. It begins from the strains at
the begin of the step in time.

It ends with the gradient of Phi itself, so that the end does not depend on the way there: by steps with the last factor
where these fall fast, to a share of the tolerance, else by the plain iteration.

Full steps are taken where nothing touches, unless the slope of Phi rises to nearly what it fell by; contact, whose
overshoot is not of this kind, is left to the line search, and to a plain iteration where Phi rises along the step.

Source: D. Magisano, L. Leonetti, G. Garcea, Comput. Methods Appl. Mech. Engrg. 313 (2017) 986-1005 (mixed integration
points, there for shells); here for a law with kinks.
"""

from typing import Protocol

import numpy as np

from .newton import Direction, NewtonResult, Potential, line_search, minimize, newton_step
from .result import Failure

MAXIMUM_ITERATIONS = 60
"""After so many the plain iteration goes on."""

LENGTHS = (1.0, 0.7, 0.5, 0.3)
"""Parts of a step that are tried where nothing touches; the last one is taken if none is good enough."""

LARGEST_RISE = 0.9
"""Slope at the end of a good step over that at its begin, at most."""

CONTRACTION = 0.3
"""Steps with the last factor that fall by less than this are given up."""

CLOSED_SHARE = 1e-3
"""The iteration may end with a step with the last factor that is smaller than this share of the tolerance. It is one of
a falling sequence, whose rest is of its size: measured, 2e-4 of the tolerance where that is tight."""

MAXIMUM_CHORDS = 8
"""Steps with the same factor in a row."""


class MixedPotential(Potential, Protocol):
    """A potential with strains of their own.

    Attributes:
        touching: whether anything touched in the state last looked at.
    """

    touching: bool

    def take_strains(self, q: np.ndarray) -> None:
        """The strains are those of q from now on."""

    def advance_strains(self, q: np.ndarray, step: np.ndarray, length: float) -> None:
        """Takes the strains a part of the way to those linearized at q along a step."""

    def linearize_mixed(self, q: np.ndarray) -> tuple[np.ndarray, Direction] | None:
        """Gradient and Newton direction with the law at the strains; None if there is none."""


def minimize_mixed(potential: MixedPotential, start: np.ndarray, before: np.ndarray, tolerance: float) -> NewtonResult:
    """Iterates from `start`, with the strains of `before`, until a Newton step is smaller than `tolerance` (m)."""
    q, iterations = start, 0
    potential.take_strains(before)
    while iterations < MAXIMUM_ITERATIONS:
        iterations += 1
        linearized = potential.linearize_mixed(q)
        if linearized is None:
            break
        gradient, direction = linearized
        step = direction(gradient)
        size = potential.size(step)
        if not np.isfinite(size):
            break
        length, ahead = _length(potential, q, step, float(gradient @ step))
        if length == 1.0 and ahead is not None:
            closed = _close(potential, direction, q + step, ahead, size, tolerance)
            if closed is not None:
                return NewtonResult(closed, iterations)
        if size < tolerance:
            q = q + step
            break
        if length is not None:
            potential.advance_strains(q, step, length)
            q = q + length * step
            continue
        iterations += 1
        found = newton_step(potential, q)
        if isinstance(found, Failure):
            return NewtonResult(q, iterations, found)
        step, slope = found
        q = q + line_search(potential, q, step, slope) * step
        potential.take_strains(q)
    plain = minimize(potential, q, tolerance)
    return NewtonResult(plain.q, iterations + plain.iterations, plain.failure)


def _close(
    potential: MixedPotential, direction: Direction, q: np.ndarray, gradient: np.ndarray, size: float, tolerance: float
) -> np.ndarray | None:
    """The end of the plain iteration from q, with this gradient, after a step of `size` (m), without another factor;
    None if this is not close enough to it."""
    for _ in range(MAXIMUM_CHORDS):
        step = direction(gradient)
        before, size = size, potential.size(step)
        if not size < CONTRACTION * before:
            return None
        q = q + step
        if size < CLOSED_SHARE * tolerance:
            return q
        gradient = potential.gradient(q)
    return None


def _length(
    potential: MixedPotential, q: np.ndarray, step: np.ndarray, slope: float
) -> tuple[float | None, np.ndarray | None]:
    """Part of the step to be taken, None if Phi rises along it; and the gradient of Phi there, if it is known."""
    touching = potential.touching
    for length in () if touching else LENGTHS:
        gradient = potential.gradient(q + length * step)
        rise = float(gradient @ step)
        touching = potential.touching
        if rise <= LARGEST_RISE * abs(slope):
            return length, gradient
    if not touching and np.isfinite(rise):
        return LENGTHS[-1], None
    slope = float(potential.gradient(q) @ step)
    return (line_search(potential, q, step, slope) if slope < 0.0 else None), None
