"""Constant mass matrix, paper (19), (53)."""

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels.inertia import element_mass
from warp_origami.kernels.precision import vec2, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

from .quadrature import rule

EXACT_DEGREE = 8
"""Degree of a product of two shape functions."""


def mass_matrix(mesh: Mesh, coordinates: Coordinates, density: float, thickness: float) -> csr_matrix:
    """Scalar mass matrix (n, n), to be applied to x, y and z alike, integrated exactly.

    Rows of positions are in kg, mixed ones in kg m, rows of gradients in kg m^2. `density` in kg/m^3, `thickness` in m.
    Evaluated on the CPU once per run.
    """
    areas, weights = rule(EXACT_DEGREE)
    count = len(mesh.triangles)
    blocks = np.empty((count, 9, 9))
    wp.launch(
        element_mass,
        dim=count,
        inputs=[
            wp.array(mesh.vertices, dtype=vec2, device="cpu"),
            wp.array(mesh.triangles, dtype=wp.int32, device="cpu"),
            wp.array(areas, dtype=vec3, device="cpu"),
            wp.array(weights, device="cpu"),
            density * thickness,
        ],
        outputs=[wp.array(blocks, device="cpu", copy=False)],
        device="cpu",
    )
    return coordinates.assemble(blocks)
