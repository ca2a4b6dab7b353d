"""Whether plane triangles in space pass through each other."""

import numpy as np
from scipy.spatial import cKDTree

ROUND_OFF = 1e-12
"""Volume over the cube of the distance of corners that counts as none: elements of one plane face do not cross."""


def find_crossing(points: np.ndarray, edges: np.ndarray, triangles: np.ndarray) -> tuple[int, int] | None:
    """An edge and a triangle without a common vertex that cross, as their numbers; None if there are none.

    Args:
        points: (n, 3), m.
        edges: (k, 2) vertices of the edges of the triangles.
        triangles: (m, 3) vertices.

    Triangles that only touch, or lie on each other in one plane, do not cross.
    """
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    corners = points[triangles]
    middle = corners.mean(axis=1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max()
    reach = 0.5 * np.linalg.norm(b - a, axis=1) + radius
    near = cKDTree(middle).query_ball_point(0.5 * (a + b), reach, return_sorted=True)
    edge = np.repeat(np.arange(len(edges)), [len(found) for found in near])
    triangle = np.concatenate([np.asarray(found, dtype=int) for found in near]) if len(near) else edge
    apart = (edges[edge][:, :, None] != triangles[triangle][:, None, :]).all(axis=(1, 2))
    edge, triangle = edge[apart], triangle[apart]
    crossing = _cross(a[edge], b[edge], corners[triangle])
    if not crossing.any():
        return None
    first = int(np.argmax(crossing))
    return int(edge[first]), int(triangle[first])


def _cross(a: np.ndarray, b: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(k,) bool: the ends lie on both sides of the plane, and the segment goes through the inside of the triangle."""

    def volume(p, q, r, s):
        return np.einsum("ij,ij->i", np.cross(q - p, r - p), s - p)

    x, y, z = corners[:, 0], corners[:, 1], corners[:, 2]
    none = ROUND_OFF * np.linalg.norm(corners - a[:, None], axis=2).max(axis=1) ** 3
    above, below = volume(x, y, z, a), volume(x, y, z, b)
    through = (np.minimum(np.abs(above), np.abs(below)) > none) & (above * below < 0.0)
    turns = np.stack([volume(a, b, x, y), volume(a, b, y, z), volume(a, b, z, x)])
    return through & ((turns > none).all(axis=0) | (turns < -none).all(axis=0))
