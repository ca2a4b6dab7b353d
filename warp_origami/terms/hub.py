"""What a rigid hub adds: its inertia, and the stiff energy that keeps its frame orthonormal.

With the rows c, d_1, d_2, d_3 of q (model/hub.py) and principal moments of inertia A (about d_3) and B (about d_1, d_2)

    T = 1/2 m |c'|^2 + 1/2 sum_k J_k |d_k'|^2,   J_1 = J_2 = A / 2,   J_3 = B - A / 2
    U = kappa / 4 sum_kl e_kl^2,                 e_kl = d_k . d_l - delta_kl + p_kl / kappa
    U,d_k = kappa sum_l e_kl d_l
    U,d_k d_l = kappa (e_kl I + d_l d_k' + delta_kl sum_m d_m d_m')

so that the mass matrix is constant, and U, which depends on scalar products alone, gives neither force nor moment. The
stresses p are those of a rigid body in rotation w: without them a hub that starts with a spin would begin to breathe.
From J_k (alpha x d_k + w x (w x d_k)) = -sum_l p_kl d_l with p symmetric,

    p_kk = J_k (w^2 - w_k^2),     p_kl = -2 J_k J_l / (J_k + J_l) w_k w_l
"""

import numpy as np

from .buffers import Buffer

PAIRS = [(k, m) for k in range(4) for m in range(k, 4)]
"""Of the rows c, d_1, d_2, d_3."""


def hub_masses(mass: float, axial: float, transverse: float) -> np.ndarray:
    """(4,) diagonal of the mass matrix for the rows c, d_1, d_2, d_3: kg, then kg m^2."""
    return np.array([mass, 0.5 * axial, 0.5 * axial, transverse - 0.5 * axial])


def spinning_stress(masses: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """(3, 3) p, J, of a hub with the masses (4,) of `hub_masses` whose angular velocity (3,) in its frame is `rate`,
    rad/s."""
    j = masses[1:]
    stress = -2.0 * np.outer(j, j) / (j[:, None] + j[None, :]) * np.outer(rate, rate)
    return stress + np.diag(j * (rate @ rate - rate**2) - np.diag(stress))


class RigidHub:
    """Energy of a hub's deformation as a function of q (n, 3).

    Args:
        first: row of c in q; d_1, d_2 and d_3 follow.
        stiffness: kappa, J.
        stress: (3, 3) p, J.

    Attributes:
        name: for summaries.
        block_count: 3x3 blocks of its tangent.
        rows: (1, 4) rows of q that it joins; with c, for its inertia has a place in the tangent's structure, too.
    """

    name = "rigid hub"
    block_count = len(PAIRS)

    def __init__(self, first: int, stiffness: float, stress: np.ndarray) -> None:
        self.rows = first + np.arange(4)[None, :]
        self._frame = self.rows[0, 1:]
        self._stiffness = stiffness
        self._free = np.eye(3) - stress / stiffness

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Energy (J) and its gradient (n, 3)."""
        d = q[self._frame]
        strain = d @ d.T - self._free
        gradient = np.zeros_like(q)
        gradient[self._frame] = self._stiffness * strain @ d
        return 0.25 * self._stiffness * float(np.sum(strain**2)), gradient

    def add_tangent(self, q: np.ndarray, storage: Buffer, first: int, geometric: bool = True) -> None:
        """Writes the second derivatives of the pairs i <= j of `rows` to `storage` from place `first` on; `geometric`:
        with the part of the stress."""
        d = q[self._frame]
        strain, spread = float(geometric) * (d @ d.T - self._free), d.T @ d
        blocks = np.zeros((4, 4, 3, 3))
        for k in range(3):
            for m in range(k, 3):
                blocks[k + 1, m + 1] = strain[k, m] * np.eye(3) + np.outer(d[m], d[k]) + (spread if k == m else 0.0)
        storage.write_at(first, self._stiffness * np.array([blocks[pair] for pair in PAIRS]))

    def rate(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(3,) angular velocity, rad/s: 1/2 sum_k d_k x d_k'."""
        return 0.5 * np.cross(q[self._frame], v[self._frame]).sum(axis=0)
