"""Contact pressure: the normal forces of touching pairs as a field on the sheet.

    p_i = sum_k f_k (N_i(X_k) + N_i(Y_k)) / A_i,     A_i = integral of N_i over the flat sheet

X_k and Y_k are the two points that pair k presses apart with f_k, N_i the linear shape functions of a sub-mesh. Both
surfaces of the film count: two films pressed together by p show p, a film between two others shows 2 p. Nothing is
lost: the integral of p over the flat sheet is 2 sum f_k.
"""

from math import gcd

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.model.lattice import lattice
from warp_origami.model.locate import area_coordinates
from warp_origami.model.mesh import Mesh
from warp_origami.model.submesh import Submesh, build_submesh


class PressureField:
    """Contact pressure at the points of a drawn sub-mesh.

    Args:
        mesh: flat sheet.
        drawn: some sub-mesh of it.
        divisions: of the sub-mesh of contact. Forces are spread on the finest one that neither contact nor `drawn`
            refines: finer triangles would show single contact points, and none of the force gets lost between both.
    """

    def __init__(self, mesh: Mesh, drawn: Submesh, divisions: int) -> None:
        self._mesh = mesh
        spread = build_submesh(mesh, gcd(divisions, drawn.divisions))
        self._divisions = spread.divisions
        corners, local, self._number = lattice(spread.divisions)
        self._points = np.empty((len(mesh.triangles), len(corners)), dtype=np.int64)
        self._points[:, local] = spread.triangles.reshape(len(mesh.triangles), -1, 3)
        thirds = np.repeat(spread.triangle_areas / 3.0, 3)
        self._areas = np.bincount(spread.triangles.ravel(), weights=thirds, minlength=len(spread.flat))
        self._interpolation = self._shapes(drawn.elements, drawn.flat)

    def __call__(self, forces: np.ndarray, elements: np.ndarray, flat: np.ndarray) -> np.ndarray:
        """Pressure (points of the drawn sub-mesh,), Pa.

        Args:
            forces: (k,) normal force of each pair, N.
            elements: (k, 2) elements of its two points.
            flat: (k, 2, 2) flat positions of its two points, m.
        """
        shapes = self._shapes(elements.ravel(), flat.reshape(-1, 2))
        return self._interpolation @ ((shapes.T @ np.repeat(forces, 2)) / self._areas)

    def _shapes(self, elements: np.ndarray, flat: np.ndarray) -> csr_matrix:
        """(m, spread points) linear shape functions at flat positions (m, 2) in elements (m,)."""
        k = self._divisions
        areas = np.clip(area_coordinates(self._mesh, elements, flat), 0.0, None)
        _, s, t = k * (areas / areas.sum(axis=1, keepdims=True)).T  # along the lattice
        i = np.minimum(np.floor(s), k - 1).astype(int)
        j = np.minimum(np.floor(t), k - 1 - i).astype(int)
        s, t = s - i, t - j
        turned = (s + t > 1.0) & (i + j < k - 1)  # in the triangle of the cell that stands on its head
        first = np.where(turned, self._number[i + turned, j + turned], self._number[i, j])
        corners = np.stack([first, self._number[i + 1, j], self._number[i, j + 1]], axis=1)
        upright = np.stack([1.0 - s - t, s, t], axis=1)
        values = np.where(turned[:, None], np.stack([s + t - 1.0, 1.0 - t, 1.0 - s], axis=1), upright)
        values = np.clip(values, 0.0, 1.0)  # round-off
        points = self._points[elements[:, None], corners]
        starts = np.arange(0, points.size + 1, 3)
        return csr_matrix((values.ravel(), points.ravel(), starts), shape=(len(points), len(self._areas)))
