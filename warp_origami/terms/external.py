"""External forces: dead ones, which depend on time alone, and follower pressure, which depends on the motion.

f(q, t) = sum_k profile_k(t) w_k + sum_k profile_k(t) p_k F_k(q)
"""

from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.model.profile import Profile

from .pressure import FollowerPressure


@dataclass(frozen=True)
class DeadForce:
    """Generalized force `value` (n, 3) times profile(t)."""

    value: np.ndarray
    profile: Profile


@dataclass(frozen=True)
class Pressure:
    """Follower pressure of `value` (Pa) times profile(t)."""

    term: FollowerPressure
    value: float
    profile: Profile


@dataclass(frozen=True)
class ExternalForce:
    """The external force at one time as a function of q (n, 3).

    Attributes:
        dead: (n, 3) the part that does not depend on q; N in rows of positions, N m in rows of gradients.
        pressures: terms of follower pressure and their present pressures, Pa.
    """

    dead: np.ndarray
    pressures: tuple[tuple[FollowerPressure, float], ...]

    def __call__(self, q: np.ndarray) -> np.ndarray:
        """(n, 3) force."""
        total = self.dead
        for term, pressure in self.pressures:
            total = total + pressure * term.force(q)
        return total

    def add_stiffness(self, q: np.ndarray, blocks: wp.array) -> None:
        """Adds minus the symmetric part of df/dq to element tangents on the device."""
        for term, pressure in self.pressures:
            term.add_stiffness(q, pressure, blocks)

    def skew_stiffness(self, q: np.ndarray) -> csr_matrix | None:
        """(3n, 3n) minus the skew part of df/dq, from the edges of what is under pressure; None without pressure."""
        total = None
        for term, pressure in self.pressures:
            part = -pressure * term.skew(q)
            total = part if total is None else total + part
        return total


@dataclass(frozen=True)
class ExternalForces:
    """All external forces of a scene on `count` rows of q."""

    count: int
    dead: tuple[DeadForce, ...]
    pressures: tuple[Pressure, ...]

    def at(self, time: float) -> ExternalForce:
        """The force at a time (s)."""
        total = np.zeros((self.count, 3))
        for force in self.dead:
            total += force.profile(time) * force.value
        present = [(p.term, p.profile(time) * p.value) for p in self.pressures]
        return ExternalForce(total, tuple((term, value) for term, value in present if value != 0.0))
