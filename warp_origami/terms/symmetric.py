"""Symmetric sparse matrices of which one triangle is kept: the lower by columns, which is the upper by rows."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, spmatrix, tril


@dataclass(frozen=True, eq=False)
class SymmetricPattern:
    """Places of the entries. What was found out about a pattern holds for as long as it is the same object.

    Attributes:
        indptr: (n + 1,) int32, begin of each column.
        indices: (k,) int32, rows of the entries, increasing within a column; the first one is that of the diagonal,
            which is always there.
    """

    indptr: np.ndarray
    indices: np.ndarray

    @property
    def size(self) -> int:
        """n."""
        return len(self.indptr) - 1

    @property
    def columns(self) -> np.ndarray:
        """(k,) int32, columns of the entries."""
        return np.repeat(np.arange(self.size, dtype=np.int32), np.diff(self.indptr))

    @cached_property
    def _full(self) -> csc_matrix:
        """Both triangles; the data are the places of the entries in `indices`."""
        columns = self.columns
        off = np.flatnonzero(self.indices != columns)
        tags = np.concatenate([np.arange(len(columns)), off]).astype(np.int32)
        rows = np.concatenate([self.indices, columns[off]])
        full = coo_matrix((tags, (rows, np.concatenate([columns, self.indices[off]]))), shape=(self.size, self.size))
        full = full.tocsr()  # equal to its transpose, and conversions of coo matrices do not sort within rows
        return csc_matrix(full.tocsc())

    def full(self, values: np.ndarray) -> csc_matrix:
        """Both triangles of the matrix with `values` (k,)."""
        places = self._full
        result = csc_matrix(places.shape)
        result.data, result.indices, result.indptr = values[places.data], places.indices, places.indptr
        result.has_canonical_format = True
        return result

    def places_of(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Place in `indices` of each of the entries, rows >= columns.

        Raises:
            ValueError: one is not in the pattern.
        """
        keys = self.columns.astype(np.int64) * self.size + self.indices
        wanted = columns.astype(np.int64) * self.size + rows
        places = np.searchsorted(keys, wanted)
        outside = np.count_nonzero(keys[np.minimum(places, len(keys) - 1)] != wanted) if len(keys) else len(wanted)
        if outside:
            raise ValueError(f"structure: got {outside} entries outside of it, wants none")
        return places


@dataclass(frozen=True, eq=False)
class SymmetricMatrix:
    """A symmetric matrix.

    Attributes:
        pattern: places of its lower triangle.
        values: (k,) entries there; the owner may overwrite them later.
    """

    pattern: SymmetricPattern
    values: np.ndarray

    def full(self) -> csc_matrix:
        """The matrix with both triangles."""
        return self.pattern.full(self.values)


def symmetric_part(matrix: spmatrix) -> SymmetricMatrix:
    """The lower triangle of any sparse matrix, with its mirror image."""
    size = matrix.shape[0]
    lower = coo_matrix(tril(matrix))
    diagonal = np.arange(size)
    rows, columns = np.concatenate([lower.row, diagonal]), np.concatenate([lower.col, diagonal])
    values = np.concatenate([lower.data, np.zeros(size)])
    lower = coo_matrix((values, (rows, columns)), shape=(size, size)).tocsc()  # sums duplicates, keeps zeros
    lower.sort_indices()
    return SymmetricMatrix(SymmetricPattern(lower.indptr.astype(np.int32), lower.indices.astype(np.int32)), lower.data)
