"""Closest point projection on the cubic surface of an element, paper (28), (29).

    |x - r(P)| = min over the flat triangle,   inside: (x - r) . r_x = 0, (x - r) . r_y = 0

Gauss-Newton: the surface is replaced by its tangent plane at P, on which the flat triangle becomes a plane triangle;
the closest point of that triangle is the next P, with the step halved while the distance grows. Its limit fulfils (29),
or the one-sided conditions on the boundary. The error shrinks by distance times curvature in every iteration.
"""

import warp as wp

from .closest_point import CORNER, INSIDE, SIDE, closest_on_triangle
from .precision import mat33, real, vec2, vec3
from .specht import shape_gradient, shape_values, side_coefficients

HALVINGS = wp.constant(30)
FARTHER = wp.constant(real(1.0 + 1e-12))  # squared distance that has grown by more than round-off
FAR = wp.constant(real(1e30))  # m
SETTLED = wp.constant(real(1e-12))  # change of area coordinates at which the iteration ends


@wp.struct
class Elements:
    """Flat vertices (m), triangles, the rows of q of each element, and q."""

    vertices: wp.array(dtype=vec2)
    triangles: wp.array2d(dtype=wp.int32)
    rows: wp.array2d(dtype=wp.int32)
    q: wp.array(dtype=vec3)


@wp.struct
class Element:
    """One element: its number, flat corners (m) and side_coefficients."""

    number: int
    p1: vec2
    p2: vec2
    p3: vec2
    c: mat33


@wp.struct
class Foot:
    """Point of an element's surface: area coordinates, position (m), derivatives with respect to flat x and y."""

    areas: vec3
    r: vec3
    x: vec3
    y: vec3


@wp.func
def element_of(mesh: Elements, number: int):
    """Corners and coefficients of an element."""
    e = Element()
    e.number = number
    e.p1 = mesh.vertices[mesh.triangles[number, 0]]
    e.p2 = mesh.vertices[mesh.triangles[number, 1]]
    e.p3 = mesh.vertices[mesh.triangles[number, 2]]
    e.c = side_coefficients(e.p1, e.p2, e.p3)
    return e


@wp.func
def surface_foot(areas: vec3, e: Element, mesh: Elements):
    """r and its derivatives at area coordinates of an element."""
    foot = Foot()
    foot.areas = areas
    s = shape_values(areas, e.c)
    g = shape_gradient(areas, e.c)
    for i in range(9):
        row = mesh.q[mesh.rows[e.number, i]]
        foot.r += s[i] * row
        foot.x += g.x[i] * row
        foot.y += g.y[i] * row
    return foot


@wp.func
def on_plane(foot: Foot, step: vec2):
    """Image of a flat step under the tangent map."""
    return foot.r + step[0] * foot.x + step[1] * foot.y


@wp.func
def next_areas(x: vec3, foot: Foot, e: Element):
    """Area coordinates of the point closest to x of the element's triangle on the tangent plane at `foot`."""
    at = foot.areas[0] * e.p1 + foot.areas[1] * e.p2 + foot.areas[2] * e.p3
    areas, _feature = closest_on_triangle(
        x, on_plane(foot, e.p1 - at), on_plane(foot, e.p2 - at), on_plane(foot, e.p3 - at)
    )
    return areas


@wp.func
def step_length(foot: Foot, step: vec3, e: Element):
    """Length on the tangent plane, m, of a change of area coordinates."""
    return wp.length(on_plane(foot, step[0] * e.p1 + step[1] * e.p2 + step[2] * e.p3) - foot.r)


@wp.func
def project(x: vec3, start: vec3, e: Element, mesh: Elements, iterations: int, least: real):
    """Point of the element closest to x, from area coordinates `start`; never farther than the start.

    Ends early where the distance is sure to stay above `least`, m: all steps to come are shorter than the next one.
    """
    foot = surface_foot(start, e, mesh)
    for _k in range(iterations):
        areas = next_areas(x, foot, e)
        step = areas - foot.areas
        if wp.length(step) < SETTLED or wp.length(x - foot.r) - step_length(foot, step, e) > least:
            break
        moved = surface_foot(areas, e, mesh)
        factor = real(1.0)
        for _h in range(HALVINGS):
            if wp.length_sq(x - moved.r) <= FARTHER * wp.length_sq(x - foot.r):
                break
            factor = real(0.5) * factor
            moved = surface_foot(foot.areas + factor * step, e, mesh)
        foot = moved
    return foot


@wp.func
def feature_of(areas: vec3):
    """Where on an element a point lies: INSIDE, SIDE + m (from corner m to corner m + 1) or CORNER + m."""
    zero = real(0.0)
    feature = INSIDE
    for i in range(3):
        if areas[i] <= zero:
            feature = SIDE + (i + 1) % 3
    for i in range(3):
        if areas[(i + 1) % 3] <= zero and areas[(i + 2) % 3] <= zero:
            feature = CORNER + i
    return feature


@wp.kernel(enable_backward=False)
def project_points(
    points: wp.array(dtype=vec3),
    elements: wp.array(dtype=wp.int32),
    starts: wp.array(dtype=vec3),
    mesh: Elements,
    iterations: int,
    # out
    areas: wp.array(dtype=vec3),
    positions: wp.array(dtype=vec3),
):
    """Closest point of one element for each point, from area coordinates `starts`."""
    i = wp.tid()
    foot = project(points[i], starts[i], element_of(mesh, elements[i]), mesh, iterations, FAR)
    areas[i] = foot.areas
    positions[i] = foot.r
