"""Vertices, edges and triangles as what may pass through each other: those of the sub-mesh, and how they move."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.lattice import edge_points, element_points
from warp_origami.model.mesh import BOUNDARY, Mesh
from warp_origami.model.submesh import Submesh

from ..shapes import tabulate

LIP_RESOLUTION = 1e-6
"""Part of a cut's length below which two points of its lips are at one place."""


@dataclass(frozen=True)
class FeatureMesh:
    """Triangles in space whose points are linear in q, with their vertices and edges.

    Attributes:
        interpolation: (np, n) matrix: positions of the points are this times q, m.
        flat: (np, 2) flat positions of the points, m.
        elements: (np,) an element that each point belongs to.
        groups: (np,) int32 equal for points that are at one place of the pattern: those of two lips of a cut.
        triangles: (nt, 3) int32 points of the triangles.
        triangle_elements: (nt,) element of each triangle.
        edges: (nd, 2) int32 points of their sides, each once.
        edge_elements: (nd,) an element that each edge belongs to.
        islands: (np,) int32 part of the mesh that each point belongs to, where only features of one part can meet;
            None: all can.
    """

    interpolation: csr_matrix
    flat: np.ndarray
    elements: np.ndarray
    groups: np.ndarray
    triangles: np.ndarray
    triangle_elements: np.ndarray
    edges: np.ndarray
    edge_elements: np.ndarray
    islands: np.ndarray | None = None

    @property
    def edge_lengths(self) -> np.ndarray:
        """(nd,) lengths of the edges in the flat sheet, m."""
        return np.linalg.norm(np.diff(self.flat[self.edges], axis=1)[:, 0], axis=1)


def submesh_features(mesh: Mesh, coordinates: Coordinates, submesh: Submesh) -> FeatureMesh:
    """Features of `submesh`, which is build_submesh(mesh, k) for some k."""
    edges, edge_elements = edges_of(submesh.triangles, submesh.triangle_elements)
    return FeatureMesh(
        interpolation=tabulate(mesh, submesh.elements, submesh.areas).interpolation(coordinates),
        flat=submesh.flat,
        elements=submesh.elements,
        groups=_groups(mesh, submesh),
        triangles=submesh.triangles,
        triangle_elements=submesh.triangle_elements,
        edges=edges,
        edge_elements=edge_elements,
    )


def edges_of(triangles: np.ndarray, triangle_elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sides (nd, 2) int32 of triangles (nt, 3), each once, and an element of each."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, first = np.unique(np.sort(sides, axis=1), axis=0, return_index=True)
    return edges.astype(np.int32), triangle_elements[first // 3]


def _groups(mesh: Mesh, submesh: Submesh) -> np.ndarray:
    """Group of every point: the copies of a vertex of the pattern, or of one place on an edge of it, that cuts make."""
    groups = np.arange(len(submesh.flat), dtype=np.int32)
    rim = mesh.edge_kinds == BOUNDARY
    numbers = np.unique(element_points(mesh, submesh.divisions))
    points = np.searchsorted(numbers, edge_points(mesh, submesh.divisions)[rim])
    ends = mesh.edges[rim]
    parents = mesh.boundary_parents[ends].max(axis=1)  # an end that refinement added knows the edge it was added on
    ends = np.where(parents >= 0, parents, ends)
    sources = mesh.sources[ends]
    turned = sources[:, 0] > sources[:, 1]
    ends[turned], sources[turned] = ends[turned, ::-1], sources[turned, ::-1]

    a, b = mesh.vertices[ends[:, 0]], mesh.vertices[ends[:, 1]]
    along = np.einsum("ekd,ed->ek", submesh.flat[points] - a[:, None], b - a) / np.sum((b - a) ** 2, axis=1)[:, None]
    places = np.round(along / LIP_RESOLUTION).astype(np.int64)
    names = np.stack(np.broadcast_arrays(sources[:, :1], sources[:, 1:], places), axis=2).reshape(-1, 3)
    # a point at an end of an edge is the vertex there, whichever of its edges it is seen on
    for end, place in ((0, 0), (1, round(1.0 / LIP_RESOLUTION))):
        there = names[:, 2] == place
        names[there, :2], names[there, 2] = names[there, end : end + 1], 0
    _, first, same = np.unique(names, axis=0, return_index=True, return_inverse=True)
    groups[points.ravel()] = points.ravel()[first][same.ravel()]
    return groups
