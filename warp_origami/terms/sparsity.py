"""Sparse tangent of the reduced equations with a structure that is found once.

With q = T u + q_0 (T from the constraints, sparse) and element tangents K_e, the reduced tangent T' K T is linear in
the numbers stored in the element blocks: values = L blocks. L is kept as a compressed map, for the lower triangle only.
"""

from collections.abc import Sequence

import numpy as np
import warp as wp
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, spmatrix, tril

from warp_origami.kernels.gather import gather_scalars
from warp_origami.kernels.precision import real

from .buffers import Buffer
from .launches import Launch
from .symmetric import SymmetricPattern

BLOCK = 9
"""Numbers in a 3x3 block."""

GRAIN = 5000
"""Entries that are worth a thread: 0.01 us each."""


class ReducedSparsity:
    """Structure of T' K T and the assembly of its values from element tangents.

    Args:
        elements: (ne, 9) rows of q of each element.
        count: n, rows of q.
        transform: (3 n, m) sparse T; row 3 i + c is component c of row i of q. Empty rows are prescribed coordinates.
        device: where the element tangents live.
        further: of each term that joins other rows of q than elements do, these rows (k, r); its tangents follow those
            of the elements in memory, of the pairs i <= j of r rows.

    Attributes:
        size: m.
        pattern: of the lower triangle.
    """

    def __init__(
        self,
        elements: np.ndarray,
        count: int,
        transform: csr_matrix,
        device: str = "cpu",
        further: Sequence[np.ndarray] = (),
    ) -> None:
        if transform.shape[0] != 3 * count:
            raise ValueError(f"transform: got {transform.shape[0]} rows, wants {3 * count}, three per row of q")
        self.size = transform.shape[1]
        self._device = device
        terms: list[list[np.ndarray]] = [[], [], [], []]
        first_source = 0
        for rows in (elements, *further):
            for part, values in zip(terms, _expand(rows, transform.tocsr(), first_source), strict=True):
                part += values
            first_source += BLOCK * len(rows) * pairs_of(rows.shape[1])
        order, first, self.pattern = _sorted_slots(terms, self.size)
        source = np.concatenate(terms[2])
        all_one = all(np.all(part == 1.0) for part in terms[3])
        weight = np.empty(0) if all_one else np.concatenate(terms[3])[order]
        self._values = Buffer(len(self.pattern.indices), real, device)
        self._inputs = [
            wp.array(first, dtype=wp.int32, device=device, copy=False),
            wp.array(source[order], dtype=wp.int32, device=device, copy=False),
            wp.array(weight, dtype=real, device=device, copy=False),
        ]
        self._launch: Launch | None = None
        self._bound: int | None = None

    def values(self, blocks: np.ndarray | wp.array) -> np.ndarray:
        """Values of T' K T in the order of the pattern, from element tangents (ne, 45, 3, 3) of the pairs i <= j.

        A Warp array is read where it is, on this device. On the CPU the result is a view that the next call overwrites.
        """
        if len(self.pattern.indices) == 0:
            return self._values.read()
        flat = self._flatten(blocks)
        if self._bound != flat.ptr:
            self._launch = Launch(
                gather_scalars,
                len(self.pattern.indices),
                [*self._inputs, flat],
                [self._values.array],
                self._device,
                GRAIN,
            )
            self._bound = flat.ptr
        self._launch.launch()
        return self._values.read()

    def matrix(self, values: np.ndarray) -> csc_matrix:
        """Matrix (m, m), both triangles, from values in the order of the pattern."""
        return self.pattern.full(values)

    def values_of(self, matrix: spmatrix) -> np.ndarray:
        """Values of another symmetric (m, m) matrix, the mass matrix for instance, in this structure.

        Raises:
            ValueError: it has an entry where this structure has none.
        """
        other = coo_matrix(tril(matrix))
        result = np.zeros(len(self.pattern.indices))
        np.add.at(result, self.pattern.places_of(other.row, other.col), other.data)
        return result

    def _flatten(self, blocks: np.ndarray | wp.array) -> wp.array:
        if isinstance(blocks, wp.array):
            return wp.array(ptr=blocks.ptr, shape=blocks.size * BLOCK, dtype=real, device=blocks.device, copy=False)
        return wp.array(blocks.reshape(-1), dtype=real, device=self._device, copy=False)


def pairs_of(rows: int) -> int:
    """Blocks of a tangent that joins so many rows: the pairs i <= j."""
    return rows * (rows + 1) // 2


def _expand(elements: np.ndarray, transform: csr_matrix, first_source: int) -> list[list[np.ndarray]]:
    """Terms T[a, alpha] K_ab T[b, beta] of all entries of all element tangents, folded into alpha >= beta.

    values[row, column] += weight * blocks.ravel()[source], as four lists of arrays; the elements' tangents begin at
    `first_source`.
    """
    entries = np.diff(transform.indptr)
    start = transform.indptr[:-1]
    element = np.arange(len(elements))
    nodes = elements.shape[1]
    pairs = [(i, j) for i in range(nodes) for j in range(i, nodes)]
    parts: list[list[np.ndarray]] = [[], [], [], []]
    for pair, (i, j) in enumerate(pairs):
        source = first_source + BLOCK * (len(pairs) * element + pair)
        for entry in range(BLOCK):
            c, d = divmod(entry, 3)
            if i == j and c > d:
                continue  # the stored diagonal block is symmetric: its upper triangle stands for it
            a, b = 3 * elements[:, i] + c, 3 * elements[:, j] + d
            terms = _expand_entry(transform, start, entries, a, b, source + entry, i == j and c == d)
            for part, values in zip(parts, terms, strict=True):
                part.append(values)
    return parts


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
    if np.all(weight == 1.0):
        weight = np.broadcast_to(1.0, weight.shape)  # which takes no memory
    row, column = np.maximum(alpha, beta), np.minimum(alpha, beta)
    return row.astype(np.int32), column.astype(np.int32), source[which].astype(np.int32), weight


def _sorted_slots(terms: list[list[np.ndarray]], size: int) -> tuple[np.ndarray, np.ndarray, SymmetricPattern]:
    """Order of the terms by column and row; where each entry begins in it, with the end; the pattern of the entries.

    Takes the rows and columns out of `terms`: on large meshes these arrays are most of the peak of memory.
    """
    row, column = np.concatenate(terms[0]), np.concatenate(terms[1])
    terms[0].clear()
    terms[1].clear()
    tagged = coo_matrix((np.arange(len(row), dtype=np.int32), (row, column)), shape=(size, size))
    tagged.has_canonical_format = True  # keep duplicates: conversions are linear and stable, unlike a sort
    del row, column
    tagged = tagged.tocsr()
    tagged = tagged.tocsc()
    begins = np.ones(tagged.nnz, dtype=bool)
    begins[1:] = tagged.indices[1:] != tagged.indices[:-1]
    begins[tagged.indptr[:-1][np.diff(tagged.indptr) > 0]] = True
    first = np.flatnonzero(begins).astype(np.int32)
    indptr = np.searchsorted(first, tagged.indptr).astype(np.int32)
    pattern = SymmetricPattern(indptr, tagged.indices[first])
    return tagged.data, np.append(first, np.int32(tagged.nnz)), pattern
