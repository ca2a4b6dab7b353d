"""Energy of a pair as a function of its gap g: the penalty, a penalty that stiffens, a barrier that keeps a distance.

    penalty   U = 1/2 k g^2                  for g < 0
    stiffening  the same to the depth of h / 2 = b; beyond, at the distance d = h + g, U'' = k (b / d)^3, to d = LEFT b
    barrier   U = 1/2 k g^2 / (1 + g / z)    for g < 0; below 1 + g / z = LEFT the parabola with the same value, slope
                                             and curvature, k / LEFT^3

g is the distance less the one at which the pair begins to press, a. With the penalty a is the effective thickness h,
and layers sink into each other by -g. With the barrier a = (1 + RANGE) h and z = RANGE h: the force begins RANGE h
before the thickness and has grown to 150 k z, its energy to 14 k z^2, where layers are at it. It stays finite, so that
an iterate that is closer is pushed back, and where the stiffness of two edges fades the energy fades too. Both begin
with the stiffness k, and both are energies of q alone: contact stores what it takes and gives it back.

Sources: penalty, paper (36), (44); barriers in contact: M. Li et al., Incremental Potential Contact, ACM Transactions
on Graphics 39 (2020), whose logarithm begins without stiffness.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

RANGE = 0.1
"""Part of the effective thickness outside of it in which the barrier acts."""

LEFT = 0.1
"""Part of the range that is left where the barrier goes over into its parabola, a thousand times as stiff as at its
begin. With 0.02, Newton spends hundreds of evaluations on iterates that are far through a layer."""

LEAST_SHARE = 1e-3
"""Effective thickness over that of contact below which a pair keeps the penalty: points next to a crease, and layers
that coincide in the start, have no room for a law that stiffens."""


class ContactLaw(Protocol):
    """All arrays (k,): gaps < 0 (m), stiffness k (N/m), distances a at which the pairs begin to press (m)."""

    outset: float
    """a over the effective thickness."""

    def energy(self, gaps: np.ndarray, stiffness: np.ndarray, begins: np.ndarray) -> np.ndarray:
        """U, J."""

    def slope(self, gaps: np.ndarray, stiffness: np.ndarray, begins: np.ndarray) -> np.ndarray:
        """dU/dg, N: minus the force."""

    def curvature(self, gaps: np.ndarray, stiffness: np.ndarray, begins: np.ndarray) -> np.ndarray:
        """d2U/dg2, N/m."""

    def penetration(self, gaps: np.ndarray, begins: np.ndarray) -> np.ndarray:
        """How far each pair is closer than its effective thickness, m."""


@dataclass(frozen=True)
class Penalty:
    """A linear spring from the effective thickness on."""

    outset: float = 1.0

    def energy(self, gaps, stiffness, begins):
        return 0.5 * stiffness * gaps**2

    def slope(self, gaps, stiffness, begins):
        return stiffness * gaps

    def curvature(self, gaps, stiffness, begins):
        return stiffness * np.ones_like(gaps)

    def penetration(self, gaps, begins):
        return -gaps


PENALTY = Penalty()


@dataclass(frozen=True)
class StiffeningPenalty(Penalty):
    """A linear spring to half of the effective thickness, then ever stiffer: nothing is pressed through a layer.

    Up to a depth of h / 2 it is the penalty, whose numbers hold. A spring that stays as soft bears no more than k h.

    Attributes:
        thickness: of contact, m.
    """

    thickness: float = 0.0

    def energy(self, gaps, stiffness, begins):
        b, d, beyond = self._beyond(gaps, begins)
        slope, curvature = -0.5 * stiffness * b * (1.0 + (b / d) ** 2), stiffness * (b / d) ** 3
        deep = 0.5 * stiffness * b * (b - d + b**2 / d) + (slope + 0.5 * curvature * beyond) * beyond
        return np.where(self._is_deep(gaps, begins), deep, super().energy(gaps, stiffness, begins))

    def slope(self, gaps, stiffness, begins):
        b, d, beyond = self._beyond(gaps, begins)
        deep = -0.5 * stiffness * b * (1.0 + (b / d) ** 2) + stiffness * (b / d) ** 3 * beyond
        return np.where(self._is_deep(gaps, begins), deep, super().slope(gaps, stiffness, begins))

    def curvature(self, gaps, stiffness, begins):
        b, d, _ = self._beyond(gaps, begins)
        soft = super().curvature(gaps, stiffness, begins)
        return np.where(self._is_deep(gaps, begins), stiffness * (b / d) ** 3, soft)

    def _is_deep(self, gaps: np.ndarray, begins: np.ndarray) -> np.ndarray:
        return (gaps < -0.5 * begins) & (begins > LEAST_SHARE * self.thickness)

    def _beyond(self, gaps: np.ndarray, begins: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """b, the distance at which the law is to be taken, and how much farther the pair is from there, m."""
        b = np.maximum(0.5 * begins, np.finfo(float).tiny)
        d = np.clip(begins + gaps, LEFT * b, b)
        return b, d, begins + gaps - d


@dataclass(frozen=True)
class Barrier:
    """A spring that becomes LEFT^-3 times as stiff towards the effective thickness.

    Attributes:
        thickness: of contact, m.
    """

    thickness: float
    outset: float = 1.0 + RANGE

    def energy(self, gaps, stiffness, begins):
        at, left, beyond = self._places(gaps, begins)
        energy = 0.5 * at**2 / left + (0.5 * at * (1.0 + left) / left**2 + 0.5 * beyond / left**3) * beyond
        return stiffness * energy

    def slope(self, gaps, stiffness, begins):
        at, left, beyond = self._places(gaps, begins)
        return stiffness * (0.5 * at * (1.0 + left) / left**2 + beyond / left**3)

    def curvature(self, gaps, stiffness, begins):
        return stiffness / self._places(gaps, begins)[1] ** 3

    def penetration(self, gaps, begins):
        room = self._range(begins)
        return np.where(np.isfinite(room), np.maximum(-gaps - room, 0.0), -gaps)

    def _range(self, begins: np.ndarray) -> np.ndarray:
        """z, m; infinite without a barrier."""
        return np.where(begins > LEAST_SHARE * self.thickness, begins * (RANGE / self.outset), np.inf)

    def _places(self, gaps: np.ndarray, begins: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The gaps, but none beyond the barrier; 1 + g / z there; and how far the given gaps are beyond, < 0, m."""
        room = self._range(begins)
        left = np.maximum(1.0 + gaps / room, LEFT)
        at = np.where(left > LEFT, gaps, (LEFT - 1.0) * np.where(np.isfinite(room), room, 0.0))
        return at, left, gaps - at


def contact_law(method: str, exact: bool, thickness: float) -> ContactLaw:
    """The law of a contact method at a contact thickness, m.

    The paper's penalty for its methods `sts` and `nts`, which are to show what it lets through; for `mixed` one that
    stiffens; the barrier if contact is to be exact.
    """
    if exact:
        return Barrier(thickness)
    return StiffeningPenalty(thickness=thickness) if method == "mixed" else Penalty()
