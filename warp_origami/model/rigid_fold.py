"""The folded state that fold angles describe: every triangle turned as a rigid panel about its neighbour's edge."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial.transform import Rotation

from .mesh import BOUNDARY, Mesh


def fold_rigidly(mesh: Mesh, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (nv, 3) of the vertices, m, and how far the panels of each vertex disagree about it (nv,), m.

    The first element of every connected sheet stays in place; the others follow along the shortest way across edges.

    Args:
        angles: (nd,) fold angle of each edge, rad, positive for a valley seen from +z.
    """
    flat = np.concatenate([mesh.vertices, np.zeros((len(mesh.vertices), 1))], axis=1)
    turns, shifts = _panel_motions(mesh, flat, angles)
    placed = np.einsum("eij,ekj->eki", turns, flat[mesh.triangles]) + shifts[:, None, :]

    corner = mesh.triangles.ravel()
    count = np.bincount(corner, minlength=len(flat))
    points = np.stack([np.bincount(corner, placed[..., c].ravel(), len(flat)) / count for c in range(3)], axis=1)
    gap = np.zeros(len(flat))
    np.maximum.at(gap, corner, np.linalg.norm(placed.reshape(-1, 3) - points[corner], axis=1))
    return points, gap


def _panel_motions(mesh: Mesh, flat: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (ne, 3, 3) and translation (ne, 3) of each element."""
    inner = np.flatnonzero(mesh.edge_kinds != BOUNDARY)
    left, right = mesh.edge_triangles[inner].T
    a = flat[mesh.edges[inner, 0]]
    axis = flat[mesh.edges[inner, 1]] - a
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    # Seen along the edge the right element rises in a valley: a negative turn; going back from right to left it is
    # the other way round.
    across = Rotation.from_rotvec(-angles[inner, None] * axis).as_matrix()

    ne = len(mesh.triangles)
    graph = coo_matrix((np.arange(1, len(inner) + 1), (left, right)), shape=(ne, ne)).tocsr()
    number = graph + graph.T
    turns, shifts = np.tile(np.eye(3), (ne, 1, 1)), np.zeros((ne, 3))
    sheets = connected_components(graph, directed=False)[1]
    for root in np.unique(sheets, return_index=True)[1]:
        order, before = breadth_first_order(graph, root, directed=False)
        via = np.asarray(number[order[1:], before[order[1:]]]).ravel() - 1 if len(order) > 1 else []
        for t, k in zip(order[1:], via, strict=True):
            turn = across[k] if right[k] == t else across[k].T
            s = before[t]
            turns[t] = turns[s] @ turn
            shifts[t] = shifts[s] + turns[s] @ (a[k] - turn @ a[k])
    return turns, shifts
