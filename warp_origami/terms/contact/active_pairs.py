"""Pairs that touch: how their gaps move with q, and the normal forces between them."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.sparse import csr_matrix, vstack


@dataclass(frozen=True)
class ActivePairs:
    """Pairs with a force, in the order of their names.

    Attributes:
        factors: (k, n) the relative displacement of the two points of pair i is row i times the change of q (n, 3), at
            fixed places of the points on the sheet.
        normals: (k, 3) unit direction in which the gap opens.
        forces: (k,) normal force, N, > 0: they press.
        stiffness: (k,) derivative of the force by the penetration, N/m.
        elements: (k, 2) elements that the two points lie on.
    """

    factors: csr_matrix
    normals: np.ndarray
    forces: np.ndarray
    stiffness: np.ndarray
    elements: np.ndarray

    def gap_rows(self) -> csr_matrix:
        """(k, 3 n) gradient of each gap with respect to q.ravel(); entries of one column are to be summed."""
        return self.rows_along(self.normals)

    def rows_along(self, directions: np.ndarray) -> csr_matrix:
        """(k, 3 n) the same of the relative displacements along directions (k, 3)."""
        scalar = self.factors
        directions = np.repeat(directions, np.diff(scalar.indptr), axis=0)
        return csr_matrix(
            (
                (scalar.data[:, None] * directions).ravel(),
                (3 * scalar.indices[:, None] + np.arange(3)).ravel(),
                3 * scalar.indptr,
            ),
            shape=(scalar.shape[0], 3 * scalar.shape[1]),
        )

    @classmethod
    @cache
    def none(cls, count: int) -> "ActivePairs":
        """No pairs, for q with `count` rows."""
        nothing = np.zeros(0)
        return cls(csr_matrix((0, count)), np.zeros((0, 3)), nothing, nothing, np.zeros((0, 2), dtype=int))

    @classmethod
    def joined(cls, parts: "list[ActivePairs]") -> "ActivePairs":
        """All pairs of several."""
        parts = [part for part in parts if len(part.forces)] or parts[:1]
        if len(parts) == 1:
            return parts[0]
        return cls(
            csr_matrix(vstack([part.factors for part in parts])),
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ("normals", "forces", "stiffness", "elements")
            ),
        )
