"""How far the cubic surface of an element lies from its plane sub-triangles.

    r(P) - facet(P) = sum_i e_i2 (r_ix - A_x) + e_i3 (r_iy - A_y)

e = S - (S interpolated in the sub-triangle), A the gradient of the plane through the element's corners, which both
reproduce. Contact projects on the cubic surface only where this can decide on a force.
"""

import warp as wp

from .precision import real, vec3
from .projection import Elements, element_of


@wp.kernel(enable_backward=False)
def find_facet_errors(
    mesh: Elements,
    samples: wp.array3d(dtype=real),
    margin: real,
    begin: int,
    # out
    errors: wp.array(dtype=real),
):
    """Largest error (m) of every element, times `margin`; samples[element, k] is e at its point k."""
    number = begin + wp.tid()
    e = element_of(mesh, number)
    twice_area = e.c[0, 0] * e.c[1, 1] - e.c[1, 0] * e.c[0, 1]
    r1 = mesh.q[mesh.rows[number, 0]]
    r2 = mesh.q[mesh.rows[number, 3]]
    r3 = mesh.q[mesh.rows[number, 6]]
    ax = (e.c[0, 0] * r1 + e.c[1, 0] * r2 + e.c[2, 0] * r3) / twice_area
    ay = (e.c[0, 1] * r1 + e.c[1, 1] * r2 + e.c[2, 1] * r3) / twice_area
    largest = real(0.0)
    for k in range(samples.shape[1]):
        error = vec3()
        for i in range(3):
            error += samples[number, k, 3 * i + 1] * (mesh.q[mesh.rows[number, 3 * i + 1]] - ax)
            error += samples[number, k, 3 * i + 2] * (mesh.q[mesh.rows[number, 3 * i + 2]] - ay)
        largest = wp.max(largest, wp.length_sq(error))
    errors[number] = margin * wp.sqrt(largest)


@wp.kernel(enable_backward=False)
def largest_around(
    errors: wp.array(dtype=real),
    starts: wp.array(dtype=wp.int32),
    around: wp.array(dtype=wp.int32),
    begin: int,
    # out
    largest: wp.array(dtype=real),
):
    """Largest error, m, of the elements around[starts[i] : starts[i + 1]] that share a vertex with element i."""
    i = begin + wp.tid()
    bound = real(0.0)
    for k in range(starts[i], starts[i + 1]):
        bound = wp.max(bound, errors[around[k]])
    largest[i] = bound
