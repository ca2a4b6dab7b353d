"""Coulomb friction between layers that touch, regularized at low speed, from a potential of the slip velocities.

    D(v) = sum mu N (sqrt(|w|^2 + v_r^2) - v_r)        over touching pairs
    friction forces:  -dD/dv = -sum mu N W^T w / sqrt(|w|^2 + v_r^2),      w = W v

N, W are those of one state and are held. The slip velocity w of a pair is that of two points of the films at a common
place, halfway on the line d from one middle surface to the other, each moving with its element like a rigid body:

    w = (I - n n^T) (d' - 1/2 (omega_1 + omega_2) x d),      d = F q

d' = F v being the relative velocity of the points on the middle surfaces and omega the rotation of an element's three
corners. A rigid motion of both slips nowhere, so friction between them has neither a resultant nor a moment.

Source: regularized Coulomb friction, P. Wriggers, Computational Contact Mechanics (2006), section 5.2; potential with
held normal forces, C. Kane, J. E. Marsden, M. Ortiz and M. West, Int. J. Numer. Meth. Engng 49 (2000) 1295-1325.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags, vstack

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

from .active_pairs import ActivePairs


@dataclass(frozen=True)
class Friction:
    """Friction of k pairs with held normal forces, as a function of v.ravel() (3n,).

    Attributes:
        rows: (2 k, 3 n) W: first components of all slip velocities, then the second ones, in the plane of each contact.
        limits: (k,) mu N, N.
        speed: v_r, m/s.
    """

    rows: csr_matrix
    limits: np.ndarray
    speed: float

    def potential(self, v: np.ndarray) -> float:
        """D, W."""
        return float(self.limits @ (self._regularized(self._slip(v)) - self.speed))

    def resistance(self, v: np.ndarray) -> np.ndarray:
        """(3n,) dD/dv, minus the friction forces."""
        slip = self._slip(v)
        return self.rows.T @ (slip * (self.limits / self._regularized(slip))).ravel()

    def tangent(self, v: np.ndarray) -> tuple[csr_matrix, np.ndarray]:
        """Rows G (2 k, 3 n) and weights (2 k,), N s/m, > 0: the derivative of the resistance is G^T diag(weights) G.

        G has the directions along the slip, in which the resistance has all but reached its limit, and across it.
        """
        slip = self._slip(v)
        fast = self._regularized(slip)
        size = np.hypot(*slip)
        along = np.divide(slip, size, out=np.stack([np.ones_like(size), np.zeros_like(size)]), where=size > 0.0)
        cosine, sine = diags(along[0]), diags(along[1])
        first, second = self.rows[: len(size)], self.rows[len(size) :]
        rows = vstack([cosine @ first + sine @ second, cosine @ second - sine @ first])
        across = self.limits / fast
        return csr_matrix(rows), np.concatenate([across * (self.speed / fast) ** 2, across])

    def _slip(self, v: np.ndarray) -> np.ndarray:
        """(2, k) slip velocities, m/s."""
        return (self.rows @ v.ravel()).reshape(2, -1)

    def _regularized(self, slip: np.ndarray) -> np.ndarray:
        """(k,) sqrt(|w|^2 + v_r^2), m/s."""
        return np.sqrt(slip[0] ** 2 + slip[1] ** 2 + self.speed**2)


class FrictionLaw:
    """Makes the friction of pairs that touch.

    Args:
        mesh: flat sheet.
        coordinates: numbering of q.
        coefficient: mu.
        speed: v_r, m/s.
    """

    name = "friction"

    def __init__(self, mesh: Mesh, coordinates: Coordinates, coefficient: float, speed: float) -> None:
        self.coefficient, self.speed = float(coefficient), float(speed)
        self._corners = coordinates.positions[mesh.triangles]

    def between(self, pairs: ActivePairs, q: np.ndarray) -> Friction:
        """Friction of the pairs that touch at q (n, 3)."""
        distances = pairs.factors @ q
        rows = vstack([self._slip_rows(pairs, distances, t, q) for t in tangents(pairs.normals)])
        return Friction(csr_matrix(rows), self.coefficient * pairs.forces, self.speed)

    def _slip_rows(self, pairs: ActivePairs, distances: np.ndarray, t: np.ndarray, q: np.ndarray) -> csr_matrix:
        """(k, 3n) component along t (k, 3) of the slip velocities."""
        return pairs.rows_along(t) - 0.5 * self._rotation_rows(pairs.elements, np.cross(distances, t), q)

    def _rotation_rows(self, elements: np.ndarray, axes: np.ndarray, q: np.ndarray) -> csr_matrix:
        """(k, 3n) c . (omega_1 + omega_2) of elements (k, 2) with axes c (k, 3).

        omega = (I - n n^T / 2) sum_j grad L_j x v_j over the corners of the plane triangle with normal n, L_j its area
        coordinates: half the curl of the velocity along n, and across n what turns the triangle.
        """
        corners = self._corners[elements]
        along, aside = (q[corners[:, :, j]] - q[corners[:, :, 0]] for j in (1, 2))
        area = np.cross(along, aside)
        doubled = np.linalg.norm(area, axis=2, keepdims=True)
        normals = area / doubled
        second, third = np.cross(aside, normals) / doubled, np.cross(normals, along) / doubled
        gradients = np.stack([-second - third, second, third], axis=2)
        axes = axes[:, None] - 0.5 * np.einsum("kd,ked->ke", axes, normals)[:, :, None] * normals
        values = np.cross(axes[:, :, None], gradients)
        columns = 3 * corners[:, :, :, None] + np.arange(3)
        starts = np.arange(0, values.size + 1, 18)
        return csr_matrix((values.ravel(), columns.ravel(), starts), shape=(len(elements), q.size))


def tangents(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors (k, 3) square to each other and to normals (k, 3)."""
    axis = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(normals, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normals, first)
