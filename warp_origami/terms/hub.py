"""What a rigid hub adds: its inertia, and the stiff energy that keeps its frame orthonormal.

With the rows c, d_1, d_2, d_3 of q (model/hub.py) and principal moments of inertia A (about d_3) and B (about d_1, d_2)

    T = 1/2 m |c'|^2 + 1/2 sum_k J_k |d_k'|^2,   J_1 = J_2 = A / 2,   J_3 = B - A / 2
    U = kappa / 4 sum_kl e_kl^2,                 e_kl = d_k . d_l - delta_kl
    U,d_k = kappa sum_l e_kl d_l
    U,d_k d_l = kappa (e_kl I + d_l d_k' + delta_kl sum_m d_m d_m')

so that the mass matrix is constant, and U, which depends on scalar products alone, gives neither force nor moment.
"""

import numpy as np

from .buffers import Buffer

PAIRS = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]


def hub_masses(mass: float, axial: float, transverse: float) -> np.ndarray:
    """(4,) diagonal of the mass matrix for the rows c, d_1, d_2, d_3: kg, then kg m^2."""
    return np.array([mass, 0.5 * axial, 0.5 * axial, transverse - 0.5 * axial])


class RigidHub:
    """Energy of a hub's deformation as a function of q (n, 3).

    Args:
        first: row of d_1 in q; d_2 and d_3 follow.
        stiffness: kappa, J.

    Attributes:
        name: for summaries.
        block_count: 3x3 blocks of its tangent.
        rows: (1, 3) rows of q that it joins.
    """

    name = "rigid hub"
    block_count = len(PAIRS)

    def __init__(self, first: int, stiffness: float) -> None:
        self.rows = first + np.arange(3)[None, :]
        self._stiffness = stiffness

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Energy (J) and its gradient (n, 3)."""
        d = q[self.rows[0]]
        strain = d @ d.T - np.eye(3)
        gradient = np.zeros_like(q)
        gradient[self.rows[0]] = self._stiffness * strain @ d
        return 0.25 * self._stiffness * float(np.sum(strain**2)), gradient

    def add_tangent(self, q: np.ndarray, storage: Buffer, first: int, geometric: bool = True) -> None:
        """Writes the second derivatives of the pairs k <= l to `storage` from place `first` on; `geometric`: with the
        part of the stress."""
        d = q[self.rows[0]]
        strain, spread = float(geometric) * (d @ d.T - np.eye(3)), d.T @ d
        blocks = [strain[k, m] * np.eye(3) + np.outer(d[m], d[k]) + (spread if k == m else 0.0) for k, m in PAIRS]
        storage.write_at(first, self._stiffness * np.array(blocks))

    def rate(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(3,) angular velocity, rad/s: 1/2 sum_k d_k x d_k'."""
        return 0.5 * np.cross(q[self.rows[0]], v[self.rows[0]]).sum(axis=0)
