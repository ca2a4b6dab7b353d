"""Master surfaces on the device: cubic elements, and the sub-triangles that they are found by."""

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import facet_error
from warp_origami.kernels.closest_point import Surface
from warp_origami.kernels.penalty import Masters
from warp_origami.kernels.precision import real, vec2, vec3
from warp_origami.kernels.projection import Elements
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh
from warp_origami.model.submesh import build_submesh, sub_triangle_corners

from ..buffers import Buffer
from ..shapes import tabulate

SAMPLES = np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0], [2 / 3, 2 / 3, 2 / 3]]) / 2.0
"""Where the error of a sub-triangle is looked at: its mid-sides and centroid."""

MARGIN = 1.25
"""By which the error may be larger elsewhere in the sub-triangle: cubic terms shift the largest from the middle."""


class MasterSurfaces:
    """Cubic elements at the current state.

    Args:
        divisions: of the sub-triangles `facets`, which are those of build_submesh(mesh, divisions).
        zone: distance from the sub-triangles up to which the cubic surface counts, m.

    Attributes:
        masters: for launches.
        modules: Warp modules compiled for it.
    """

    def __init__(
        self, mesh: Mesh, coordinates: Coordinates, divisions: int, facets: Surface, zone: float, device: str
    ) -> None:
        self.modules = (facet_error.bound_facet_errors.module.name,)
        self._q = Buffer(coordinates.count, vec3, device)
        whole = build_submesh(mesh, 1)  # whose sub-triangles are the elements
        side = [1, 2, 4]
        outer = whole.outer_edges @ side + 8 * (whole.outer_corners @ side)
        elements = Elements()
        elements.vertices = wp.array(mesh.vertices, dtype=vec2, device=device)
        elements.triangles = wp.array(mesh.triangles, dtype=wp.int32, device=device)
        elements.rows = wp.array(coordinates.elements, dtype=wp.int32, device=device)
        elements.q = self._q.array
        count = len(mesh.triangles)
        around = _elements_around(mesh)
        errors, largest = (wp.zeros(count, dtype=real, device=device) for _ in range(2))
        self.masters = Masters()
        self.masters.facets = facets
        self.masters.corners = wp.array(sub_triangle_corners(divisions).reshape(-1, 3), dtype=vec3, device=device)
        self.masters.elements = elements
        self.masters.outer = wp.array(outer.astype(np.int32), device=device)
        self.masters.errors = largest
        self.masters.zone = zone
        shape_errors = wp.array(facet_errors(mesh, divisions), dtype=real, device=device)
        starts, neighbours = (wp.array(a, dtype=wp.int32, device=device) for a in (around.indptr, around.indices))
        self._launches = [
            wp.launch(kernel, dim=count, inputs=inputs, outputs=outputs, device=device, record_cmd=True)
            for kernel, inputs, outputs in (
                (facet_error.bound_facet_errors, [elements, shape_errors], [errors]),
                (facet_error.largest_around, [errors, starts, neighbours], [largest]),
            )
        ]

    def place(self, q: np.ndarray) -> None:
        """Brings the surfaces to q (n, 3)."""
        self._q.write(q)
        for command in self._launches:
            command.launch()


def facet_errors(mesh: Mesh, divisions: int) -> np.ndarray:
    """(ne, 9) largest error with which the sub-triangles interpolate each shape function of each element."""
    count, corners = len(mesh.triangles), sub_triangle_corners(divisions)
    result = np.zeros((count, 9))
    for triangle in corners:
        areas = np.concatenate([triangle, SAMPLES @ triangle])
        elements = np.repeat(np.arange(count), len(areas))
        values = tabulate(mesh, elements, np.tile(areas, (count, 1))).values.reshape(count, len(areas), 9)
        error = np.abs(values[:, 3:] - np.einsum("sc,ecm->esm", SAMPLES, values[:, :3]))
        result = np.maximum(result, error.max(axis=1))
    return MARGIN * result


def _elements_around(mesh: Mesh) -> csr_matrix:
    """(ne, ne) non-zero where two elements share a vertex."""
    count = len(mesh.triangles)
    corners = csr_matrix(
        (np.ones(3 * count), mesh.triangles.ravel(), np.arange(0, 3 * count + 1, 3)), shape=(count, len(mesh.vertices))
    )
    return csr_matrix(corners @ corners.T)
