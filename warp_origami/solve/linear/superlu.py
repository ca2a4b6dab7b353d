"""SuperLU, which comes with SciPy: sparse matrices that are indefinite or not symmetric, and signs of pivots."""

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from warp_origami.terms.symmetric import SymmetricMatrix

from .dense import EmptyFactor
from .interface import Factor


class SparseLU:
    """LU with pivoting."""

    name = "sparse LU (SuperLU, with pivoting)"
    kernel_modules = ()

    def factorize(self, matrix: SymmetricMatrix | csc_matrix) -> Factor | None:
        columns = matrix.full() if isinstance(matrix, SymmetricMatrix) else matrix.tocsc()
        if columns.shape[0] == 0:
            return EmptyFactor()
        try:
            return splu(columns)
        except RuntimeError:  # SuperLU's only way to say "exactly singular"
            return None


def without_pivoting(matrix: csc_matrix) -> SuperLU | None:
    """LU of a symmetric matrix in symmetric mode; None where a pivot vanishes or rows were exchanged."""
    try:
        factor = splu(matrix, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    return factor if np.array_equal(factor.perm_r, factor.perm_c) else None
