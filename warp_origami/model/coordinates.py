"""Generalized coordinates: one position per vertex, one pair of gradients per vertex and face sector.

The vector q is an (n, 3) array; each row is a 3-vector attached to one scalar shape function: r of a vertex (m) or
r_x, r_y of a sector (1). Elements of one sector share the gradients, which is (47) and (50) by construction; the fold
condition (48) between sectors is left to the constraints. Source: paper (6), (47)-(52).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from .connectivity import corner_fans
from .mesh import SMOOTH, Mesh


@dataclass(frozen=True)
class Coordinates:
    """Numbering of the generalized coordinates.

    Coordinates of one vertex are contiguous: r, then r_x, r_y of each of its sectors.

    Attributes:
        count: n, rows of q.
        bodies: of these, rows of bodies fastened to the sheet, behind its own.
        positions: (nv,) row of r of each vertex; -1 for a vertex without elements.
        sector_vertices: (ns,) vertex of each sector.
        sector_gradients: (ns,) row of r_x of each sector; r_y is the next row.
        element_sectors: (ne, 3) sector of each element at each of its vertices.
        elements: (ne, 9) int32 rows [r_1, r_1x, r_1y, r_2, ...] of each element, paper (6).
    """

    count: int
    positions: np.ndarray
    sector_vertices: np.ndarray
    sector_gradients: np.ndarray
    element_sectors: np.ndarray
    elements: np.ndarray
    bodies: int = 0

    @property
    def sheet_count(self) -> int:
        """Rows of q of the sheet."""
        return self.count - self.bodies

    def with_bodies(self, rows: int) -> "Coordinates":
        """The same with so many rows behind those of the sheet."""
        return replace(self, count=self.sheet_count + rows, bodies=rows)

    def assemble(self, blocks: np.ndarray) -> csr_matrix:
        """(count, count) sum of element matrices (ne, 9, 9) that act on x, y, z alike."""
        rows, columns = np.repeat(self.elements, 9, axis=1), np.tile(self.elements, (1, 9))
        return csr_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(self.count, self.count))


def number_coordinates(mesh: Mesh) -> Coordinates:
    """Numbers r of every vertex and r_x, r_y of every face sector around it; a linear element is a sector alone."""
    ne, nv = len(mesh.triangles), len(mesh.vertices)
    joined = (mesh.edge_kinds == SMOOTH) & (not mesh.linear)
    labels = corner_fans(mesh.triangles, mesh.edges, mesh.edge_triangles, joined).ravel()

    vertex_of_corner = mesh.triangles.ravel()
    _, first, sector = np.unique(labels, return_index=True, return_inverse=True)
    order = np.argsort(vertex_of_corner[first], kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    element_sectors = rank[sector].reshape(ne, 3)
    sector_vertices = vertex_of_corner[first][order]

    sectors_per_vertex = np.bincount(sector_vertices, minlength=nv)
    rows_per_vertex = np.where(sectors_per_vertex > 0, 1 + 2 * sectors_per_vertex, 0)
    start = np.concatenate([[0], np.cumsum(rows_per_vertex)])
    positions = np.where(sectors_per_vertex > 0, start[:-1], -1)
    first_sector = np.concatenate([[0], np.cumsum(sectors_per_vertex)])[:-1]
    local = np.arange(len(sector_vertices)) - first_sector[sector_vertices]
    gradients = start[sector_vertices] + 1 + 2 * local

    elements = np.empty((ne, 3, 3), dtype=np.int32)
    elements[:, :, 0] = positions[mesh.triangles]
    elements[:, :, 1] = gradients[element_sectors]
    elements[:, :, 2] = gradients[element_sectors] + 1
    return Coordinates(
        count=int(start[-1]),
        positions=positions,
        sector_vertices=sector_vertices,
        sector_gradients=gradients,
        element_sectors=element_sectors,
        elements=elements.reshape(ne, 9),
    )


def affine_coordinates(mesh: Mesh, coordinates: Coordinates, points: np.ndarray) -> np.ndarray:
    """q of the sheet whose vertices are at `points` (nv, 3) and whose elements are the affine images of the flat ones.

    Where the elements of a sector have different affine maps (a face that is not plane), the gradient is their mean
    weighted by area.
    """
    flat = mesh.vertices[mesh.triangles]
    edges_flat = np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=2)
    folded = points[mesh.triangles]
    edges_folded = np.stack([folded[:, 1] - folded[:, 0], folded[:, 2] - folded[:, 0]], axis=2)
    gradient = edges_folded @ np.linalg.inv(edges_flat)  # (ne, 3, 2): columns r_x, r_y

    total = np.zeros((len(coordinates.sector_vertices), 3, 2))
    weight = np.zeros(len(coordinates.sector_vertices))
    for k in range(3):
        np.add.at(total, coordinates.element_sectors[:, k], mesh.areas[:, None, None] * gradient)
        np.add.at(weight, coordinates.element_sectors[:, k], mesh.areas)
    mean = total / weight[:, None, None]

    q = np.zeros((coordinates.count, 3))
    used = coordinates.positions >= 0
    q[coordinates.positions[used]] = points[used]
    q[coordinates.sector_gradients] = mean[:, :, 0]
    q[coordinates.sector_gradients + 1] = mean[:, :, 1]
    return q
