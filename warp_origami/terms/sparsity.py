"""Sparse tangent of the reduced equations with a structure that is found once.

With q = T u + q_0 (T from the constraints, sparse) and element tangents K_e, the reduced tangent T' K T is linear in
the numbers stored in the element blocks: values = L blocks. L is kept as a compressed map, for the lower triangle only.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, spmatrix

from warp_origami.kernels.gather import gather_symmetric
from warp_origami.kernels.membrane import NODES
from warp_origami.kernels.precision import real

from .buffers import Buffer

BLOCK = 9
"""Numbers in a 3x3 block."""


@dataclass(frozen=True)
class _Contributions:
    """Terms of the lower triangle: values[row, column] += weight * blocks.ravel()[source]."""

    row: np.ndarray
    column: np.ndarray
    source: np.ndarray
    weight: np.ndarray


class ReducedSparsity:
    """Structure of T' K T and the assembly of its values from element tangents.

    Args:
        elements: (ne, 9) rows of q of each element.
        count: n, rows of q.
        transform: (3 n, m) sparse T; row 3 i + c is component c of row i of q. Empty rows are prescribed coordinates.
        device: where the element tangents live.

    Attributes:
        size: m.
        indptr, indices: compressed structure (of columns or rows, which agree: the matrix is symmetric), sorted.
    """

    def __init__(self, elements: np.ndarray, count: int, transform: csr_matrix, device: str = "cpu") -> None:
        if transform.shape[0] != 3 * count:
            raise ValueError(f"transform: got {transform.shape[0]} rows, wants {3 * count}, three per row of q")
        self.size = transform.shape[1]
        self._device = device
        terms = _expand(elements, transform.tocsr())
        order, first, row, column = _sorted_slots(terms, self.size)
        self.indptr, self.indices, lower, upper = _symmetric_structure(row, column, self.size)

        self._values = Buffer(len(self.indices), real, device)
        self._count = len(row)
        self._inputs = [
            wp.array(first, dtype=wp.int32, device=device),
            wp.array(terms.source[order], dtype=wp.int32, device=device),
            wp.array(terms.weight[order], dtype=real, device=device),
            wp.array(lower, dtype=wp.int32, device=device),
            wp.array(upper, dtype=wp.int32, device=device),
        ]
        self._launch: wp.Launch | None = None
        self._bound: int | None = None

    def values(self, blocks: np.ndarray | wp.array) -> np.ndarray:
        """Values of T' K T in the order of `indices`, from element tangents (ne, 45, 3, 3) of the pairs i <= j.

        A Warp array is read where it is, on this device. On the CPU the result is a view that the next call overwrites.
        """
        if self._count == 0:
            return self._values.read()
        flat = self._flatten(blocks)
        if self._bound != flat.ptr:
            self._launch = wp.launch(
                gather_symmetric,
                dim=self._count,
                inputs=[*self._inputs, flat],
                outputs=[self._values.array],
                device=self._device,
                record_cmd=True,
            )
            self._bound = flat.ptr
        self._launch.launch()
        return self._values.read()

    def matrix(self, values: np.ndarray) -> csc_matrix:
        """Matrix (m, m) that shares `values` and the structure."""
        result = csc_matrix((self.size, self.size))
        result.data, result.indices, result.indptr = values, self.indices, self.indptr
        result.has_canonical_format = True
        return result

    def values_of(self, matrix: spmatrix) -> np.ndarray:
        """Values of another symmetric (m, m) matrix, the mass matrix for instance, in this structure.

        Raises:
            ValueError: it has an entry where this structure has none.
        """
        other = matrix.tocsc(copy=True)
        other.sum_duplicates()
        positions = np.arange(1, len(self.indices) + 1, dtype=np.int64)
        slots = self.matrix(positions)
        mask = csc_matrix((np.ones(other.nnz, dtype=np.int64), other.indices, other.indptr), shape=other.shape)
        found = slots.multiply(mask).tocsc()
        found.sort_indices()
        if found.nnz != other.nnz:
            raise ValueError(f"structure: got {other.nnz - found.nnz} entries outside of it, wants none")
        result = np.zeros(len(self.indices))
        result[found.data - 1] = other.data
        return result

    def _flatten(self, blocks: np.ndarray | wp.array) -> wp.array:
        if isinstance(blocks, wp.array):
            return wp.array(ptr=blocks.ptr, shape=blocks.size * BLOCK, dtype=real, device=blocks.device, copy=False)
        return wp.array(blocks.reshape(-1), dtype=real, device=self._device, copy=False)


def _expand(elements: np.ndarray, transform: csr_matrix) -> _Contributions:
    """Terms T[a, alpha] K_ab T[b, beta] of all entries of all element tangents, folded into alpha >= beta."""
    entries = np.diff(transform.indptr)
    start = transform.indptr[:-1]
    element = np.arange(len(elements))
    pairs = [(i, j) for i in range(NODES) for j in range(i, NODES)]
    parts: tuple[list[np.ndarray], ...] = ([], [], [], [])
    for pair, (i, j) in enumerate(pairs):
        source = BLOCK * (len(pairs) * element + pair)
        for entry in range(BLOCK):
            c, d = divmod(entry, 3)
            if i == j and c > d:
                continue  # the stored diagonal block is symmetric: its upper triangle stands for it
            a, b = 3 * elements[:, i] + c, 3 * elements[:, j] + d
            terms = _expand_entry(transform, start, entries, a, b, source + entry, i == j and c == d)
            for part, values in zip(parts, terms, strict=True):
                part.append(values)
    return _Contributions(*(_join(part) for part in parts))


def _join(part: list[np.ndarray]) -> np.ndarray:
    """One array of many, whose memory is given back at once: on large meshes these lists are most of the peak."""
    joined = np.concatenate(part)
    part.clear()
    return joined


def _expand_entry(transform, start, entries, a, b, source, diagonal):
    """Terms of one entry (a, b) of the tangents of all elements; off the diagonal (b, a) is added."""
    combinations = entries[a] * entries[b]
    which = np.repeat(np.arange(len(a)), combinations)
    local = np.arange(len(which)) - np.repeat(np.cumsum(combinations) - combinations, combinations)
    p = start[a][which] + local // entries[b][which]
    q = start[b][which] + local % entries[b][which]
    alpha, beta = transform.indices[p], transform.indices[q]
    weight = transform.data[p] * transform.data[q]
    if diagonal:
        keep = alpha >= beta
        alpha, beta, weight, which = alpha[keep], beta[keep], weight[keep], which[keep]
    else:
        weight = np.where(alpha == beta, 2.0 * weight, weight)
    row, column = np.maximum(alpha, beta), np.minimum(alpha, beta)
    return row.astype(np.int32), column.astype(np.int32), source[which].astype(np.int32), weight


def _sorted_slots(terms: _Contributions, size: int) -> tuple[np.ndarray, ...]:
    """Order of the terms by row and column; where each slot begins in it, with the end; rows and columns of slots."""
    tags = np.arange(len(terms.row), dtype=np.int32)
    tagged = coo_matrix((tags, (terms.row, terms.column)), shape=(size, size))
    tagged.has_canonical_format = True  # keep duplicates: conversions are linear and stable, unlike a sort
    tagged = tagged.tocsc().tocsr()
    begins = np.ones(tagged.nnz, dtype=bool)
    begins[1:] = tagged.indices[1:] != tagged.indices[:-1]
    begins[tagged.indptr[:-1][np.diff(tagged.indptr) > 0]] = True
    first = np.flatnonzero(begins).astype(np.int32)
    row = np.repeat(np.arange(size, dtype=np.int32), np.diff(tagged.indptr))[first]
    return tagged.data, np.append(first, np.int32(tagged.nnz)), row, tagged.indices[first]


def _symmetric_structure(row: np.ndarray, column: np.ndarray, size: int):
    """Structure of the full matrix; for every entry of the lower triangle its slot and that of its mirror image."""
    off = np.flatnonzero(row != column)
    tags = np.concatenate([np.arange(len(row)), len(row) + off]).astype(np.int32) + 1
    rows, columns = np.concatenate([row, column[off]]), np.concatenate([column, row[off]])
    full = csr_matrix((tags, (rows, columns)), shape=(size, size))
    full.sort_indices()
    slot = np.empty(2 * len(row), dtype=np.int32)
    slot[full.data - 1] = np.arange(len(full.data), dtype=np.int32)
    lower = slot[: len(row)]
    upper = lower.copy()
    upper[off] = slot[len(row) + off]
    return full.indptr, full.indices, lower, upper
