"""Number of negative eigenvalues of a symmetric matrix: that of the negative pivots of its LDL^T (Sylvester).

Most matrices that are asked about have none, which Cholesky tells in a fraction of the time.
"""

import numpy as np
from scipy.sparse import csc_matrix

from warp_origami.terms.symmetric import symmetric_part

from . import pardiso
from .sparse_cholesky import SparseCholesky
from .superlu import without_pivoting

LARGE = 3000
"""Unknowns from which on PARDISO, where installed, counts faster than SuperLU."""


def negative_pivots(matrix: csc_matrix) -> int | None:
    """Number of negative eigenvalues of a symmetric sparse matrix.

    None where they cannot be told: a pivot vanished, and the matrix is singular or rows were exchanged.
    """
    given = symmetric_part(matrix)
    if SparseCholesky().factorize(given) is not None:
        return 0
    if matrix.shape[0] >= LARGE and pardiso.is_installed():
        return pardiso.negative_pivots(given)
    factor = without_pivoting(matrix)
    return None if factor is None else int(np.sum(factor.U.diagonal() < 0.0))
