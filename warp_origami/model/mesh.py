"""The flat pattern, split into triangular elements."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

SMOOTH, CREASE, BOUNDARY = 0, 1, 2
"""Kinds of mesh edges. A cut of the pattern is two BOUNDARY edges with their own vertices."""


@dataclass(frozen=True)
class Mesh:
    """Triangles of the flat sheet with the kind of every edge.

    All elements use one flat reference frame, so that continuity of the gradient across a smooth edge (50) is plain
    sharing of nodal gradients.

    Attributes:
        vertices: (nv, 2) flat coordinates, m.
        triangles: (ne, 3) int32 vertices of each element, counter-clockwise seen from +z.
        edges: (nd, 2) int32 vertices of each edge, each edge once.
        edge_triangles: (nd, 2) int32 elements on both sides, -1 where there is none.
        edge_kinds: (nd,) int8, SMOOTH, CREASE or BOUNDARY.
        edge_assignments: (nd,) '<U1', the letter of the crease pattern: M, V, U (creases), F (smooth), B (boundary).
        faces: (ne,) int32 face of each element: a face is a connected set of elements without a crease between them.
        sources: (nv,) int32 index of the vertex in the pattern as given (its file or generator). A cut duplicates
            vertices: copies have the same source. -1 for vertices added by refinement.
        boundary_parents: (nv, 2) int32, for a vertex that refinement added on a boundary edge the two mesh vertices that
            are the ends of that edge of the pattern; -1 elsewhere.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    edge_triangles: np.ndarray
    edge_kinds: np.ndarray
    edge_assignments: np.ndarray
    faces: np.ndarray
    sources: np.ndarray
    boundary_parents: np.ndarray

    @cached_property
    def areas(self) -> np.ndarray:
        """(ne,) flat areas, m^2."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))

    @cached_property
    def size(self) -> float:
        """Diagonal of the flat bounding box, m: the length that tolerances are relative to."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))
