"""A symmetric matrix bordered by equations, [A C^T; C 0], in a pattern that is found once."""

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from warp_origami.terms.symmetric import SymmetricMatrix, SymmetricPattern


class BorderedPattern:
    """Pattern of the bordered matrix and where the entries of A go.

    Args:
        inner: pattern of A, (n, n).
        equations: C, (k, n).

    Attributes:
        inner: as given.
    """

    def __init__(self, inner: SymmetricPattern, equations: csr_matrix):
        self.inner = inner
        border, corner = coo_matrix(equations), np.arange(inner.size, inner.size + equations.shape[0])
        rows = np.concatenate([inner.indices, inner.size + border.row, corner])
        columns = np.concatenate([inner.columns, border.col, corner])
        tags = np.arange(1, len(rows) + 1)
        lower = coo_matrix((tags, (rows, columns)), shape=2 * (inner.size + len(corner),)).tocsc()
        lower.sort_indices()
        self._pattern = SymmetricPattern(lower.indptr.astype(np.int32), lower.indices.astype(np.int32))
        places = np.argsort(lower.data)
        self._places = places[: len(inner.indices)]
        self._values = np.zeros(len(rows))
        self._values[places[len(inner.indices) : -len(corner) or None]] = border.data

    def matrix(self, values: np.ndarray) -> SymmetricMatrix:
        """The matrix for `values` of A; the next call overwrites it."""
        self._values[self._places] = values
        return SymmetricMatrix(self._pattern, self._values)
