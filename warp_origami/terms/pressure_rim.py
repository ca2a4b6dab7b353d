"""Antisymmetric part of the tangent of a follower pressure: an integral over the rim of the pressed region.

For two displacements d, D and the force F of a unit pressure

    d . dF(D) - D . dF(d) = closed integral of det(d, D, dr)

counter-clockwise along the rim. Edges inside the region drop out because the sheet is continuous there: over a crease
by the fold condition (48) only, so this is the tangent of motions that satisfy it. The trace of an edge is the cubic
Hermite one, r = sum_a H_a p_a with p = P q = [r, dr/ds] at both ends, so that each edge gives

    1/2 sum_abm h_abm det(d_a, D_b, p_m),   h_abm = int_0^1 H_a H_b H_m' ds
"""

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.edge_traces import HERMITE, edge_traces
from warp_origami.model.mesh import Mesh

_DETERMINANT = ((0, 1, 2, 1), (1, 2, 0, 1), (2, 0, 1, 1), (1, 0, 2, -1), (2, 1, 0, -1), (0, 2, 1, -1))
"""det(d, D, c) = sum of sign d_p D_s c_k over these (p, s, k, sign)."""


class PressureRim:
    """Antisymmetric tangent of a unit pressure on `elements`, of fixed structure."""

    def __init__(self, mesh: Mesh, coordinates: Coordinates, elements: np.ndarray) -> None:
        traces = edge_traces(mesh, coordinates, *_rim_edges(mesh, elements))
        self._rows, self._traces = traces.rows, traces.matrices
        self._products = _hermite_products()
        self._size = 3 * coordinates.count
        pairs = np.broadcast_arrays(self._rows[:, :, None], self._rows[:, None, :])
        row, column = (
            np.stack([3 * rows + entry[k] for entry in _DETERMINANT], axis=-1).ravel() for k, rows in enumerate(pairs)
        )
        keys, self._slots = np.unique(row * self._size + column, return_inverse=True)
        self._indices = keys % self._size
        self._indptr = np.searchsorted(keys // self._size, np.arange(self._size + 1))

    def skew(self, q: np.ndarray) -> csr_matrix:
        """(3n, 3n) at q (n, 3)."""
        ends = np.einsum("eai,eic->eac", self._traces, q[self._rows])
        local = np.einsum("abm,emc->eabc", 0.5 * self._products, ends)
        c = np.einsum("eai,eabc,ebj->eijc", self._traces, local, self._traces, optimize=True)
        entries = np.stack([sign * c[..., k] for _, _, k, sign in _DETERMINANT], axis=-1)
        data = np.bincount(self._slots, weights=entries.ravel(), minlength=len(self._indices))
        return csr_matrix((data, self._indices, self._indptr), shape=(self._size, self._size))


def _rim_edges(mesh: Mesh, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges with `elements` on one side only, and that side."""
    pressed = np.zeros(len(mesh.triangles), dtype=bool)
    pressed[elements] = True
    edges, sides = np.nonzero((mesh.edge_triangles >= 0) & pressed[mesh.edge_triangles])
    bounding = np.bincount(edges, minlength=len(mesh.edges))[edges] == 1
    return edges[bounding], sides[bounding]


def _hermite_products() -> np.ndarray:
    """(4, 4, 4) h_abm."""
    return np.array([[[(f * g * h.deriv()).integ()(1.0) for h in HERMITE] for g in HERMITE] for f in HERMITE])
