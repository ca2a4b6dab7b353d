"""The order of layers that coincide in a flat-folded state (FOLD `faceOrders`), from a state that is nearly as folded.

Where face f lies on face g, a point of the common part is found in both, and followed into the state where the layers
are apart: the order is the sign of its height over g, along the normal of g.
"""

import numpy as np

from .mesh import Mesh
from .opening import FoldedFaces


def layer_orders(mesh: Mesh, pattern_faces: np.ndarray, folded: np.ndarray, nearly: np.ndarray) -> np.ndarray:
    """(k, 3) rows (f, g, s) as in Pattern.face_orders, one for each pair of faces with a common part.

    Args:
        pattern_faces: (ne,) face of the pattern that each element lies in.
        folded: (nv, 3) positions where layers coincide, m.
        nearly: (nv, 3) positions close to these, with the layers apart, m.
    """
    closed, apart = FoldedFaces(mesh, folded), FoldedFaces(mesh, nearly)
    owner = np.zeros(len(closed.middles), dtype=int)
    owner[mesh.faces] = pattern_faces
    orders = []
    for f, g in closed.coincident_pairs():
        corners = closed.overlap(f, g)
        if corners is None:
            continue
        points = [_followed(k, corners, closed, apart) for k in (f, g)]
        height = float(np.mean((points[0] - points[1]) @ apart.normals[g]))
        orders.append((owner[f], owner[g], 1 if height > 0.0 else -1))
    return np.array(orders, dtype=int).reshape(-1, 3)


def _followed(face: int, points: np.ndarray, before: FoldedFaces, after: FoldedFaces) -> np.ndarray:
    """Where points (k, 3) of a face in one folded state are in another, m."""
    flat = (points - before.middles[face]) @ np.linalg.pinv(before.gradients[face]).T
    return after.middles[face] + flat @ after.gradients[face].T
