"""Master surfaces on the device: cubic elements, and the sub-triangles that they are found by."""

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import facet_error
from warp_origami.kernels.closest_point import Surface
from warp_origami.kernels.point_gap import Masters
from warp_origami.kernels.precision import real, vec2, vec3
from warp_origami.kernels.projection import Elements
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh
from warp_origami.model.submesh import build_submesh, sub_triangle_corners

from ..buffers import Buffer
from ..launches import Launch
from ..shapes import tabulate

SAMPLES = np.array([(i, j, 4 - i - j) for i in range(4) for j in range(4) if 1 <= i + j <= 4]) / 4.0
"""Where the error of a sub-triangle is looked at, area coordinates: multiples of 1/4 but for the corners."""

GRAIN = 100
"""Elements that are worth a thread: about a microsecond each."""

MARGIN = 1.25
"""By which the error may be larger elsewhere in the sub-triangle."""


class MasterSurfaces:
    """Cubic elements at the current state.

    Args:
        divisions: of the sub-triangles `facets`, which are those of build_submesh(mesh, divisions).
        zone: distance from the sub-triangles up to which the cubic surface counts, m.

    Attributes:
        masters: for launches.
        errors: (ne,) buffer of how far the cubic surface may lie from the sub-triangles in an element and around it, m.
        modules: Warp modules compiled for it.
    """

    def __init__(
        self, mesh: Mesh, coordinates: Coordinates, divisions: int, facets: Surface, zone: float, device: str
    ) -> None:
        self.modules = (facet_error.find_facet_errors.module.name,)
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
        errors = wp.zeros(count, dtype=real, device=device)
        self.errors = Buffer(count, real, device)
        self.masters = Masters()
        self.masters.facets = facets
        self.masters.corners = wp.array(sub_triangle_corners(divisions).reshape(-1, 3), dtype=vec3, device=device)
        self.masters.elements = elements
        self.masters.outer = wp.array(outer.astype(np.int32), device=device)
        self.masters.errors = self.errors.array
        self.masters.zone = zone
        shape_errors = wp.array(facet_errors(mesh, divisions), dtype=real, device=device)
        starts, neighbours = (wp.array(a, dtype=wp.int32, device=device) for a in (around.indptr, around.indices))
        self._launches = [
            Launch(kernel, count, inputs, outputs, device, GRAIN)
            for kernel, inputs, outputs in (
                (facet_error.find_facet_errors, [elements, shape_errors, real(MARGIN)], [errors]),
                (facet_error.largest_around, [errors, starts, neighbours], [self.errors.array]),
            )
        ]

    def place(self, q: np.ndarray) -> None:
        """Brings the surfaces to q (n, 3)."""
        self._q.write(q)
        for command in self._launches:
            command.launch()


def facet_errors(mesh: Mesh, divisions: int) -> np.ndarray:
    """(ne, m, 9) error of each element's shape functions, interpolated in its sub-triangles, at SAMPLES of these, each
    point once."""
    count = len(mesh.triangles)
    corners = sub_triangle_corners(divisions)
    places = np.round(4.0 * divisions * (SAMPLES @ corners)).reshape(-1, 3)
    once = np.unique(places, axis=0, return_index=True)[1]
    result = []
    for triangle in corners:
        areas = np.concatenate([triangle, SAMPLES @ triangle])
        elements = np.repeat(np.arange(count), len(areas))
        values = tabulate(mesh, elements, np.tile(areas, (count, 1))).values.reshape(count, len(areas), 9)
        result.append(values[:, 3:] - np.einsum("sc,ecm->esm", SAMPLES, values[:, :3]))
    return np.concatenate(result, axis=1)[:, once]


def _elements_around(mesh: Mesh) -> csr_matrix:
    """(ne, ne) non-zero where two elements share a vertex."""
    count = len(mesh.triangles)
    corners = csr_matrix(
        (np.ones(3 * count), mesh.triangles.ravel(), np.arange(0, 3 * count + 1, 3)), shape=(count, len(mesh.vertices))
    )
    return csr_matrix(corners @ corners.T)
