"""Small meshes written out by hand for the tests of contact: no generator stands between a claim and its check."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from warp_origami.model.mesh import BOUNDARY, CREASE, SMOOTH, Mesh


def mesh_of(vertices, triangles, is_crease=lambda middle: np.zeros(len(middle), bool)) -> Mesh:
    """Mesh whose inner edges are creases where `is_crease(midpoints)` says so."""
    vertices = np.asarray(vertices, dtype=float)
    triangles = np.asarray(triangles, dtype=np.int32)
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, inverse, counts = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    edge_triangles = np.full((len(edges), 2), -1, dtype=np.int32)
    for side, edge in enumerate(inverse.ravel()):
        edge_triangles[edge, int(edge_triangles[edge, 0] >= 0)] = side // 3
    kinds = np.full(len(edges), SMOOTH, dtype=np.int8)
    kinds[is_crease(vertices[edges].mean(axis=1))] = CREASE
    kinds[counts == 1] = BOUNDARY
    pairs = edge_triangles[kinds == SMOOTH]
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(triangles),) * 2)
    faces = connected_components(graph, directed=False)[1].astype(np.int32)
    return Mesh(
        vertices=vertices,
        triangles=triangles,
        edges=edges.astype(np.int32),
        edge_triangles=edge_triangles,
        edge_kinds=kinds,
        edge_assignments=np.array(["F", "M", "B"])[kinds],
        faces=faces,
        sources=np.arange(len(vertices), dtype=np.int32),
        boundary_parents=np.full((len(vertices), 2), -1, dtype=np.int32),
    )


def grid(nx, ny, size=(1.0, 1.0), origin=(0.0, 0.0), angle=0.0):
    """Vertices and triangles of a rectangle of nx x ny cells, turned about its middle."""
    x, y = np.meshgrid(
        np.linspace(-0.5, 0.5, nx + 1) * size[0], np.linspace(-0.5, 0.5, ny + 1) * size[1], indexing="ij"
    )
    c, s = np.cos(angle), np.sin(angle)
    vertices = np.stack([x.ravel(), y.ravel()], axis=1) @ np.array([[c, s], [-s, c]]) + origin
    i, j = np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij")
    a = (i * (ny + 1) + j).ravel()
    b, d = a + ny + 1, a + 1
    c = b + 1
    return vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def joined(*parts):
    """One list of vertices and triangles out of several."""
    offsets = np.cumsum([0] + [len(v) for v, _ in parts])
    return (
        np.concatenate([v for v, _ in parts]),
        np.concatenate([t + o for (_, t), o in zip(parts, offsets[:-1], strict=True)]),
    )
