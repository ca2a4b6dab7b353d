"""Points and triangles of elements that are split into n^2 similar ones, numbered once for the whole mesh.

A lattice point of an element has area coordinates (n - i - j, i, j) / n: i runs from corner 0 to corner 1, j from 0 to
2. Points of the mesh are numbered: its vertices, the points along every edge from its first vertex to its second, the
points inside the elements.
"""

import numpy as np

from .mesh import Mesh


def lattice(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Integer area coordinates (m, 3) of the lattice, triangles (n^2, 3), the number (n + 1, n + 1) of point i, j."""
    number = np.full((n + 1, n + 1), -1)
    points = [(i, j) for j in range(n + 1) for i in range(n + 1 - j)]
    for k, (i, j) in enumerate(points):
        number[i, j] = k
    triangles = []
    for i, j in points:
        if i + j < n:
            triangles.append((number[i, j], number[i + 1, j], number[i, j + 1]))
        if i + j < n - 1:
            triangles.append((number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]))
    i, j = np.array(points).T
    return np.stack([n - i - j, i, j], axis=1), np.array(triangles), number


def edge_points(mesh: Mesh, n: int) -> np.ndarray:
    """(nd, n + 1) points along every edge."""
    inside = len(mesh.vertices) + np.arange(len(mesh.edges) * (n - 1)).reshape(len(mesh.edges), n - 1)
    return np.concatenate([mesh.edges[:, :1], inside, mesh.edges[:, 1:]], axis=1)


def element_points(mesh: Mesh, n: int) -> np.ndarray:
    """(ne, m) points at the lattice points of every element."""
    areas, _, number = lattice(n)
    along = edge_points(mesh, n)
    ne = len(mesh.triangles)
    points = np.empty((ne, len(areas)), dtype=np.int64)
    s = np.arange(n + 1)
    for k, side in enumerate((number[s, 0], number[n - s, s], number[0, n - s])):
        row = mesh.element_edges[:, k]
        forward = mesh.edge_triangles[row, 0] == np.arange(ne)
        points[:, side] = np.where(forward[:, None], along[row], along[row, ::-1])
    inside = np.flatnonzero((areas > 0).all(axis=1))
    first = len(mesh.vertices) + len(mesh.edges) * (n - 1)
    points[:, inside] = first + np.arange(ne * len(inside)).reshape(ne, -1)
    return points
