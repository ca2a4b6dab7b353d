"""T^T J T, J = K + m G + d K_0 + contact, assembled into a sparse pattern that stays.

K is the tangent of the elements, G a constant matrix (mass in dynamics), K_0 the matrix of stiffness damping.
"""

import numpy as np
from scipy.sparse import csr_matrix, identity, kron

from warp_origami.system import Linearization, System
from warp_origami.terms.padded_pattern import PaddedPattern
from warp_origami.terms.symmetric import SymmetricMatrix

SKEW = 1e-13
"""Skew part over the largest entry of the tangent below which it is round-off: pressure on a held rim is symmetric."""

SLIGHT = 1e-4
"""Skew part over the least inertia of an unknown below which Newton does without it: it converges as fast."""


class ReducedTangent:
    """The tangent in the unknowns of a transform.

    Attributes:
        sparsity: of T^T K T.
        metric_values: T^T G T in its pattern.
        padded: its pattern with room for contact.
    """

    def __init__(self, system: System, null_space: csr_matrix, metric: csr_matrix):
        self.null_space = null_space
        if null_space is system.constraints.null_space:
            self.sparsity = system.reduced_sparsity
        else:
            self.sparsity = system.sparsity(null_space)
        reduced = null_space.T @ kron(metric, identity(3), format="csr") @ null_space
        self.metric_values = self.sparsity.values_of(reduced)
        self._least_metric = float(self.metric_values[self.sparsity.pattern.indptr[:-1]].min(initial=np.inf))
        self.damping_values: np.ndarray | None = None
        self.padded = PaddedPattern(self.sparsity.pattern)
        self._values, self._share = np.empty_like(self.metric_values), np.empty_like(self.metric_values)

    def hold_damping(self, linearization: Linearization) -> None:
        """Keeps K_0 of the linearization."""
        self.damping_values = self.sparsity.values(linearization.blocks).copy()

    def symmetric(self, linearization: Linearization, multiple: float, damping: float) -> SymmetricMatrix:
        """The symmetric part of the matrix, m = multiple and d = damping; the next call overwrites it."""
        values = np.multiply(self.metric_values, multiple, out=self._values)
        values += self.sparsity.values(linearization.blocks)
        if damping and self.damping_values is not None:
            values += np.multiply(self.damping_values, damping, out=self._share)
        rows = linearization.contact_rows
        if rows is None or rows.shape[0] == 0:
            return SymmetricMatrix(self.sparsity.pattern, values)
        reduced = rows @ self.null_space
        reduced.sort_indices()
        return self.padded.add(values, reduced, linearization.contact_weights)

    def skew(self, linearization: Linearization, largest: float, multiple: float = 0.0) -> csr_matrix | None:
        """The skew part of the matrix, None if it is round-off of entries as large as `largest`, or slight beside
        the part m G, m = `multiple`."""
        if linearization.skew is None:
            return None
        skew = self.null_space.T @ linearization.skew @ self.null_space
        slight = max(SKEW * largest, SLIGHT * multiple * self._least_metric)
        return skew if np.abs(skew.data).max(initial=0.0) > slight else None
