"""Where layers have passed through each other, and how deep: the geometry of one state, whatever model made it.

ipctk decides on a sub-mesh whether the sheet intersects itself. Where it does, sub-edges pass through sub-triangles:

    x_0 + t (x_1 - x_0) = a + u (b - a) + v (c - a),   0 <= t, u, v, 1 - u - v <= 1,   no corner shared.

Of two faces A and B that do, the points of A that have their nearest point inside B, not on its rim, lie on both sides
of B: d > 0 and d < 0. Only those count that are joined to the sub-edges of A that pass through B by points on the same
side. Depth is the lesser of the two largest distances, max d and max -d, of the points of A from B or of those of B
from A, whichever is more: what would have to be pushed back, from mid-surface to mid-surface. Where there are no such
points, beside a rim, it is the least of how far both ends of a sub-edge lie from the plane of the sub-triangle that it
passes through, and how far it passes from the rim of that face.
"""

from dataclasses import dataclass

import ipctk
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from warp_origami.model.submesh import Submesh


@dataclass(frozen=True)
class Crossing:
    """How one face lies partly beyond another.

    Attributes:
        face, beyond: A and B.
        depth: m.
        flat: (2,) the deepest point of A in the flat sheet, m.
        creases: how many sub-edges on creases and free edges of either pass through the other.
        inner: how many inside of the faces do.
    """

    face: int
    beyond: int
    depth: float
    flat: np.ndarray
    creases: int
    inner: int


class CrossingOracle:
    """Looks at states on one sub-mesh.

    Args:
        submesh: on which "crosses" is decided.
        rest: (np, 3) its points in an uncrossed state.
    """

    def __init__(self, submesh: Submesh, rest: np.ndarray):
        self.submesh, self.triangles = submesh, submesh.triangles.astype(np.int32)
        self.edges = np.sort(ipctk.edges(self.triangles), axis=1)
        self.oracle = ipctk.CollisionMesh(rest, self.edges, self.triangles)
        numbers = self.edges @ [len(rest), 1]
        order = np.argsort(numbers)
        sides = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2) @ [len(rest), 1]
        sides = order[np.searchsorted(numbers[order], sides)]  # (nt, 3) sub-edge of each side
        self.on_crease = np.zeros(len(self.edges), dtype=bool)
        self.on_crease[sides[submesh.outer_edges]] = True
        self.of_face = np.zeros((submesh.triangle_faces.max() + 1, len(self.edges)), dtype=bool)
        self.of_face[submesh.triangle_faces[:, None], sides] = True

    def crosses(self, points: np.ndarray) -> bool:
        """Whether the sheet passes through itself."""
        return ipctk.has_intersections(self.oracle, points)

    def crossed_triangles(self, points: np.ndarray) -> np.ndarray:
        """(k,) sub-triangles that a sub-edge passes through."""
        return np.unique(self._intersections(points)[1])

    def find(self, points: np.ndarray) -> list[Crossing]:
        """All pairs of faces that pass through each other, the deepest first."""
        edges, triangles, places = self._intersections(points)
        cuts: dict[tuple[int, int], list[int]] = {}
        for hit, edge in enumerate(edges):
            beyond = int(self.submesh.triangle_faces[triangles[hit]])
            for face in np.flatnonzero(self.of_face[:, edge]).tolist():
                if face != beyond:
                    cuts.setdefault((min(face, beyond), max(face, beyond)), []).append(hit)
        found = []
        for pair, hits in cuts.items():
            through = np.unique(edges[hits])
            ways = [(*self._depth(points, *way, through), *way) for way in (pair, pair[::-1])]
            depth, flat, face, beyond = max(ways, key=lambda way: way[0])
            if depth == 0.0:
                hit = max(hits, key=lambda hit: self._tip(points, edges[hit], triangles[hit], places[hit])[0])
                depth, flat = self._tip(points, edges[hit], triangles[hit], places[hit])
                beyond = int(self.submesh.triangle_faces[triangles[hit]])
                face = sum(pair) - beyond
            creases = int(self.on_crease[through].sum())
            found.append(Crossing(face, beyond, depth, flat, creases, len(through) - creases))
        return sorted(found, key=lambda c: -c.depth)

    def _intersections(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sub-edges, the sub-triangles that they pass through, and where (k, 3)."""
        ends, corners = points[self.edges], points[self.triangles]
        centres = corners.mean(axis=1)
        reach = 0.5 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max()
        reach += np.linalg.norm(corners - centres[:, None], axis=2).max()
        near = cKDTree(ends.mean(axis=1)).sparse_distance_matrix(cKDTree(centres), reach, output_type="ndarray")
        edge, triangle = near["i"], near["j"]
        overlap = (ends.min(axis=1)[edge] <= corners.max(axis=1)[triangle]).all(axis=1)
        overlap &= (ends.max(axis=1)[edge] >= corners.min(axis=1)[triangle]).all(axis=1)
        edge, triangle = edge[overlap], triangle[overlap]
        apart = ~(self.edges[edge][:, :, None] == self.triangles[triangle][:, None, :]).any(axis=(1, 2))
        edge, triangle = edge[apart], triangle[apart]
        along, (a, b, c) = ends[edge, 1] - ends[edge, 0], np.moveaxis(corners[triangle], 1, 0)
        from_a = ends[edge, 0] - a
        normal, turned = np.cross(b - a, c - a), np.cross(along, from_a)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = -_dot(along, normal)
            t, u, v = _dot(from_a, normal) / slope, -_dot(turned, c - a) / slope, _dot(turned, b - a) / slope
        hit = (t >= 0) & (t <= 1) & (u >= 0) & (v >= 0) & (u + v <= 1)
        return edge[hit], triangle[hit], (ends[edge, 0] + t[:, None] * along)[hit]

    def _tip(self, points: np.ndarray, edge: int, triangle: int, place: np.ndarray) -> tuple[float, np.ndarray]:
        """What would have to be pushed back of a sub-edge that passes through beside a rim at `place`, and where."""
        a, b, c = points[self.triangles[triangle]]
        normal = np.cross(b - a, c - a)
        heights = np.abs((points[self.edges[edge]] - a) @ normal) / np.linalg.norm(normal)
        rim = points[self.edges[self.of_face[self.submesh.triangle_faces[triangle]] & self.on_crease]]
        along = rim[:, 1] - rim[:, 0]
        share = np.clip(_dot(place - rim[:, 0], along) / _dot(along, along), 0.0, 1.0)
        beside = np.linalg.norm(rim[:, 0] + share[:, None] * along - place, axis=1).min()
        return min(float(heights.min()), float(beside)), self.submesh.flat[self.edges[edge, np.argmin(heights)]]

    def _depth(self, points: np.ndarray, face: int, beyond: int, through: np.ndarray) -> tuple[float, np.ndarray]:
        """The lesser of the largest distances of the face from the other on either side of it, and where that is."""
        edges = self.edges[self.of_face[face]]
        mine, numbers = np.unique(edges, return_inverse=True)
        numbers = numbers.reshape(edges.shape)
        other = self.submesh.triangle_faces == beyond
        signed = signed_distances(points[mine], points[self.triangles[other]], self.submesh.outer_edges[other])
        same = numbers[np.sign(signed[numbers]).prod(axis=1) > 0]
        graph = coo_matrix((np.ones(len(same)), tuple(same.T)), shape=(len(mine), len(mine)))
        labels = connected_components(graph, directed=False)[1]
        ends = numbers[np.isin(np.flatnonzero(self.of_face[face]), through)]
        signed[~np.isin(labels, labels[ends])] = 0.0
        least, most = int(np.argmin(signed)), int(np.argmax(signed))
        deepest = least if -signed[least] < signed[most] else most
        return max(0.0, min(-float(signed[least]), float(signed[most]))), self.submesh.flat[mine[deepest]]


def signed_distances(points: np.ndarray, triangles: np.ndarray, rims: np.ndarray) -> np.ndarray:
    """(n,) distances of points (n, 3) from the surface of triangles (m, 3, 3), positive on the side of its normals, m.

    0 for points whose nearest point is on a side that is a rim of the surface, as `rims` (m, 3) tells of every side.
    """
    x, corners = points[:, None], triangles[None]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = _dot(x - corners[:, :, 0], normal)
    inside = np.ones_like(height, dtype=bool)
    nearest, on_rim = np.full_like(height, np.inf), np.zeros_like(height, dtype=bool)
    for side in range(3):
        from_start, along = x - corners[:, :, side], triangles[:, (side + 1) % 3] - triangles[:, side]
        inside &= _dot(np.cross(normal, along), from_start) >= 0.0
        share = np.clip(_dot(from_start, along) / _dot(along, along), 0.0, 1.0)
        distance = np.linalg.norm(from_start - share[..., None] * along, axis=2)
        tie = np.isclose(distance, nearest, rtol=1e-9, atol=0.0)  # at a corner: on the rim if one of its sides is
        on_rim = np.where(tie, on_rim | rims[:, side], np.where(distance < nearest, rims[:, side], on_rim))
        nearest = np.minimum(nearest, distance)
    nearest = np.where(inside, np.abs(height), nearest)
    on_rim &= ~inside
    best = np.argmin(nearest, axis=1)
    row = np.arange(len(points))
    rim = (on_rim & (nearest <= nearest[row, best][:, None] * (1.0 + 1e-9))).any(axis=1)
    return np.where(rim, 0.0, np.copysign(nearest[row, best], height[row, best]))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i", a, b)
