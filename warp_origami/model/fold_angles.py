"""Fold angles of a folded mesh, in the sense of the FOLD format."""

import numpy as np

from .mesh import Mesh


def fold_angles(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """(nd,) turn from one element's plane to the other's at each edge, rad, in (-pi, pi]; 0 on the boundary.

    Positive is a valley seen from the side on which the elements are counter-clockwise, negative a mountain.

    Args:
        points: (nv, 3) positions of the mesh's vertices, m.
    """
    a, b, c = (points[mesh.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    along = points[mesh.edges[:, 1]] - points[mesh.edges[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    left, right = (normals[mesh.edge_triangles[:, k]] for k in (0, 1))
    sine = np.einsum("ij,ij->i", np.cross(right, left), along)
    angles = np.arctan2(sine, np.einsum("ij,ij->i", left, right))
    return np.where(mesh.edge_triangles[:, 1] >= 0, angles, 0.0)
