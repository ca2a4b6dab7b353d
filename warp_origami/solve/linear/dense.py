"""LAPACK on dense matrices, for a few hundred unknowns."""

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csc_matrix

from warp_origami.terms.symmetric import SymmetricMatrix

from .interface import Factor


def _lower(matrix: SymmetricMatrix) -> np.ndarray:
    """Lower triangle in a dense matrix."""
    pattern = matrix.pattern
    dense = np.zeros((pattern.size, pattern.size), order="F")
    dense.ravel(order="K")[pattern.columns.astype(np.int64) * pattern.size + pattern.indices] = matrix.values
    return dense


class DenseIndefinite:
    """sytrf (Bunch-Kaufman): the multiplier form."""

    name = "dense LDLT (LAPACK)"
    kernel_modules = ()

    def factorize(self, matrix: SymmetricMatrix) -> Factor | None:
        if matrix.pattern.size == 0:
            return EmptyFactor()
        dense = _lower(matrix)
        factor, pivots, info = lapack.dsytrf(dense, lower=1, lwork=64 * len(dense), overwrite_a=1)
        return _IndefiniteFactor(factor, pivots) if info == 0 else None


class _IndefiniteFactor:
    def __init__(self, factor: np.ndarray, pivots: np.ndarray):
        self.factor, self.pivots = factor, pivots

    def solve(self, right: np.ndarray) -> np.ndarray:
        return lapack.dsytrs(self.factor, self.pivots, right, lower=1)[0]


class DenseLU:
    """getrf: matrices that are not symmetric."""

    name = "dense LU (LAPACK)"
    kernel_modules = ()

    def factorize(self, matrix: csc_matrix) -> Factor | None:
        if matrix.shape[0] == 0:
            return EmptyFactor()
        factor, pivots, info = lapack.dgetrf(matrix.toarray(order="F"), overwrite_a=1)
        return _GeneralFactor(factor, pivots) if info == 0 else None


class _GeneralFactor:
    def __init__(self, factor: np.ndarray, pivots: np.ndarray):
        self.factor, self.pivots = factor, pivots

    def solve(self, right: np.ndarray) -> np.ndarray:
        return lapack.dgetrs(self.factor, self.pivots, right)[0]


class EmptyFactor:
    """Of the matrix without rows, which LAPACK does not know."""

    def solve(self, right: np.ndarray) -> np.ndarray:
        return right.copy()
