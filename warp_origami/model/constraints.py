"""Fold lines and prescribed motion as linear equations C q = d(t), their exact elimination and their multipliers.

At both ends of a fold the slopes along it agree between the two faces, paper (48):

    tau . grad r |_Q - tau . grad r |_R = 0

with constant coefficients, alike in x, y, z. All equations couple coordinates of a single vertex, so that rank,
null space and right inverse come from small dense blocks: equations that repeat others of the vertex are dropped, and

    q = T y + P d(t),   C T = 0,   C P = 1,   y = R (q - P d)

holds exactly. The unknowns y are slopes along creases wherever these determine the gradients, which keeps T sparse.

Points that are fixed to a hub (hub.py) have equations C_0 q = B h with its rows h of q on the right. With L = P_0 B in
the rows of the points and the columns of h, C = C_0 (1 - L), T = (1 + L) T_0, P = (1 + L) P_0 and R = R_0 (1 - L).
"""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, identity
from scipy.sparse.linalg import spsolve

from .coordinates import Coordinates
from .hub import Hub
from .mesh import CREASE, Mesh
from .prescribed import PrescribedRows, Prescriber, prescribed_motion

FOLD_SOURCE, TIE_SOURCE = -1, -2
"""Sources of equations that nothing prescribes: folds, and what is fixed to a hub."""

RANK_TOLERANCE = 1e-9
ROUNDED = 1e-9
"""Difference of the gradients at a fold that a start may have."""

CONDITIONING = (0.2, 0.02, 2e-3, 1e-5, RANK_TOLERANCE)
"""Shares of a functional that must be new for it to serve as an unknown: the best ones are taken first."""


@dataclass(frozen=True)
class Constraints:
    """Independent equations C q = d(t) on q.ravel(), and the parametrization of what they leave free.

    Attributes:
        equations: C, (m, 3n).
        null_space: T, (3n, ny).
        right_inverse: P, (3n, m).
        left_inverse: R, (ny, 3n), R T = 1.
        sources: (m,) row of `rows` that each equation comes from, FOLD_SOURCE or TIE_SOURCE.
        components: (m,) 0, 1, 2 for x, y, z.
        dropped: number of equations that repeat others.
        prescribers: supports and drivers.
        rows: their equations.
    """

    equations: csr_matrix
    null_space: csr_matrix
    right_inverse: csr_matrix
    left_inverse: csr_matrix
    sources: np.ndarray
    components: np.ndarray
    dropped: int
    prescribers: list[Prescriber]
    rows: PrescribedRows

    @property
    def folds(self) -> int:
        """Number of equations of folds."""
        return int(np.sum(self.sources == FOLD_SOURCE))

    @property
    def ties(self) -> int:
        """Number of equations of what is fixed to a hub."""
        return int(np.sum(self.sources == TIE_SOURCE))

    def values(self, time: float) -> np.ndarray:
        """(m,) right-hand sides d(t): zero for folds and ties."""
        return self._pick(prescribed_motion(self.prescribers, self.rows, time)[0])

    def derivatives(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """(m,) first and second time derivative of d(t)."""
        _, velocity, acceleration = prescribed_motion(self.prescribers, self.rows, time)
        return self._pick(velocity), self._pick(acceleration)

    def _pick(self, table: np.ndarray) -> np.ndarray:
        values = np.zeros(len(self.sources))
        prescribed = self.sources >= 0
        values[prescribed] = table[self.sources[prescribed], self.components[prescribed]]
        return values


def closed_at_folds(constraints: Constraints, q: np.ndarray) -> np.ndarray:
    """q (n, 3), moved least to fulfil the equations of folds; itself where it does up to ROUNDED.

    Gradients of rounded positions differ along a fold between its two sides.
    """
    equations = constraints.equations
    residual = np.where(constraints.sources == FOLD_SOURCE, equations @ q.ravel(), 0.0)
    if np.abs(residual).max(initial=0.0) < ROUNDED:
        return q
    multipliers = spsolve((equations @ equations.T).tocsc(), residual)
    return (q.ravel() - equations.T @ multipliers).reshape(q.shape)


def build_constraints(
    mesh: Mesh, coordinates: Coordinates, prescribers: list[Prescriber], rows: PrescribedRows, hub: Hub | None = None
) -> Constraints:
    """Equations of all folds, prescribers and points that are fixed to a hub, vertex by vertex."""
    folds = _fold_rows(mesh, coordinates)
    prescribed = defaultdict(list)
    for k, v in enumerate(rows.vertices):
        prescribed[int(v)].append(k)
    vertex_rows = _rows_of_vertices(mesh, coordinates)
    ties = defaultdict(list)
    if hub is not None:
        vertex_rows[hub.vertex] = hub.rows
        for tie in hub.ties:
            ties[tie.vertex].append(tie)

    builder = _Builder()
    free = np.ones(coordinates.count, dtype=bool)
    for v in sorted(folds.keys() | prescribed.keys() | ties.keys()):
        local = vertex_rows[v]
        free[local] = False
        directions = _slope_candidates(folds[v], local)
        cache = {}
        for c in range(3):
            active = tuple(k for k in prescribed[v] if c in rows.components[k])
            if active not in cache:
                entries = folds[v] + [tie.entries for tie in ties[v]] + [rows.entries[k] for k in active]
                cache[active] = _eliminate(_dense(entries, local), directions)
            sources = [FOLD_SOURCE] * len(folds[v]) + [TIE_SOURCE] * len(ties[v]) + list(active)
            builder.add(3 * local + c, c, sources, cache[active])
            if ties[v]:
                right = np.zeros((len(sources), len(hub.rows)))
                right[len(folds[v]) : len(folds[v]) + len(ties[v])] = [tie.hub for tie in ties[v]]
                builder.tie(3 * local + c, 3 * hub.rows + c, cache[active], right)
    builder.add_free(np.flatnonzero(free))
    return builder.build(3 * coordinates.count, prescribers, rows)


def _rows_of_vertices(mesh: Mesh, coordinates: Coordinates) -> dict[int, np.ndarray]:
    used = np.flatnonzero(coordinates.positions >= 0)
    starts = coordinates.positions[used]
    ends = np.append(starts[1:], coordinates.sheet_count)
    return {int(v): np.arange(a, b) for v, a, b in zip(used, starts, ends, strict=True)}


def _fold_rows(mesh: Mesh, coordinates: Coordinates) -> dict[int, list]:
    """vertex -> equations (48) of the folds that meet there, as lists of (row of q, coefficient)."""
    folds = defaultdict(list)
    for d in np.flatnonzero(mesh.edge_kinds == CREASE):
        a, b = (int(v) for v in mesh.edges[d])
        tangent = mesh.vertices[b] - mesh.vertices[a]
        tangent = tangent / np.linalg.norm(tangent)
        for v in (a, b):
            g1, g2 = (_gradient_row(mesh, coordinates, int(e), v) for e in mesh.edge_triangles[d])
            if g1 != g2:  # a crease that ends inside the sheet has one sector around its tip
                tx, ty = float(tangent[0]), float(tangent[1])
                folds[v].append([(g1, tx), (g1 + 1, ty), (g2, -tx), (g2 + 1, -ty)])
    return folds


def _gradient_row(mesh: Mesh, coordinates: Coordinates, element: int, vertex: int) -> int:
    corner = int(np.flatnonzero(mesh.triangles[element] == vertex)[0])
    return int(coordinates.elements[element, 3 * corner + 1])


def _dense(entries: list, local: np.ndarray) -> np.ndarray:
    matrix = np.zeros((len(entries), len(local)))
    for k, entry in enumerate(entries):
        for i, w in entry:
            matrix[k, i - local[0]] += w
    return matrix


def _slope_candidates(folds: list, local: np.ndarray) -> np.ndarray:
    """Functionals that may serve as unknowns: position, slopes along creases, then every single gradient component."""
    slopes = _dense([entry[:2] for entry in folds], local)
    unit = np.eye(len(local))
    return np.vstack([unit[:1], slopes, unit[1:]])


def _eliminate(matrix: np.ndarray, candidates: np.ndarray):
    """Independent rows of `matrix`, its null space T, right inverse P, and functionals R with R T = 1."""
    kept = _independent(matrix, (RANK_TOLERANCE,))
    independent = matrix[kept]
    if len(kept):
        _, _, basis = np.linalg.svd(independent)
        null = basis[len(kept) :].T
        inverse = np.linalg.pinv(independent)
    else:
        null = np.eye(matrix.shape[1])
        inverse = np.zeros((matrix.shape[1], 0))
    seen = candidates @ null
    chosen = _independent(seen, CONDITIONING)[: null.shape[1]]
    null = null @ np.linalg.inv(seen[chosen]) if null.shape[1] else null
    null[np.abs(null) < 1e-13] = 0.0
    inverse[np.abs(inverse) < 1e-13] = 0.0
    return kept, independent, null, inverse, candidates[chosen]


def _independent(matrix: np.ndarray, thresholds: tuple[float, ...]) -> np.ndarray:
    """Rows of a matrix of order one that are linearly independent of the rows chosen before them.

    A first pass takes those of which the first share of thresholds is new, further passes those of the next shares.
    """
    chosen, basis = [], np.zeros((0, matrix.shape[1]))
    for threshold in thresholds:
        for k, row in enumerate(matrix):
            if k in chosen or len(basis) == matrix.shape[1]:
                continue
            rest = row - basis.T @ (basis @ row)
            rest = rest - basis.T @ (basis @ rest)
            norm = np.linalg.norm(rest)
            if norm > threshold:
                chosen.append(k)
                basis = np.vstack([basis, rest / norm])
    return np.array(chosen, dtype=int)


class _Builder:
    """Collects the small blocks into sparse matrices."""

    def __init__(self):
        self.blocks = {"C": [], "T": [], "P": [], "R": [], "L": []}
        self.m = self.ny = self.dropped = 0
        self.sources, self.components = [], []

    def add(self, index: np.ndarray, component: int, sources: list[int], eliminated) -> None:
        kept, independent, null, inverse, functionals = eliminated
        m, ny = len(kept), null.shape[1]
        new_rows, new_unknowns = self.m + np.arange(m), self.ny + np.arange(ny)
        self._put("C", new_rows, index, independent)
        self._put("P", index, new_rows, inverse)
        self._put("T", index, new_unknowns, null)
        self._put("R", new_unknowns, index, functionals)
        self.sources += [sources[k] for k in kept]
        self.components += [component] * m
        self.dropped += len(sources) - m
        self.m += m
        self.ny += ny

    def tie(self, index: np.ndarray, hub: np.ndarray, eliminated, right: np.ndarray) -> None:
        """Right-hand sides of the equations just added, (equations, 4) times the rows of a hub in one component."""
        kept, _, _, inverse, _ = eliminated
        self._put("L", index, hub, inverse @ right[kept])

    def add_free(self, coordinates: np.ndarray) -> None:
        index = (3 * coordinates[:, None] + np.arange(3)).ravel()
        unknowns = self.ny + np.arange(len(index))
        for name, i, j in (("T", index, unknowns), ("R", unknowns, index)):
            self.blocks[name].append((i, j, np.ones(len(index))))
        self.ny += len(index)

    def _put(self, name, rows, columns, block) -> None:
        i, j = np.nonzero(block)
        self.blocks[name].append((rows[i], columns[j], block[i, j]))

    def build(self, size: int, prescribers: list[Prescriber], rows: PrescribedRows) -> Constraints:
        shapes = {"C": (self.m, size), "T": (size, self.ny), "P": (size, self.m), "R": (self.ny, size)}
        shapes["L"] = (size, size)
        matrices = {}
        for name, blocks in self.blocks.items():
            i, j, w = (np.concatenate([b[k] for b in blocks]) if blocks else np.zeros(0) for k in range(3))
            matrices[name] = coo_matrix((w, (i.astype(int), j.astype(int))), shape=shapes[name]).tocsr()
        lead = matrices.pop("L")
        if lead.nnz:
            one = identity(size, format="csr")
            matrices = {k: m @ (one - lead) if k in "CR" else (one + lead) @ m for k, m in matrices.items()}
            for matrix in matrices.values():
                matrix.sort_indices()
        return Constraints(
            equations=matrices["C"],
            null_space=matrices["T"],
            right_inverse=matrices["P"],
            left_inverse=matrices["R"],
            sources=np.array(self.sources, dtype=int),
            components=np.array(self.components, dtype=int),
            dropped=self.dropped,
            prescribers=prescribers,
            rows=rows,
        )
