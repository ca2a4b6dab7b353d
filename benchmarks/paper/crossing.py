"""Where layers have passed through each other, when and how deep: the geometry of one state, whatever model made it.

ipctk decides on a sub-mesh whether the sheet intersects itself. Where it does, sub-edges pass through sub-triangles:

    x_0 + t (x_1 - x_0) = a + u (b - a) + v (c - a),   0 <= t, u, v, 1 - u - v <= 1,   no corner shared.

Per ordered pair of faces (A, B), taking the sub-edges of A that pass through B away leaves A in pieces. All but the
largest have come out on the other side of B; their largest distance from B is the depth. A piece exists only if the
line of intersection runs through the whole of A; where B's corner pokes into A, it is B that is cut.
"""

from dataclasses import dataclass

import ipctk
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from warp_origami.model.mesh import SMOOTH, Mesh
from warp_origami.model.submesh import Submesh


@dataclass(frozen=True)
class Crossing:
    """How one face lies partly beyond another.

    Attributes:
        piece_of, beyond: faces A and B.
        depth: of the deepest point of the piece of A, m; 0 if neither is cut through.
        flat: (2,) that point in the flat sheet, m; nan if neither is cut through.
        on_boundary: a boundary of an element (crease, smooth or free edge) passes through.
        inside: an inner sub-edge of an element passes through.
    """

    piece_of: int
    beyond: int
    depth: float
    flat: np.ndarray
    on_boundary: bool
    inside: bool


class CrossingOracle:
    """Looks at states on one sub-mesh.

    Args:
        mesh: flat sheet.
        submesh: where "crosses" is decided.
        rest: (np, 3) its points in an uncrossed state.
    """

    def __init__(self, mesh: Mesh, submesh: Submesh, rest: np.ndarray):
        self.submesh, self.triangles = submesh, submesh.triangles.astype(np.int32)
        self.edges = ipctk.edges(self.triangles)
        self.oracle = ipctk.CollisionMesh(rest, self.edges, self.triangles)
        k = submesh.divisions
        sides = {tuple(edge) for edge in np.sort(_rim_edges(submesh, k), axis=1)}
        self.boundary = np.array([tuple(edge) in sides for edge in np.sort(self.edges, axis=1)])
        keys = np.sort(self.edges, axis=1) @ [len(rest), 1]
        ends = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2) @ [len(rest), 1]
        order = np.argsort(keys)
        place = order[np.searchsorted(keys[order], ends)]  # (nt, 3) sub-edge of each side
        self.edge_faces = coo_matrix(
            (np.ones(place.size), (place.ravel(), np.repeat(submesh.triangle_faces, 3))),
            shape=(len(self.edges), mesh.faces.max() + 1),
        ).tocsr()

    def crosses(self, points: np.ndarray) -> bool:
        """Whether the sheet passes through itself."""
        return ipctk.has_intersections(self.oracle, points)

    def find(self, points: np.ndarray) -> list[Crossing]:
        """All pairs of faces that pass through each other, the deepest first."""
        edges, triangles = self._intersections(points)
        found: dict[tuple[int, int], list[int]] = {}
        for edge, triangle in zip(edges, triangles, strict=True):
            through = int(self.submesh.triangle_faces[triangle])
            for face in self.edge_faces.indices[self.edge_faces.indptr[edge] : self.edge_faces.indptr[edge + 1]]:
                found.setdefault((int(face), through), []).append(edge)
        crossings = {}
        for (face, through), cut in found.items():
            crossing = self._depth(points, face, through, np.unique(cut))
            pair = (min(face, through), max(face, through))
            if pair not in crossings or crossing.depth > crossings[pair].depth:
                crossings[pair] = crossing
        return sorted(crossings.values(), key=lambda c: -c.depth)

    def _intersections(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sub-edges and the sub-triangles that they pass through."""
        ends, corners = points[self.edges], points[self.triangles]
        middles, centres = ends.mean(axis=1), corners.mean(axis=1)
        reach = 0.5 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max()
        reach += np.linalg.norm(corners - centres[:, None], axis=2).max()
        near = cKDTree(middles).query_ball_tree(cKDTree(centres), reach)
        edge = np.repeat(np.arange(len(ends)), [len(row) for row in near])
        triangle = np.concatenate([np.asarray(row, dtype=int) for row in near])
        apart = ~(self.edges[edge][:, :, None] == self.triangles[triangle][:, None, :]).any(axis=(1, 2))
        edge, triangle = edge[apart], triangle[apart]
        start, along = ends[edge, 0], ends[edge, 1] - ends[edge, 0]
        a, ab = corners[triangle, 0], corners[triangle, 1] - corners[triangle, 0]
        ac, from_a = corners[triangle, 2] - a, start - a
        normal = np.cross(ab, ac)
        slope = np.einsum("ij,ij->i", along, normal)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = -np.einsum("ij,ij->i", from_a, normal) / slope
            turned = np.cross(along, from_a)
            u = np.einsum("ij,ij->i", turned, ac) / slope
            v = -np.einsum("ij,ij->i", turned, ab) / slope
        hit = (t >= 0) & (t <= 1) & (u >= 0) & (v >= 0) & (u + v <= 1)
        return edge[hit], triangle[hit]

    def _depth(self, points: np.ndarray, face: int, through: int, cut: np.ndarray) -> Crossing:
        mine = self.edge_faces[:, face].indices if False else self.edge_faces[:, [face]].nonzero()[0]
        kept = self.edges[np.setdiff1d(mine, cut)]
        members = np.unique(self.edges[mine])
        graph = coo_matrix((np.ones(len(kept)), tuple(kept.T)), shape=(len(points), len(points)))
        _, labels = connected_components(graph, directed=False)
        names, sizes = np.unique(labels[members], return_counts=True)
        piece = members[labels[members] != names[np.argmax(sizes)]]
        depth, flat = 0.0, np.full(2, np.nan)
        if len(piece):
            other = self.triangles[self.submesh.triangle_faces == through]
            distances = _distances(points[piece], points[other])
            deepest = int(np.argmax(distances))
            depth, flat = float(distances[deepest]), self.submesh.flat[piece[deepest]]
        on_boundary = bool(self.boundary[cut].any())
        return Crossing(face, through, depth, flat, on_boundary, bool((~self.boundary[cut]).any()))
