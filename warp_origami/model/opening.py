"""Layers that coincide in the stowed state, opened a little in the order that FOLD `faceOrders` gives them.

    x -> x + c_F + w_F x (x - m_F)     for every face F (m_F its middle), alike at vertices that faces share
    n . (motion of the upper - motion of the lower layer) >= s     wherever layers coincide
    sum |w_F| + |c_F| / size = min

s is the distance of the two points in the flat sheet: layers open like a book about the crease that they share. The
solution of this linear program is scaled to rotations of SLOPE and begins Newton's method for the rigid folding there,
x -> m_F + c_F + R(w_F) (x - m_F). A pattern that cannot fold rigidly is opened by the linear motion alone, which
stretches faces by SLOPE_BENT^2 / 2. Layers at no distance at all would have none to lose before they cross.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, hstack
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from ..errors import InputError
from .connectivity import sheet_labels
from .fold_angles import fold_angles
from .mesh import SMOOTH, Mesh

SLOPE = 1e-3
"""Largest rotation, rad: layers 0.1 m from their crease are then 0.1 mm apart, and may close by 1 m/s or so."""

SLOPE_BENT = 5e-5
"""Largest rotation where faces are stretched by it, rad."""

SHUT = 1e-3
"""Angle (rad) from pi of creases taken for folded flat."""

ITERATIONS = 20
"""Of Newton's method for the rigid folding."""

ROUND_OFF = 1e-9
"""Distance of layers that coincide, and of points that do, over the size of the sheet."""


@dataclass(frozen=True)
class Overlap:
    """Where one face lies on another: corners of the common part, m.

    Attributes:
        upper, lower: faces, above each other along `normal`.
        normal: (3,) unit normal.
        folded: (k, 3) positions.
        apart: (k,) distance of the two points in the flat sheet.
    """

    upper: int
    lower: int
    normal: np.ndarray
    folded: np.ndarray
    apart: np.ndarray


def opened(mesh: Mesh, pattern_faces: np.ndarray, face_orders: np.ndarray, stowed: np.ndarray) -> np.ndarray:
    """(nv, 3) stowed positions, m, with coincident layers opened.

    `stowed` itself where no layers coincide, or they cannot open without bending.

    Args:
        mesh: flat sheet.
        pattern_faces, face_orders: see Pattern.
        stowed: (nv, 3) positions of the vertices, m.

    Raises:
        InputError: layers lie on each other in unknown order.
    """
    if not len(face_orders) and not _folded_shut(mesh, stowed):
        return stowed
    folded, overlaps, unknown = _overlaps(mesh, pattern_faces, face_orders, stowed)
    if unknown:
        f, g = unknown[0]
        raise InputError(
            "pattern.initial",
            f"stowed layers that coincide in unknown order: {len(unknown)} pairs of faces, such as {f} and {g}",
            "letters M and V or faceOrders that say which lies above (in the FOLD file), or layers slightly apart",
        )
    if not overlaps:
        return stowed
    x = folded.opening(overlaps)
    if x is None:
        return stowed
    rigid = folded.rigid(SLOPE * x)
    return folded.stowed + SLOPE_BENT * folded.displacements(x) if rigid is None else rigid


def unordered_layers(
    mesh: Mesh, pattern_faces: np.ndarray, face_orders: np.ndarray, stowed: np.ndarray
) -> list[tuple[int, int]]:
    """Faces of the pattern that lie on each other in unknown order; only looked for where a crease is folded shut.

    Args:
        mesh, pattern_faces, face_orders, stowed: see `opened`.
    """
    return _overlaps(mesh, pattern_faces, face_orders, stowed)[2] if _folded_shut(mesh, stowed) else []


def _folded_shut(mesh: Mesh, stowed: np.ndarray) -> bool:
    """Whether some crease is: without any, no face lies on its neighbours."""
    return bool(np.abs(fold_angles(mesh, stowed)).max() > np.pi - SHUT)


def _rounding(mesh: Mesh, stowed: np.ndarray) -> float:
    """By how much edges are longer or shorter than in the flat sheet, at most, m: that of the positions' digits."""
    (a, b), flat = mesh.edges.T, mesh.vertices
    change = np.linalg.norm(stowed[b] - stowed[a], axis=1) - np.linalg.norm(flat[b] - flat[a], axis=1)
    return float(np.abs(change).max())


def _flattened(mesh: Mesh, stowed: np.ndarray) -> np.ndarray:
    """Positions of a sheet in one plane without rounding across it, which would keep it from opening; others as is."""
    rounding = _rounding(mesh, stowed)
    if rounding <= ROUND_OFF * mesh.size:
        return stowed
    middle = stowed.mean(axis=0)
    normal = np.linalg.svd(stowed - middle, full_matrices=False)[2][2]
    heights = (stowed - middle) @ normal
    return stowed - np.outer(heights, normal) if np.abs(heights).max() < 20.0 * rounding else stowed


def _overlaps(mesh: Mesh, pattern_faces: np.ndarray, face_orders: np.ndarray, stowed: np.ndarray):
    """The folded faces, the overlaps of known order, and the pairs of pattern faces of unknown order."""
    folded = FoldedFaces(mesh, _flattened(mesh, stowed))
    owner = np.zeros(len(folded.middles), dtype=int)
    owner[mesh.faces] = pattern_faces
    orders = _orders(mesh, pattern_faces, face_orders)
    overlaps, unknown = [], []
    for f, g in folded.coincident_pairs():
        corners = folded.overlap(f, g)
        if corners is None:
            continue
        alike = np.sign(folded.normals[f] @ folded.normals[g])
        side = np.sign(orders.get((f, g), 0) - alike * orders.get((g, f), 0))
        if side == 0:
            if folded.really_overlap(f, g):
                unknown.append((int(owner[f]), int(owner[g])))
            continue
        upper, lower = (f, g) if side > 0 else (g, f)
        overlaps.append(Overlap(upper, lower, folded.normals[g], corners, folded.apart(f, g, corners)))
    return folded, overlaps, unknown


def _orders(mesh: Mesh, pattern_faces: np.ndarray, face_orders: np.ndarray) -> dict[tuple[int, int], int]:
    """(F, G) -> on which side of G's normal F lies, for mesh faces."""
    if not len(face_orders):
        return {}
    face_of = np.full(max(int(pattern_faces.max()), int(face_orders[:, :2].max())) + 1, -1)
    face_of[pattern_faces] = mesh.faces
    sides: dict[tuple[int, int], int] = {}
    for f, g, side in face_orders.tolist():
        pair = int(face_of[f]), int(face_of[g])
        sides[pair] = sides.get(pair, 0) + side
    return sides


class FoldedFaces:
    """The faces in the stowed state, those that are plane.

    Attributes:
        normals: (nf, 3) unit normals.
        shared: (k, 3) vertices that faces share: vertex, its first face, another one.
    """

    def __init__(self, mesh: Mesh, stowed: np.ndarray):
        self.mesh, self.stowed = mesh, stowed
        self.rounding = _rounding(mesh, stowed)
        self.close = max(ROUND_OFF * mesh.size, self.rounding)
        count = int(mesh.faces.max()) + 1
        self.elements = [np.flatnonzero(mesh.faces == f) for f in range(count)]
        self.vertices = [np.unique(mesh.triangles[elements]) for elements in self.elements]
        self.middles = np.array([stowed[v].mean(axis=0) for v in self.vertices])
        self.flat_middles = np.array([mesh.vertices[v].mean(axis=0) for v in self.vertices])
        flat = mesh.vertices[mesh.triangles]
        folded = stowed[mesh.triangles]
        gradients = (folded[:, 1:] - folded[:, :1]).transpose(0, 2, 1) @ np.linalg.inv(
            (flat[:, 1:] - flat[:, :1]).transpose(0, 2, 1)
        )
        self.gradients = np.array([gradients[elements[0]] for elements in self.elements])  # (nf, 3, 2): r_x, r_y
        normals = np.cross(self.gradients[:, :, 0], self.gradients[:, :, 1])
        self.normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        self.plane = np.array([self._height(f, f) <= self.close for f in range(count)])
        owner: dict[int, int] = {}
        places = [(v, f) for f, vertices in enumerate(self.vertices) for v in vertices.tolist()]
        self.shared = np.array([(v, owner[v], f) for v, f in places if owner.setdefault(v, f) != f], dtype=int)
        self.shared = self.shared.reshape(-1, 3)
        labels = sheet_labels(mesh.edges, len(mesh.vertices))
        self.sheets = np.array([labels[v[0]] for v in self.vertices])
        border = np.flatnonzero(mesh.edge_kinds != SMOOTH)
        self.borders = [[] for _ in range(count)]
        for edge in border.tolist():
            for element in mesh.edge_triangles[edge]:
                if element >= 0:
                    self.borders[mesh.faces[element]].append(mesh.edges[edge])

    def _height(self, f: int, g: int) -> float:
        """Largest distance of face f from the plane of g, m."""
        return float(np.abs((self.stowed[self.vertices[f]] - self.middles[g]) @ self.normals[g]).max())

    def coincident_pairs(self) -> list[tuple[int, int]]:
        """Faces in one plane whose boxes meet."""
        corners = np.array([[self.stowed[v].min(axis=0), self.stowed[v].max(axis=0)] for v in self.vertices])
        pairs = []
        for f in np.flatnonzero(self.plane).tolist():
            later = slice(f + 1, None)
            meet = (corners[f, 0] <= corners[later, 1] + self.close) & (corners[later, 0] <= corners[f, 1] + self.close)
            parallel = np.abs(self.normals[later] @ self.normals[f]) > 1.0 - 1e-9
            found = f + 1 + np.flatnonzero(meet.all(axis=1) & parallel & self.plane[later])
            pairs += [(f, g) for g in found.tolist() if self._height(f, g) <= self.close]
        return pairs

    def overlap(self, f: int, g: int) -> np.ndarray | None:
        """(k, 3) corners of a convex region around where face f lies on g; None where it has no area."""
        x = self.gradients[g, :, 0]
        axes = np.stack([x, np.cross(self.normals[g], x)], axis=1)
        ends = [(self.stowed[np.array(self.borders[k])] - self.middles[g]) @ axes for k in (f, g)]
        triangles = [(self.stowed[self.mesh.triangles[self.elements[k]]] - self.middles[g]) @ axes for k in (f, g)]
        points = [_crossings(*ends)]
        for own, other in ((0, 1), (1, 0)):
            candidates = ends[own].reshape(-1, 2)
            points.append(candidates[_inside(candidates, triangles[other], self.close)])
        points = np.concatenate(points)
        cell = 10.0 * ROUND_OFF * self.mesh.size
        narrow = max(100.0, 10.0 * self.rounding / cell)
        rounded = np.unique(np.round(points / cell), axis=0)
        width = np.ptp(rounded, axis=0) if len(rounded) > 2 else np.zeros(2)
        if width.min() < narrow or np.linalg.matrix_rank(rounded - rounded[0], tol=narrow) < 2:
            return None
        hull = rounded[ConvexHull(rounded).vertices] * cell
        return self.middles[g] + hull @ axes.T

    def really_overlap(self, f: int, g: int) -> bool:
        """Whether some element of f lies on one of g: no side of either has them on its two sides."""
        x = self.gradients[g, :, 0]
        axes = np.stack([x, np.cross(self.normals[g], x)], axis=1) / np.linalg.norm(x)
        first, second = (self.stowed[self.mesh.triangles[self.elements[k]]] @ axes for k in (f, g))
        a, b = np.repeat(first, len(second), axis=0), np.tile(second, (len(first), 1, 1))
        apart = np.zeros(len(a), dtype=bool)
        for triangles in (a, b):
            for k in range(3):
                along = triangles[:, (k + 1) % 3] - triangles[:, k]
                across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
                one, two = (np.einsum("nkj,nj->nk", t, across) for t in (a, b))
                common = np.minimum(one.max(axis=1), two.max(axis=1)) - np.maximum(one.min(axis=1), two.min(axis=1))
                apart |= common < max(1000.0 * ROUND_OFF * self.mesh.size, 10.0 * self.rounding)
        return not apart.all()

    def apart(self, f: int, g: int, points: np.ndarray) -> np.ndarray:
        """Distance in the flat sheet of the points of faces f and g at `points`; the size of both where that has no
        meaning, m."""
        a, b = (self.flat_middles[k] + (points - self.middles[k]) @ np.linalg.pinv(self.gradients[k]).T for k in (f, g))
        if self.sheets[f] != self.sheets[g]:
            return np.full(len(points), np.linalg.norm(np.ptp(points, axis=0)))
        return np.linalg.norm(a - b, axis=1)

    def opening(self, overlaps: list[Overlap]) -> np.ndarray | None:
        """(6 nf,) c (m) and w of all faces that open `overlaps`, the largest rotation being 1; None: there are none."""
        count = len(self.middles)
        gaps = [self._rows(o.upper, o.folded, o.normal) - self._rows(o.lower, o.folded, o.normal) for o in overlaps]
        gaps = csr_matrix(np.concatenate(gaps))
        apart = np.concatenate([o.apart for o in overlaps])
        apart[apart < 100.0 * self.close] = 0.0
        at = self.stowed[self.shared[:, 0]]
        equal = csr_matrix(self._continuity(*(at - self.middles[self.shared[:, k]] for k in (1, 2))))
        cost = np.tile([1.0 / self.mesh.size] * 3 + [1.0] * 3, count)
        # x = a - b with a, b >= 0, whose cost is that of |x|
        found = linprog(
            np.concatenate([cost, cost]),
            A_ub=hstack([-gaps, gaps]),
            b_ub=10.0 * self.rounding - apart,  # corners of rounded faces lie as far beyond their crease
            A_eq=hstack([equal, -equal]),
            b_eq=np.zeros(equal.shape[0]),
        )
        if found.status != 0:
            return None
        x = found.x[: 6 * count] - found.x[6 * count :]
        return x / np.abs(x * cost).max()

    def displacements(self, x: np.ndarray) -> np.ndarray:
        """(nv, 3) linear displacements of the vertices, m."""
        result = np.zeros_like(self.stowed)
        for f, vertices in enumerate(self.vertices):
            c, w = x.reshape(-1, 2, 3)[f]
            result[vertices] = c + np.cross(w, self.stowed[vertices] - self.middles[f])
        return result

    def rigid(self, x: np.ndarray) -> np.ndarray | None:
        """(nv, 3) positions, m, of the vertices of faces moved rigidly, near x; None if they cannot hang together."""
        turns, middles = Rotation.from_rotvec(x.reshape(-1, 2, 3)[:, 1]), self.middles + x.reshape(-1, 2, 3)[:, 0]
        vertices, first, second = self.shared.T
        for _ in range(ITERATIONS):
            arms = [turns[f].apply(self.stowed[vertices] - self.middles[f]) for f in (first, second)]
            open_by = middles[second] + arms[1] - middles[first] - arms[0]
            if np.abs(open_by).max(initial=0.0) < 1e-6 * self.close:
                points = np.zeros_like(self.stowed)
                for f, own in enumerate(self.vertices):
                    points[own] = middles[f] + turns[f].apply(self.stowed[own] - self.middles[f])
                return points
            change = np.linalg.lstsq(self._continuity(*arms), -open_by.ravel(), rcond=1e-10)[0].reshape(-1, 2, 3)
            turns, middles = Rotation.from_rotvec(change[:, 1]) * turns, middles + change[:, 0]
        return None

    def _continuity(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """(3 k, 6 nf) by how much shared vertices open; arms (k, 3) of the vertex in its first and second face, m."""
        rows = np.zeros((len(self.shared), 3, len(self.middles), 2, 3))
        at = np.arange(len(self.shared))
        for sign, faces, arms in ((-1.0, self.shared[:, 1], first), (1.0, self.shared[:, 2], second)):
            for axis, unit in enumerate(np.eye(3)):
                rows[at, axis, faces, 0] = sign * unit
                rows[at, axis, faces, 1] = sign * np.cross(arms, unit)
        return rows.reshape(3 * len(at), -1)

    def _rows(self, f: int, points: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """(k, 6 nf) displacement of `points` of face f along `direction` from c and w of all faces."""
        rows = np.zeros((len(points), 6 * len(self.middles)))
        rows[:, 6 * f : 6 * f + 3] = direction
        rows[:, 6 * f + 3 : 6 * f + 6] = np.cross(points - self.middles[f], direction)
        return rows


def _inside(points: np.ndarray, triangles: np.ndarray, close: float) -> np.ndarray:
    """Which points (n, 2) lie in some of the triangles (m, 3, 2), or closer than `close` to it, m."""
    result = np.ones((len(points), len(triangles)), dtype=bool)
    turn = np.sign(_cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))
    for k in range(3):
        a, along = triangles[:, k], triangles[:, (k + 1) % 3] - triangles[:, k]
        height = turn * _cross(along, points[:, None] - a) / np.linalg.norm(along, axis=1)
        result &= height >= -close
    return result.any(axis=1)


def _crossings(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(k, 2) points where segments (n, 2, 2) cross segments (m, 2, 2)."""
    a, u = first[:, None, 0], (first[:, 1] - first[:, 0])[:, None]
    b, v = second[None, :, 0], (second[:, 1] - second[:, 0])[None]
    turn = _cross(u, v)
    crossing = np.abs(turn) > 1e-9 * np.linalg.norm(u, axis=2) * np.linalg.norm(v, axis=2)
    turn = np.where(crossing, turn, 1.0)
    s, t = _cross(b - a, v) / turn, _cross(b - a, u) / turn
    i, j = np.nonzero(crossing & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0))
    return first[i, 0] + s[i, j, None] * (first[i, 1] - first[i, 0])


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
