"""Edges of the sheet as cubic curves, and the closest points of two of them.

    r(s) = sum_a B_a(s) c_a,  s in [0, 1]        B_a: Bernstein polynomials, c_a: control points
    |r_2(t) - r_1(s)| = min,  inside: delta . r_1' = 0, delta . r_2' = 0    with delta = r_2(t) - r_1(s)

Newton's method where it stays inside and the distance is convex; else the curves are replaced by their tangents, whose
closest points (C. Ericson, Real-Time Collision Detection, 5.1.9) are the next s, t. Both are halved while the distance
grows, so that the limit is a minimum near the start.
"""

import warp as wp

from .precision import real, vec2, vec3

ITERATIONS = wp.constant(40)  # of the projection; 3 or 4 settle it where edges cross
HALVINGS = wp.constant(30)
FARTHER = wp.constant(real(1.0 + 1e-12))  # squared distance that has grown by more than round-off
SETTLED = wp.constant(real(1e-10))  # last step of the parameters: Newton's method squares what is left
CONVEX = wp.constant(real(1e-6))  # least relative determinant at which Newton's step is taken
PARALLEL = wp.constant(real(1e-14))  # squared sine below which straight segments count as parallel


@wp.struct
class CurvePoint:
    """Position r (m) and its derivatives with respect to the parameter."""

    r: vec3
    d1: vec3
    d2: vec3
    d3: vec3


@wp.func
def curve_point(controls: wp.array(dtype=vec3), curve: int, s: real):
    """Point of a curve whose control points are controls[4 curve : 4 curve + 4]."""
    c0 = controls[4 * curve]
    c1 = controls[4 * curve + 1]
    c2 = controls[4 * curve + 2]
    c3 = controls[4 * curve + 3]
    a1 = real(3.0) * (c1 - c0)
    a2 = real(3.0) * ((c2 - c1) - (c1 - c0))
    a3 = (c3 - c0) - real(3.0) * (c2 - c1)
    p = CurvePoint()
    p.r = c0 + s * (a1 + s * (a2 + s * a3))
    p.d1 = a1 + s * (real(2.0) * a2 + real(3.0) * s * a3)
    p.d2 = real(2.0) * a2 + real(6.0) * s * a3
    p.d3 = real(6.0) * a3
    return p


@wp.func
def unit_clamp(s: real):
    """s limited to [0, 1]."""
    return wp.clamp(s, real(0.0), real(1.0))


@wp.func
def closest_on_segments(a: vec3, u: vec3, b: vec3, v: vec3, otherwise: real):
    """s, t in [0, 1] of the closest points a + s u and b + t v; s is `otherwise` where segments are parallel."""
    one = real(1.0)
    w = a - b
    uu = wp.dot(u, u)
    vv = wp.dot(v, v)
    uv = wp.dot(u, v)
    uw = wp.dot(u, w)
    vw = wp.dot(v, w)
    cross = wp.length_sq(wp.cross(u, v))
    s = otherwise
    if cross > PARALLEL * uu * vv:
        s = unit_clamp((uv * vw - uw * vv) / cross)
    t = (uv * s + vw) / vv
    if t < real(0.0):
        return vec2(unit_clamp(-uw / uu), real(0.0))
    if t > one:
        return vec2(unit_clamp((uv - uw) / uu), one)
    return vec2(s, t)


@wp.func
def newton_parameters(first: CurvePoint, second: CurvePoint, at: vec2):
    """Next s, t by Newton's method; negative where the distance is not convex there."""
    delta = second.r - first.r
    aa = wp.dot(first.d1, first.d1)
    bb = wp.dot(second.d1, second.d1)
    h11 = aa - wp.dot(delta, first.d2)
    h22 = bb + wp.dot(delta, second.d2)
    h12 = -wp.dot(first.d1, second.d1)
    det = h11 * h22 - h12 * h12
    if h11 <= real(0.0) or det <= CONVEX * aa * bb:
        return vec2(real(-1.0), real(-1.0))
    f1 = -wp.dot(delta, first.d1)
    f2 = wp.dot(delta, second.d1)
    return at - vec2(h22 * f1 - h12 * f2, h11 * f2 - h12 * f1) / det


@wp.func
def next_parameters(first: CurvePoint, second: CurvePoint, at: vec2):
    """Where the next step of the projection goes, in [0, 1] x [0, 1]."""
    to = newton_parameters(first, second, at)
    if wp.min(to[0], to[1]) >= real(0.0) and wp.max(to[0], to[1]) <= real(1.0):
        return to
    return closest_on_segments(first.r - at[0] * first.d1, first.d1, second.r - at[1] * second.d1, second.d1, at[0])


@wp.func
def closest_on_curves(controls: wp.array(dtype=vec3), first: int, second: int, start: vec2):
    """Parameters s, t of closest points of two curves, found from `start`; never farther apart than the start."""
    at = start
    for _k in range(ITERATIONS):
        p = curve_point(controls, first, at[0])
        q = curve_point(controls, second, at[1])
        square = FARTHER * wp.length_sq(q.r - p.r)
        to = next_parameters(p, q, at)
        size = wp.length(to - at)
        for _h in range(HALVINGS):
            if wp.length_sq(curve_point(controls, second, to[1]).r - curve_point(controls, first, to[0]).r) <= square:
                break
            to = real(0.5) * (at + to)
        at = to
        if size < SETTLED:
            break
    return at
