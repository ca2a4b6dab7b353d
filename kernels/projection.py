"""Closest point projection on the cubic surface of an element, paper (28), (29).

    |x - r(P)| = min over the flat triangle,   inside: (x - r) . r_x = 0, (x - r) . r_y = 0

Gauss-Newton: the surface is replaced by its tangent plane at P, on which the flat triangle becomes a plane triangle;
the closest point of that triangle is the next P, with the step halved until the distance falls. Its limit fulfils (29),
or the one-sided conditions on the boundary. The error shrinks by distance times curvature in every iteration.
"""

import warp as wp

from .closest_point import closest_on_triangle
from .precision import mat33, real, vec2, vec3
from .specht import shape_gradient, shape_values, side_coefficients

HALVINGS = wp.constant(30)


@wp.struct
class Tangent:
    """Point of the surface, m, and its derivatives with respect to flat x and y."""

    r: vec3
    x: vec3
    y: vec3


@wp.func
def surface_point(areas: vec3, c: mat33, rows: wp.array2d(dtype=wp.int32), element: int, q: wp.array(dtype=vec3)):
    """r at area coordinates of an element."""
    s = shape_values(areas, c)
    r = vec3()
    for i in range(9):
        r += s[i] * q[rows[element, i]]
    return r


@wp.func
def surface_tangent(areas: vec3, c: mat33, rows: wp.array2d(dtype=wp.int32), element: int, q: wp.array(dtype=vec3)):
    """r and its derivatives at area coordinates of an element."""
    t = Tangent()
    t.r = surface_point(areas, c, rows, element, q)
    g = shape_gradient(areas, c)
    for i in range(9):
        t.x += g.x[i] * q[rows[element, i]]
        t.y += g.y[i] * q[rows[element, i]]
    return t


@wp.func
def on_plane(t: Tangent, step: vec2):
    """Image of a flat step under the tangent map."""
    return t.r + step[0] * t.x + step[1] * t.y


@wp.struct
class Elements:
    """Flat vertices (m), triangles, and the rows of q of each element."""

    vertices: wp.array(dtype=vec2)
    triangles: wp.array2d(dtype=wp.int32)
    rows: wp.array2d(dtype=wp.int32)


@wp.kernel(enable_backward=False)
def project_points(
    points: wp.array(dtype=vec3),
    elements: wp.array(dtype=wp.int32),
    starts: wp.array(dtype=vec3),
    q: wp.array(dtype=vec3),
    mesh: Elements,
    iterations: int,
    # out
    areas: wp.array(dtype=vec3),
    positions: wp.array(dtype=vec3),
):
    """Closest point of one element for each point, from area coordinates `starts`."""
    i = wp.tid()
    x = points[i]
    e = elements[i]
    p1 = mesh.vertices[mesh.triangles[e, 0]]
    p2 = mesh.vertices[mesh.triangles[e, 1]]
    p3 = mesh.vertices[mesh.triangles[e, 2]]
    c = side_coefficients(p1, p2, p3)
    here = starts[i]
    t = surface_tangent(here, c, mesh.rows, e, q)
    for _k in range(iterations):
        at = here[0] * p1 + here[1] * p2 + here[2] * p3
        there, _feature = closest_on_triangle(x, on_plane(t, p1 - at), on_plane(t, p2 - at), on_plane(t, p3 - at))
        step = there - here
        factor = real(1.0)
        moved = surface_tangent(here + step, c, mesh.rows, e, q)
        for _h in range(HALVINGS):
            if wp.length_sq(x - moved.r) > wp.length_sq(x - t.r):
                factor = real(0.5) * factor
                moved = surface_tangent(here + factor * step, c, mesh.rows, e, q)
        here = here + factor * step
        t = moved
    areas[i] = here
    positions[i] = t.r
