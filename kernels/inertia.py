"""Constant mass block of one element, paper (19).

    M_e = rho h A sum_p w_p S(p)' S(p),   the same for x, y and z

The shape functions are quartic (P_i holds L_i L_j L_k times a linear factor), their products of degree 8.
"""

import warp as wp

from .precision import real, vec2, vec3
from .specht import shape_values, side_coefficients


@wp.kernel(enable_backward=False, module="warp_origami.kernels.element")
def element_mass(
    vertices: wp.array(dtype=vec2),
    triangles: wp.array2d(dtype=wp.int32),
    areas: wp.array(dtype=vec3),
    weights: wp.array(dtype=real),
    surface_density: real,
    # out
    mass: wp.array3d(dtype=real),
):
    """Scalar 9x9 mass block (kg, times m per gradient), one thread per element; areas and weights are the rule's."""
    e = wp.tid()
    c = side_coefficients(vertices[triangles[e, 0]], vertices[triangles[e, 1]], vertices[triangles[e, 2]])
    area = real(0.5) * (c[0, 0] * c[1, 1] - c[1, 0] * c[0, 1])
    for i in range(9):
        for j in range(9):
            mass[e, i, j] = real(0.0)
    for p in range(areas.shape[0]):
        s = shape_values(areas[p], c)
        factor = surface_density * area * weights[p]
        for i in range(9):
            for j in range(9):
                mass[e, i, j] = mass[e, i, j] + factor * (s[i] * s[j])
