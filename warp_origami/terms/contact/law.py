"""Energy of a pair as a function of its gap g: the penalty, and the barrier that keeps a hard distance.

    penalty   U = 1/2 k g^2                  for g < 0
    barrier   U = 1/2 k g^2 / (1 + g / z)    for -z < g < 0, infinite below

g is the distance less the one at which the pair begins to press, a. With the penalty a is the effective thickness h,
and layers sink into each other by -g. With the barrier a = (1 + RANGE) h and z = RANGE h: the force begins RANGE h
before the thickness and grows beyond all bounds towards it, so no state of finite energy is closer than h. Both begin
with the stiffness k, and both are energies of q alone: contact stores what it takes and gives it back.

Sources: penalty, paper (36), (44); barriers in contact: M. Li et al., Incremental Potential Contact, ACM Transactions
on Graphics 39 (2020), whose logarithm begins without stiffness.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

RANGE = 0.1
"""Part of the effective thickness outside of it in which the barrier acts."""

LEAST_SHARE = 1e-3
"""Effective thickness over that of contact below which a pair keeps the penalty: points next to a crease, and layers
that coincide in the start, have no room for a barrier."""


class ContactLaw(Protocol):
    """All arrays (k,): gaps < 0 (m), stiffness k (N/m), distances a at which the pairs begin to press (m)."""

    outset: float
    """a over the effective thickness."""

    def energy(self, gaps: np.ndarray, stiffness: np.ndarray, begins: np.ndarray) -> np.ndarray:
        """U, J; infinite where the state is not allowed."""

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
class Barrier:
    """A spring that becomes infinitely stiff at the effective thickness.

    Attributes:
        thickness: of contact, m.
    """

    thickness: float
    outset: float = 1.0 + RANGE

    def energy(self, gaps, stiffness, begins):
        with np.errstate(divide="ignore"):
            return 0.5 * stiffness * gaps**2 / self._left(gaps, begins)

    def slope(self, gaps, stiffness, begins):
        left = self._left(gaps, begins)
        with np.errstate(divide="ignore"):
            return 0.5 * stiffness * gaps * (1.0 + left) / left**2

    def curvature(self, gaps, stiffness, begins):
        with np.errstate(divide="ignore"):
            return stiffness / self._left(gaps, begins) ** 3

    def penetration(self, gaps, begins):
        room = self._range(begins)
        return np.where(np.isfinite(room), np.maximum(-gaps - room, 0.0), -gaps)

    def _range(self, begins: np.ndarray) -> np.ndarray:
        """z, m; infinite without a barrier."""
        return np.where(begins > LEAST_SHARE * self.thickness, begins * (RANGE / self.outset), np.inf)

    def _left(self, gaps: np.ndarray, begins: np.ndarray) -> np.ndarray:
        """1 + g / z: what is left of the range, 0 where nothing is."""
        return np.maximum(1.0 + gaps / self._range(begins), 0.0)


def contact_law(exact: bool, thickness: float) -> ContactLaw:
    """The barrier at a contact thickness (m) if contact is to be exact, else the penalty."""
    return Barrier(thickness) if exact else PENALTY
