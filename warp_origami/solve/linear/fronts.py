"""Symbolic analysis of a multifrontal Cholesky factorization: order, elimination tree, fronts.

Unknowns with the same neighbours, those of a node of the mesh mostly, are one vertex of a graph, which SuperLU's
minimum degree orders. Column j of the factor has the rows

    struct(j) = (neighbours of j that come later) + union of struct(c) - {j} over the children c,

its parent in the tree being the first of them. A front eliminates some unknowns together in dense matrices; children
are merged into their parents as long as the zeros that this stores cost less than the calls that it saves.
J. W. H. Liu, The multifrontal method for sparse matrix solution, SIAM Review 34 (1992) 82-109.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from warp_origami.terms.symmetric import SymmetricPattern

CALL = 12e-6
"""Seconds that a front costs whatever its size."""

RATES = 4e9, 9e9, 2e10, 5e8
"""Multiplications a second in potrf, trsm and syrk at the sizes of small fronts, and entries added to a front a second.
The number of fronts hardly depends on them."""


@dataclass(frozen=True)
class Fronts:
    """Fronts in the order of their elimination, children before parents.

    Attributes:
        order: (n,) unknown that is eliminated k-th; all that follow are numbers k in this order.
        starts: (f + 1,) first k of each front.
        rows: of each front the k > its own that it updates, increasing.
        parents: (f,) front that takes the update of each; -1: none.
    """

    order: np.ndarray
    starts: np.ndarray
    rows: list[np.ndarray]
    parents: np.ndarray

    @property
    def seconds(self) -> float:
        """That a factorization takes, roughly."""
        pivots = np.diff(self.starts).tolist()
        return sum(_cost(k, len(rows)) for k, rows in zip(pivots, self.rows, strict=True))


def find_fronts(pattern: SymmetricPattern) -> Fronts:
    """The fronts of a pattern."""
    labels, graph = _quotient(pattern)
    members = np.bincount(labels)
    order = _minimum_degree(graph)
    place = np.argsort(order)
    structures, parents = _eliminate(graph, order, place)
    sizes = members[order]
    groups, kept = _merge(structures, parents, sizes)
    return _numbered(labels, place, groups, kept, structures, parents)


def _quotient(pattern: SymmetricPattern) -> tuple[np.ndarray, csr_matrix]:
    """Number of the vertex of each unknown, and the graph with its diagonal.

    Neighbours are compared by the sums of random marks; a wrong vertex would only make the graph denser.
    """
    marks = np.random.default_rng(0).integers(1, 2**63, pattern.size, dtype=np.uint64)
    columns = pattern.columns
    sums = np.add.reduceat(marks[pattern.indices], pattern.indptr[:-1])
    np.add.at(sums, pattern.indices, marks[columns])
    _, first, labels = np.unique(sums - marks, return_index=True, return_inverse=True)
    renamed = np.empty(len(first), dtype=np.int32)
    renamed[np.argsort(first)] = np.arange(len(first))
    labels = renamed[labels]
    shape = 2 * (len(first),)
    ones = np.ones(len(columns), dtype=np.int8)
    half = coo_matrix((ones, (labels[pattern.indices], labels[columns])), shape=shape).tocsr().tocoo()
    both = np.concatenate([half.row, half.col]), np.concatenate([half.col, half.row])
    return labels, coo_matrix((np.ones(2 * half.nnz), both), shape=shape).tocsr()


def _minimum_degree(graph: csr_matrix) -> np.ndarray:
    """Vertices in the order of SuperLU's minimum degree."""
    degrees = np.diff(graph.indptr)
    diagonal = graph.indices == np.repeat(np.arange(len(degrees)), degrees)
    values = np.where(diagonal, degrees.max() + 1.0, -1.0)  # a definite matrix, for it is factorized, too
    dominant = csc_matrix((values, graph.indices, graph.indptr), shape=graph.shape)
    factor = splu(dominant, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.argsort(factor.perm_c)


def _eliminate(graph: csr_matrix, order: np.ndarray, place: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """Later rows of every column of the factor, in the order, and the parents (-1: none)."""
    parents = np.full(len(order), -1)
    structures: list[np.ndarray] = []
    gathered: list[set[int]] = [set() for _ in order]
    for j, vertex in enumerate(order):
        rows = gathered[j]
        rows.update(place[graph.indices[graph.indptr[vertex] : graph.indptr[vertex + 1]]].tolist())
        later = sorted(row for row in rows if row > j)
        structures.append(np.array(later, dtype=np.int64))
        gathered[j] = set()
        if later:
            parents[j] = later[0]
            gathered[later[0]].update(later)
    return structures, parents


def _cost(k: int, m: int) -> float:
    """Seconds that a front of k pivots and m further rows takes, roughly."""
    potrf, trsm, syrk, added = RATES
    arithmetic = k**3 / (6.0 * potrf) + k**2 * m / (2.0 * trsm) + k * m**2 / (2.0 * syrk)
    return CALL + arithmetic + m**2 / (2.0 * added)


def _merge(
    structures: list[np.ndarray], parents: np.ndarray, sizes: np.ndarray
) -> tuple[dict[int, list[int]], dict[int, list[int]]]:
    """Of each front, named by its last column: its columns, and the names of its children."""
    pivots = sizes.tolist()
    below = [int(sizes[rows].sum()) for rows in structures]
    columns = {j: [j] for j in range(len(parents))}
    children: dict[int, list[int]] = {j: [] for j in columns}
    for j, parent in enumerate(parents.tolist()):
        kept = []
        for c in children[j]:
            apart = _cost(pivots[c], below[c]) + _cost(pivots[j], below[j])
            if _cost(pivots[c] + pivots[j], below[j]) <= apart:
                pivots[j] += pivots[c]
                columns[j] = columns.pop(c) + columns[j]
                kept += children.pop(c)
            else:
                kept.append(c)
        children[j] = kept
        if parent >= 0:
            children[parent].append(j)
    return columns, children


def _postorder(children: dict[int, list[int]], roots: list[int]) -> list[int]:
    """Names of fronts, children right before their parents."""
    found, waiting = [], list(roots)
    while waiting:
        j = waiting.pop()
        found.append(j)
        waiting += children[j]
    return found[::-1]


def _numbered(
    labels: np.ndarray,
    place: np.ndarray,
    columns: dict[int, list[int]],
    children: dict[int, list[int]],
    structures: list[np.ndarray],
    parents: np.ndarray,
) -> Fronts:
    """The fronts in terms of unknowns."""
    tops = _postorder(children, [j for j in columns if parents[j] < 0])
    sequence = np.concatenate([columns[top] for top in tops])  # columns in the order of the fronts
    rank = np.argsort(sequence)
    unknown_rank = rank[place[labels]]
    order = np.argsort(unknown_rank, kind="stable")
    begins = np.concatenate([[0], np.cumsum(np.bincount(unknown_rank, minlength=len(rank)))])
    rows = []
    for top in tops:
        ranks = np.sort(rank[structures[top]])
        counts = begins[ranks + 1] - begins[ranks]
        ends = np.cumsum(counts)
        rows.append(np.arange(counts.sum()) + np.repeat(begins[ranks] - (ends - counts), counts))
    ends = np.cumsum([len(columns[top]) for top in tops])
    starts = begins[np.concatenate([[0], ends])]
    number = {top: f for f, top in enumerate(tops)}
    parent = np.full(len(tops), -1)
    for top in tops:
        for child in children[top]:
            parent[number[child]] = number[top]
    return Fronts(order, starts, rows, parent)
