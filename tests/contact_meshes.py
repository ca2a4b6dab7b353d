"""Small meshes written out by hand for the tests of contact: no generator stands between a claim and its check."""

import json

import numpy as np

from warp_origami.model.connectivity import list_edges
from warp_origami.model.fold import read_fold
from warp_origami.model.mesh import Mesh, assemble_mesh


def mesh_of(vertices, triangles, is_crease=lambda middle: np.zeros(len(middle), bool)) -> Mesh:
    """Mesh whose inner edges are creases where `is_crease(midpoints)` says so."""
    vertices = np.asarray(vertices, dtype=float)
    triangles = np.asarray(triangles, dtype=np.int32)
    edges, edge_triangles = list_edges(triangles, len(vertices))
    inner = np.where(is_crease(vertices[edges].mean(axis=1)), "M", "F")
    letters = np.where(edge_triangles[:, 1] < 0, "B", inner)
    none = np.full((len(vertices), 2), -1)
    return assemble_mesh(vertices, triangles, edges, edge_triangles, letters, np.arange(len(vertices)), none)


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


def cut_square(folder):
    """The mesh of a unit square that is cut along its diagonal, by way of a FOLD file."""
    content = {
        "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]],
        "edges_assignment": ["B", "B", "B", "B", "C"],
        "faces_vertices": [[0, 1, 2], [0, 2, 3]],
    }
    (folder / "cut.fold").write_text(json.dumps(content))
    return read_fold(folder / "cut.fold").mesh
