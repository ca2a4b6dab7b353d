"""Specht shape functions tabulated at points of the sheet."""

from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import specht
from warp_origami.kernels.precision import vec2, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh


@dataclass(frozen=True)
class ShapeTable:
    """Shape functions at n points.

    Attributes:
        elements: (n,) element of each point.
        areas: (n, 3) area coordinates of each point in its element.
        values: (n, 9) shape functions, paper (8).
        gradients: (n, 9, 2) derivatives with respect to flat x and y.
    """

    elements: np.ndarray
    areas: np.ndarray
    values: np.ndarray
    gradients: np.ndarray

    def interpolation(self, coordinates: Coordinates) -> csr_matrix:
        """(n, coordinates.count) matrix: positions of the points are this matrix times q."""
        rows = np.repeat(np.arange(len(self.elements)), 9)
        columns = coordinates.elements[self.elements].ravel()
        return csr_matrix((self.values.ravel(), (rows, columns)), shape=(len(self.elements), coordinates.count))


def flat_of(mesh: Mesh, elements: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(n, 2) flat positions (m) of points of `elements` with the shape functions `values` (n, 9), paper (8).

    The flat sheet is a state that they reproduce: r the flat position, r_x and r_y unit vectors.
    """
    values = values.reshape(-1, 3, 3)
    return np.einsum("nk,nkd->nd", values[:, :, 0], mesh.vertices[mesh.triangles[elements]]) + values[:, :, 1:].sum(1)


def tabulate(mesh: Mesh, elements: np.ndarray, areas: np.ndarray) -> ShapeTable:
    """Shape functions at area coordinates `areas` (n, 3) of `elements` (n,), evaluated on the CPU once per mesh."""
    n = len(elements)
    values = np.zeros((n, 9))
    gradients = np.zeros((n, 9, 2))
    wp.launch(
        specht.tabulate_shapes,
        dim=n,
        inputs=[
            wp.array(mesh.vertices, dtype=vec2, device="cpu"),
            wp.array(mesh.triangles, dtype=wp.int32, device="cpu"),
            wp.array(np.ascontiguousarray(elements, dtype=np.int32), device="cpu"),
            wp.array(np.ascontiguousarray(areas, dtype=float), dtype=vec3, device="cpu"),
        ],
        outputs=[
            wp.array(values, device="cpu", copy=False),
            wp.array(gradients, dtype=vec2, device="cpu", copy=False),
        ],
        device="cpu",
    )
    return ShapeTable(np.asarray(elements), np.asarray(areas, dtype=float), values, gradients)
