"""Multifrontal Cholesky factorization: small dense matrices by LAPACK, along the elimination tree.

    [F11      ]   [L11    ] [L11^T L21^T]   [0  ]
    [F21  F22 ] = [L21  1 ] [0     1    ] + [  U]

Front after front: the entries of the matrix in its pivot columns and the updates U of its children are added, L11 and
L21 found by potrf and trsm, and its own U by syrk.
J. W. H. Liu, The multifrontal method for sparse matrix solution, SIAM Review 34 (1992) 82-109.
"""

import numpy as np
from scipy.linalg import blas, lapack
from scipy.sparse import coo_matrix

from warp_origami.terms.front_assembly import FrontAssembly
from warp_origami.terms.symmetric import SymmetricPattern

from .fronts import Fronts


class Plan:
    """Where everything is stored.

    Attributes:
        fronts: of the pattern.
        sizes: (f, 2) pivots k and further rows m of each front.
        offsets: (f, 4) where L11 and L21 begin in the panels, U in the updates, and the further rows in a list of all.
        length: of the panels.
        targets, sources: places of the entries of the matrix in the panels, and in its pattern.
        has_children: of each front.
        updates: U (m, m) of each front.
    """

    def __init__(self, pattern: SymmetricPattern, fronts: Fronts):
        self.fronts = fronts
        pivots = np.diff(fronts.starts)
        below = np.array([len(rows) for rows in fronts.rows], dtype=int)
        panels = np.concatenate([[0], np.cumsum(pivots * (pivots + below))])
        listed = np.concatenate([[0], np.cumsum(below)])
        updates, stacked = _stacked(fronts.parents, below)
        self.sizes = np.column_stack([pivots, below])
        self.offsets = np.column_stack([panels[:-1], panels[:-1] + pivots**2, updates, listed[:-1]])
        self.length = int(panels[-1])
        self.targets, self.sources = self._entries(pattern)

        children = np.flatnonzero(fronts.parents >= 0)
        children = children[np.argsort(fronts.parents[children], kind="stable")]
        counts = np.bincount(fronts.parents[children], minlength=len(pivots))
        child_starts = np.concatenate([[0], np.cumsum(counts)])
        self.has_children = (counts > 0).tolist()
        ends = fronts.starts[fronts.parents + 1]
        taken = np.array([np.searchsorted(rows, end) for rows, end in zip(fronts.rows, ends, strict=True)])
        self.assembly = FrontAssembly(self.sizes, self.offsets, children, child_starts, self._places(), taken, stacked)
        self.updates = [
            self.assembly.updates[begin : begin + m * m].reshape(m, m, order="F")
            for begin, m in zip(updates, below, strict=True)
        ]

    def _places(self) -> np.ndarray:
        """Of the further rows of all fronts, their places among the rows of the parent."""
        f = self.fronts
        parts = [np.empty(0, dtype=int)]
        for rows, parent in zip(f.rows, f.parents, strict=True):
            if parent < 0:
                continue  # it has none
            begin, end = f.starts[parent], f.starts[parent + 1]
            later = np.searchsorted(f.rows[parent], rows) + end - begin
            parts.append(np.where(rows < end, rows - begin, later))
        return np.concatenate(parts)

    def _entries(self, pattern: SymmetricPattern) -> tuple[np.ndarray, np.ndarray]:
        f, n = self.fronts, pattern.size
        place = np.empty(n, dtype=np.int32)
        place[f.order] = np.arange(n, dtype=np.int32)
        a, b = place[pattern.indices], place[pattern.columns]
        tags = np.arange(len(a), dtype=np.int32)
        sorted_tags = coo_matrix((tags, (np.maximum(a, b), np.minimum(a, b))), shape=(n, n)).tocsc()
        rows, columns = sorted_tags.indices, np.repeat(np.arange(n, dtype=np.int32), np.diff(sorted_tags.indptr))
        targets = np.empty(len(rows), dtype=np.int64)
        for k, (begin, end) in enumerate(zip(f.starts[:-1], f.starts[1:], strict=True)):
            span = slice(sorted_tags.indptr[begin], sorted_tags.indptr[end])
            i, j = rows[span], columns[span].astype(np.int64) - begin
            inside = self.offsets[k, 0] + j * (end - begin) + i - begin
            later = self.offsets[k, 1] + j * len(f.rows[k]) + np.searchsorted(f.rows[k], i)
            targets[span] = np.where(i < end, inside, later)
        return targets, sorted_tags.data.astype(np.int64)


class Panels:
    """Memory of one factor.

    Attributes:
        pattern: of the matrices.
        plan: shared by all of the pattern.
        blocks: L11 (k, k) and L21 (m, k) of each front.
    """

    def __init__(self, pattern: SymmetricPattern, plan: Plan):
        self.pattern, self.plan = pattern, plan
        self.numbers = numbers = np.zeros(plan.length)
        self.blocks = [
            (numbers[a : a + k * k].reshape(k, k, order="F"), numbers[b : b + k * m].reshape(m, k, order="F"))
            for (k, m), (a, b, _, _) in zip(plan.sizes, plan.offsets, strict=True)
        ]
        self.assemble = plan.assembly.bind(numbers)

    def factorize(self, values: np.ndarray) -> bool:
        """Whether the matrix is positive definite."""
        plan, assemble = self.plan, self.assemble
        self.numbers.fill(0.0)
        self.numbers[plan.targets] = values[plan.sources]
        for front, (diagonal, below) in enumerate(self.blocks):
            added = plan.has_children[front]
            if added:
                plan.updates[front].fill(0.0)
                assemble.set_param_at_index(0, front)
                assemble.launch()
            if lapack.dpotrf(diagonal, lower=1, clean=0, overwrite_a=1)[1] != 0:
                return False
            if len(below):
                blas.dtrsm(1.0, diagonal, below, side=1, lower=1, trans_a=1, overwrite_b=1)
                blas.dsyrk(-1.0, below, beta=added, c=plan.updates[front], lower=1, overwrite_c=1)
        return True

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x of A x = right (n,) or (n, k)."""
        fronts, blocks = self.plan.fronts, self.blocks
        if right.ndim == 2:
            return np.stack([self.solve(column) for column in right.T], axis=1) if right.shape[1] else right.copy()
        x = np.asarray(right, dtype=float)[fronts.order]
        starts = fronts.starts.tolist()
        for f, (diagonal, below) in enumerate(blocks):
            pivots = x[starts[f] : starts[f + 1]]
            blas.dtrsv(diagonal, pivots, lower=1, overwrite_x=1)
            if len(below):
                x[fronts.rows[f]] -= below @ pivots
        for f in range(len(blocks) - 1, -1, -1):
            diagonal, below = blocks[f]
            pivots = x[starts[f] : starts[f + 1]]
            if len(below):
                pivots -= x[fronts.rows[f]] @ below
            blas.dtrsv(diagonal, pivots, lower=1, trans=1, overwrite_x=1)
        result = np.empty_like(x)
        result[fronts.order] = x
        return result


def _stacked(parents: np.ndarray, below: np.ndarray) -> tuple[np.ndarray, int]:
    """Where each update begins, and the room for all.

    There are two stacks, for fronts of even and of odd depth: on the top of one are a front's children, the other takes
    its own update.
    """
    depth = np.zeros(len(parents), dtype=int)
    for f in range(len(parents) - 1, -1, -1):
        depth[f] = depth[parents[f]] + 1 if parents[f] >= 0 else 0
    begins = np.zeros(len(parents), dtype=np.int64)
    tops, highest = [0, 0], [0, 0]
    children: list[list[int]] = [[] for _ in parents]
    for f, parent in enumerate(parents):
        if children[f]:
            tops[(depth[f] + 1) % 2] = begins[children[f][0]]
        side = depth[f] % 2
        begins[f] = tops[side]
        tops[side] += below[f] ** 2
        highest[side] = max(highest[side], tops[side])
        if parent >= 0:
            children[parent].append(f)
    begins[depth % 2 == 1] += highest[0]
    return begins, int(sum(highest))
