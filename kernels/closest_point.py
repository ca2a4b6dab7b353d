"""Closest point of a plane triangle, the projection (28), (29) of the paper on one sub-triangle.

    c(w) = w_1 a + w_2 b + w_3 c,   |x - c(w)| = min,   w >= 0, sum w = 1

The region of x is found from the signs of the edge coordinates (C. Ericson, Real-Time Collision Detection, 5.1.5).
"""

import warp as wp

from .precision import real, vec3

INSIDE = wp.constant(0)  # the closest point lies inside the triangle
SIDE = wp.constant(1)  # SIDE + m: on side m, from corner m to corner m + 1
CORNER = wp.constant(4)  # CORNER + m: at corner m


@wp.struct
class Surface:
    """Sub-triangulated surface.

    points: positions, m; triangles: points of each sub-triangle; outer: bits 0-2 side m, bits 3-5 corner m of the
    sub-triangle lies on the outer boundary of its layer.
    """

    points: wp.array(dtype=vec3)
    triangles: wp.array2d(dtype=wp.int32)
    outer: wp.array(dtype=wp.int32)


@wp.func
def closest_on_triangle(x: vec3, a: vec3, b: vec3, c: vec3):
    """Area coordinates of the point of triangle abc closest to x, and where it lies: INSIDE, SIDE + m or CORNER + m."""
    zero = real(0.0)
    one = real(1.0)
    ab = b - a
    ac = c - a
    ax = x - a
    d1 = wp.dot(ab, ax)
    d2 = wp.dot(ac, ax)
    if d1 <= zero and d2 <= zero:
        return vec3(one, zero, zero), CORNER
    bx = x - b
    d3 = wp.dot(ab, bx)
    d4 = wp.dot(ac, bx)
    if d3 >= zero and d4 <= d3:
        return vec3(zero, one, zero), CORNER + 1
    vc = d1 * d4 - d3 * d2
    if vc <= zero and d1 >= zero and d3 <= zero:
        t = d1 / (d1 - d3)
        return vec3(one - t, t, zero), SIDE
    cx = x - c
    d5 = wp.dot(ab, cx)
    d6 = wp.dot(ac, cx)
    if d6 >= zero and d5 <= d6:
        return vec3(zero, zero, one), CORNER + 2
    vb = d5 * d2 - d1 * d6
    if vb <= zero and d2 >= zero and d6 <= zero:
        t = d2 / (d2 - d6)
        return vec3(one - t, zero, t), SIDE + 2
    va = d3 * d6 - d5 * d4
    if va <= zero and d4 >= d3 and d5 >= d6:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return vec3(zero, one - t, t), SIDE + 1
    total = va + vb + vc
    v = vb / total
    w = vc / total
    return vec3(one - v - w, v, w), INSIDE


@wp.func
def point_of(surface: Surface, triangle: int, weights: vec3):
    """Position at area coordinates `weights` of a sub-triangle."""
    return (
        weights[0] * surface.points[surface.triangles[triangle, 0]]
        + weights[1] * surface.points[surface.triangles[triangle, 1]]
        + weights[2] * surface.points[surface.triangles[triangle, 2]]
    )


@wp.func
def closest_of(surface: Surface, triangle: int, x: vec3):
    """closest_on_triangle for a sub-triangle of `surface`."""
    return closest_on_triangle(
        x,
        surface.points[surface.triangles[triangle, 0]],
        surface.points[surface.triangles[triangle, 1]],
        surface.points[surface.triangles[triangle, 2]],
    )


@wp.func
def box_distance_squared(x: vec3, a: vec3, b: vec3, c: vec3):
    """Squared distance of x from the axis-parallel box around triangle abc: a cheap bound from below, m^2."""
    away = wp.max(wp.max(wp.min(wp.min(a, b), c) - x, x - wp.max(wp.max(a, b), c)), vec3())
    return wp.dot(away, away)


@wp.func
def normal_of(surface: Surface, triangle: int):
    """Unit normal of a sub-triangle, towards +z of the flat sheet when unfolded."""
    a = surface.points[surface.triangles[triangle, 0]]
    return wp.normalize(
        wp.cross(
            surface.points[surface.triangles[triangle, 1]] - a,
            surface.points[surface.triangles[triangle, 2]] - a,
        )
    )


@wp.func
def corner_angle(surface: Surface, triangle: int, corner: int):
    """Angle of a sub-triangle at one of its corners, rad."""
    x = surface.points[surface.triangles[triangle, corner]]
    u = wp.normalize(surface.points[surface.triangles[triangle, (corner + 1) % 3]] - x)
    v = wp.normalize(surface.points[surface.triangles[triangle, (corner + 2) % 3]] - x)
    return wp.acos(wp.clamp(wp.dot(u, v), real(-1.0), real(1.0)))


@wp.func
def is_outer(outer: int, feature: int):
    """Whether the closest point lies on the outer boundary of the layer."""
    if feature == INSIDE:
        return False
    return ((outer >> (feature - SIDE)) & 1) == 1
