"""Which triangles meet at an edge, and how the triangles around a vertex hang together."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


class ConnectivityError(ValueError):
    """The edge between vertices `ends` of a triangulation cannot belong to a sheet; `reason` says why."""

    def __init__(self, ends: tuple[int, int], reason: str):
        self.ends = ends
        self.reason = reason
        super().__init__(f"edge {ends[0]}-{ends[1]}: {reason}")


def list_edges(triangles: np.ndarray, vertex_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges (nd, 2) of counter-clockwise triangles (ne, 3) and their triangles (nd, 2).

    An edge runs counter-clockwise around its first triangle; the second is -1 where there is none.

    Raises:
        ConnectivityError: an edge has more than two triangles, or two on the same side.
    """
    starts = triangles.ravel()
    ends = np.roll(triangles, -1, axis=1).ravel()
    keys = edge_keys(starts, ends, vertex_count)
    order = np.argsort(keys, kind="stable")
    _, first, count = np.unique(keys[order], return_index=True, return_counts=True)
    if count.max(initial=0) > 2:
        bad = order[first[np.argmax(count)]]
        raise ConnectivityError(_pair(starts[bad], ends[bad]), f"{count.max()} triangles meet there")

    one = order[first]
    two = order[first + count - 1]
    paired = count == 2
    same_way = paired & (starts[one] == starts[two])
    if same_way.any():
        bad = one[np.argmax(same_way)]
        raise ConnectivityError(_pair(starts[bad], ends[bad]), "both of its triangles lie on the same side")
    edges = np.stack([starts[one], ends[one]], axis=1)
    return edges, np.stack([one // 3, np.where(paired, two // 3, -1)], axis=1)


def edge_keys(a: np.ndarray, b: np.ndarray, vertex_count: int) -> np.ndarray:
    """One integer per pair of vertices, the same for both senses."""
    return np.minimum(a, b).astype(np.int64) * vertex_count + np.maximum(a, b)


def find_element_edges(triangles: np.ndarray, edges: np.ndarray, edge_triangles: np.ndarray) -> np.ndarray:
    """(ne, 3) edge that runs from corner k to corner k + 1 of each triangle."""
    following = np.roll(triangles, -1, axis=1)
    found = np.full(triangles.shape, -1)
    for side, (a, b) in enumerate((edges.T, edges.T[::-1])):
        row = np.flatnonzero(edge_triangles[:, side] >= 0)
        t = edge_triangles[row, side]
        k = np.argmax((triangles[t] == a[row, None]) & (following[t] == b[row, None]), axis=1)
        found[t, k] = row
    return found


def corner_fans(triangles: np.ndarray, edges: np.ndarray, edge_triangles: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """(ne, 3) fan of each corner: corners at one vertex are in one fan if one gets there across `joined` edges.

    Args:
        joined: (nd,) bool, edges that hold their two triangles together.
    """
    corner_of = find_element_edges(triangles, edges, edge_triangles)
    row = np.flatnonzero(joined & (edge_triangles[:, 1] >= 0))
    left, right = edge_triangles[row].T
    i = 3 * left + np.argmax(corner_of[left] == row[:, None], axis=1)
    j = 3 * right + np.argmax(corner_of[right] == row[:, None], axis=1)
    # The edge runs from corner i to the next one in the left triangle, from j to the next one, backwards, in the right.
    one = np.concatenate([i, _next_corner(i)])
    two = np.concatenate([_next_corner(j), j])
    graph = coo_matrix((np.ones(len(one), dtype=bool), (one, two)), shape=(triangles.size, triangles.size))
    return connected_components(graph, directed=False)[1].reshape(-1, 3)


def face_numbers(edge_triangles: np.ndarray, joined: np.ndarray, triangle_count: int) -> np.ndarray:
    """(ne,) connected sets of triangles across `joined` edges, numbered in the order of their first triangle."""
    i, j = edge_triangles[joined & (edge_triangles[:, 1] >= 0)].T
    graph = coo_matrix((np.ones(len(i), dtype=bool), (i, j)), shape=(triangle_count, triangle_count))
    return connected_components(graph, directed=False)[1]


def sheet_labels(edges: np.ndarray, vertex_count: int) -> np.ndarray:
    """(nv,) connected part of the mesh with edges (nd, 2) that each vertex belongs to."""
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(vertex_count, vertex_count))
    return connected_components(graph, directed=False)[1]


def _next_corner(corner: np.ndarray) -> np.ndarray:
    return np.where(corner % 3 == 2, corner - 2, corner + 1)


def _pair(a: int, b: int) -> tuple[int, int]:
    return (int(a), int(b)) if a < b else (int(b), int(a))
