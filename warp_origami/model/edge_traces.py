"""The sheet along mesh edges: the cubic Hermite curve of the two end nodes.

With s from 0 to 1 along the edge, r(s) = sum_a H_a(s) p_a and p = P q = [r, dr/ds, r, dr/ds] at both ends: the slope
along the edge is a combination of r_x and r_y there with the flat components of the edge.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from .coordinates import Coordinates
from .mesh import Mesh

HERMITE = tuple(Polynomial(c) for c in ([1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]))
"""H_a, a = 0 .. 3."""


@dataclass(frozen=True)
class EdgeTraces:
    """Traces of k edges.

    Attributes:
        rows: (k, 6) rows of q: r, r_x, r_y of the first end, then of the second.
        matrices: (k, 4, 6) P of each edge, from these rows to p; m where it multiplies gradients.
        lengths: (k,) flat lengths, m.
    """

    rows: np.ndarray
    matrices: np.ndarray
    lengths: np.ndarray


def edge_traces(mesh: Mesh, coordinates: Coordinates, edges: np.ndarray, sides: np.ndarray) -> EdgeTraces:
    """Traces of `edges` (k,), each in and counter-clockwise around its element on side `sides` (k,), 0 or 1."""
    elements = mesh.edge_triangles[edges, sides]
    first = np.argmax(mesh.element_edges[elements] == edges[:, None], axis=1)
    corners = np.stack([first, (first + 1) % 3], axis=1)
    nodes = coordinates.elements[elements].reshape(-1, 3, 3).astype(np.int64)
    rows = np.take_along_axis(nodes, corners[:, :, None], axis=1).reshape(-1, 6)
    ends = mesh.vertices[np.take_along_axis(mesh.triangles[elements], corners, axis=1)]
    along = ends[:, 1] - ends[:, 0]
    matrices = np.zeros((len(edges), 4, 6))
    for end in (0, 1):
        matrices[:, 2 * end, 3 * end] = 1.0
        matrices[:, 2 * end + 1, 3 * end + 1 : 3 * end + 3] = along
    return EdgeTraces(rows, matrices, np.linalg.norm(along, axis=1))
