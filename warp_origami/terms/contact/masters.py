"""Master surfaces on the device: cubic elements, and the sub-triangles that they are found by."""

import numpy as np
import warp as wp

from warp_origami.kernels.closest_point import Surface
from warp_origami.kernels.penalty import Masters
from warp_origami.kernels.precision import vec2, vec3
from warp_origami.kernels.projection import Elements
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh
from warp_origami.model.submesh import build_submesh, sub_triangle_corners


def build_masters(
    mesh: Mesh, coordinates: Coordinates, divisions: int, facets: Surface, q: wp.array, zone: float, device: str
) -> Masters:
    """Masters whose `facets` are the sub-triangles of build_submesh(mesh, divisions), at the state in the array `q`."""
    whole = build_submesh(mesh, 1)  # whose sub-triangles are the elements
    side = [1, 2, 4]
    outer = whole.outer_edges @ side + 8 * (whole.outer_corners @ side)
    elements = Elements()
    elements.vertices = wp.array(mesh.vertices, dtype=vec2, device=device)
    elements.triangles = wp.array(mesh.triangles, dtype=wp.int32, device=device)
    elements.rows = wp.array(coordinates.elements, dtype=wp.int32, device=device)
    elements.q = q
    masters = Masters()
    masters.facets = facets
    masters.corners = wp.array(sub_triangle_corners(divisions).reshape(-1, 3), dtype=vec3, device=device)
    masters.elements = elements
    masters.outer = wp.array(outer.astype(np.int32), device=device)
    masters.zone = zone
    return masters
