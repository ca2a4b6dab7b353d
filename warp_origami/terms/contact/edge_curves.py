"""Creases and free edges of the sheet as cubic curves whose control points are linear in q."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.model.connectivity import sheet_labels
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.edge_traces import edge_traces
from warp_origami.model.mesh import SMOOTH, Mesh

BEZIER = np.array([[3.0, 0.0, 0.0, 0.0], [3.0, 1.0, 0.0, 0.0], [0.0, 0.0, 3.0, -1.0], [0.0, 0.0, 3.0, 0.0]]) / 3.0
"""Control points of a cubic from its ends and slopes [r, dr/ds, r, dr/ds]."""


@dataclass(frozen=True)
class EdgeCurves:
    """The edges that contact looks at, borders of faces: creases and free edges.

    Attributes:
        edges: (k,) numbers of the mesh's edges.
        vertices: (k, 2) int32 mesh vertices at the ends.
        flat: (k, 2, 2) ends in the flat sheet, m.
        sheets: (k,) connected part of the mesh that each edge belongs to.
        elements: (k,) an element that each edge belongs to.
        controls: (4 k, n) matrix: control points, four per edge, are this times q.
    """

    edges: np.ndarray
    vertices: np.ndarray
    flat: np.ndarray
    sheets: np.ndarray
    elements: np.ndarray
    controls: csr_matrix

    @property
    def lengths(self) -> np.ndarray:
        """(k,) flat lengths, m."""
        return np.linalg.norm(self.flat[:, 1] - self.flat[:, 0], axis=1)

    def flat_controls(self) -> np.ndarray:
        """(4 k, 3) control points in the flat sheet (z = 0), m."""
        a, b = np.pad(self.flat, ((0, 0), (0, 0), (0, 1))).transpose(1, 0, 2)
        s = np.arange(4)[:, None] / 3.0
        return (a[:, None] + s * (b - a)[:, None]).reshape(-1, 3)


def build_curves(mesh: Mesh, coordinates: Coordinates) -> EdgeCurves:
    """Curves of all edges of kind CREASE or BOUNDARY, traced from their first element."""
    edges = np.flatnonzero(mesh.edge_kinds != SMOOTH)
    traces = edge_traces(mesh, coordinates, edges, np.zeros(len(edges), dtype=int))
    vertices = mesh.edges[edges]
    sheets = sheet_labels(mesh.edges, len(mesh.vertices))[vertices[:, 0]]
    values = BEZIER @ traces.matrices
    rows = np.repeat(traces.rows[:, None], 4, axis=1)
    starts = np.arange(0, values.size + 1, 6)
    controls = csr_matrix((values.ravel(), rows.ravel(), starts), shape=(4 * len(edges), coordinates.count))
    controls.eliminate_zeros()
    elements = mesh.edge_triangles[edges, 0]
    return EdgeCurves(edges, vertices.astype(np.int32), mesh.vertices[vertices], sheets, elements, controls)


def flat_distances(curves: EdgeCurves, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(k,) distances (m) of straight edges of the flat sheet that do not cross: from an end of one to the other."""
    result = np.full(len(first), np.inf)
    for a, b in ((first, second), (second, first)):
        start = curves.flat[b, 0]
        along = curves.flat[b, 1] - start
        for end in (0, 1):
            x = curves.flat[a, end] - start
            s = np.clip(np.einsum("ij,ij->i", x, along) / np.einsum("ij,ij->i", along, along), 0.0, 1.0)
            result = np.minimum(result, np.linalg.norm(x - s[:, None] * along, axis=1))
    return result


def bernstein(s: np.ndarray) -> np.ndarray:
    """(3, k, 4) cubic Bernstein polynomials at s (k,), their first and their second derivatives."""
    r = 1.0 - s
    values = [r**3, 3.0 * s * r**2, 3.0 * s**2 * r, s**3]
    first = [-3.0 * r**2, 3.0 * r * (r - 2.0 * s), 3.0 * s * (2.0 * r - s), 3.0 * s**2]
    second = [6.0 * r, 6.0 * (s - 2.0 * r), 6.0 * (r - 2.0 * s), 6.0 * s]
    return np.array([values, first, second]).transpose(0, 2, 1)
