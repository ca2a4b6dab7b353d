"""What solvers that perturb small pivots need: matrices without empty rows, and a look at what they solved."""

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, spmatrix

from .interface import Factor

WORST = 1e-6
"""Residual over the right side from which on a factor is of no use."""


def rows_with_diagonal(matrix: spmatrix) -> csr_matrix:
    """Compressed rows with increasing columns and every diagonal entry, be it zero."""
    size = matrix.shape[0]
    entries, diagonal = coo_matrix(matrix), np.arange(size)
    places = np.concatenate([entries.row, diagonal]), np.concatenate([entries.col, diagonal])
    return csr_matrix((np.concatenate([entries.data, np.zeros(size)]), places), shape=matrix.shape)


def is_accurate(factor: Factor, matrix: spmatrix) -> bool:
    """Whether the factor solves for a right side that has a part in every direction."""
    right = np.random.default_rng(0).normal(size=matrix.shape[0])
    residual = matrix @ factor.solve(right) - right
    return bool(np.linalg.norm(residual) <= WORST * np.linalg.norm(right))
