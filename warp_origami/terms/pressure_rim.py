"""Antisymmetric part of the tangent of a follower pressure: an integral over the rim of the pressed region.

For two displacements d, D and the force F of a unit pressure

    d . dF(D) - D . dF(d) = closed integral of det(d, D, dr)

counter-clockwise along the rim. Edges inside the region drop out because the sheet is continuous there: over a crease
by the fold condition (48) only, so this is the tangent of motions that satisfy it. The trace of an edge is the cubic
Hermite one, r = sum_a H_a p_a with p = P q = [r, dr/ds] at both ends, so that each edge gives

    1/2 sum_abm h_abm det(d_a, D_b, p_m),   h_abm = int_0^1 H_a H_b H_m' ds
"""

import numpy as np
from numpy.polynomial import Polynomial
from scipy.sparse import csr_matrix

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

_DETERMINANT = ((0, 1, 2, 1), (1, 2, 0, 1), (2, 0, 1, 1), (1, 0, 2, -1), (2, 1, 0, -1), (0, 2, 1, -1))
"""det(d, D, c) = sum of sign d_p D_s c_k over these (p, s, k, sign)."""


class PressureRim:
    """Antisymmetric tangent of a unit pressure on `elements`, of fixed structure."""

    def __init__(self, mesh: Mesh, coordinates: Coordinates, elements: np.ndarray) -> None:
        self._rows, self._traces = _rim_edges(mesh, coordinates, elements)
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


def _rim_edges(mesh: Mesh, coordinates: Coordinates, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges that bound `elements`: (k, 6) rows [r, r_x, r_y] of both ends; P of each, (k, 4, 6), m in the slopes.

    Each edge runs counter-clockwise around its pressed element; s goes from 0 to 1 along it.
    """
    pressed = np.zeros(len(mesh.triangles), dtype=bool)
    pressed[elements] = True
    edge, side = np.nonzero((mesh.edge_triangles >= 0) & pressed[mesh.edge_triangles])
    bounding = np.bincount(edge, minlength=len(mesh.edges))[edge] == 1
    edge, side = edge[bounding], side[bounding]
    element = mesh.edge_triangles[edge, side]
    first = np.argmax(mesh.element_edges[element] == edge[:, None], axis=1)
    corners = np.stack([first, (first + 1) % 3], axis=1)
    nodes = coordinates.elements[element].reshape(-1, 3, 3).astype(np.int64)
    rows = np.take_along_axis(nodes, corners[:, :, None], axis=1).reshape(-1, 6)
    ends = mesh.vertices[np.take_along_axis(mesh.triangles[element], corners, axis=1)]
    traces = np.zeros((len(edge), 4, 6))
    for end in (0, 1):
        traces[:, 2 * end, 3 * end] = 1.0
        traces[:, 2 * end + 1, 3 * end + 1 : 3 * end + 3] = ends[:, 1] - ends[:, 0]
    return rows, traces


def _hermite_products() -> np.ndarray:
    """(4, 4, 4) h_abm."""
    hermite = [Polynomial(c) for c in ([1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1])]
    return np.array([[[(f * g * h.deriv()).integ()(1.0) for h in hermite] for g in hermite] for f in hermite])
