"""Whether two features of moving triangles touch: conservative advancement along separating directions.

    x(t) = x_0 + t (x_1 - x_0),  0 <= t <= 1;      d_k(t) = a_i(t) - b_j(t) for all corners i of A and j of B
    n . d_k > delta |n|  for all k, at t and at t'   =>   A and B stay farther apart than delta from t to t'

because n . d_k is linear in time and the hull of all d_k holds every difference of points of A and B. Whatever n is, it
is a proof; round-off in finding it cannot make it wrong. Of the directions tried at t, one is along the shortest
connection, so that each advance is at least distance over relative speed, the one of additive continuous collision
detection (M. Li, D. Kaufman, C. Jiang 2021, Codimensional incremental potential contact); that it looks at the speed
along n only lets layers slide past each other closely in one advance (B. Mirtich 1996, conservative advancement). Where
the features turn, a direction n(t) that turns linearly from |n| = 1 to |n'| = 1 gets farther: n . d_k is a parabola,
which stays above delta if its three control values do,

    n . d_k(t),   (n . d_k(t') + n' . d_k(t)) / 2,   n' . d_k(t')   > delta   for all k.

Where no direction advances, or after too many advances, the features count as touching.
"""

import warp as wp

from .precision import real, vec3

VERTEX_TRIANGLE = wp.constant(0)
EDGE_EDGE = wp.constant(1)
ADVANCES = wp.constant(400)  # some tens are enough to pass at 1e-9 of the motion
FREE = wp.constant(real(2.0))  # a time after the end


@wp.struct
class Features:
    """Points of the sub-triangles and of their edges, and the group of each point: points of one group are one place.

    triangles: (nt, 3); edges: (nd, 2); groups: (np,).
    """

    triangles: wp.array2d(dtype=wp.int32)
    edges: wp.array2d(dtype=wp.int32)
    groups: wp.array(dtype=wp.int32)


@wp.struct
class Differences:
    """d_k between the corners of two features, m.

    Vertex x and triangle abc: x - a, x - b, x - c, x - c. Edges ab and cd: a - c, a - d, b - c, b - d.
    """

    d0: vec3
    d1: vec3
    d2: vec3
    d3: vec3


@wp.func
def differences_of(kind: int, first: int, second: int, features: Features, x: wp.array(dtype=vec3)):
    """Differences between vertex `first` and triangle `second`, or between two edges."""
    d = Differences()
    if kind == VERTEX_TRIANGLE:
        v = x[first]
        d.d0 = v - x[features.triangles[second, 0]]
        d.d1 = v - x[features.triangles[second, 1]]
        d.d2 = v - x[features.triangles[second, 2]]
        d.d3 = d.d2
    else:
        a = x[features.edges[first, 0]]
        b = x[features.edges[first, 1]]
        c = x[features.edges[second, 0]]
        e = x[features.edges[second, 1]]
        d.d0 = a - c
        d.d1 = a - e
        d.d2 = b - c
        d.d3 = b - e
    return d


@wp.func
def between(start: Differences, end: Differences, t: real):
    """Differences at time t."""
    d = Differences()
    d.d0 = start.d0 + t * (end.d0 - start.d0)
    d.d1 = start.d1 + t * (end.d1 - start.d1)
    d.d2 = start.d2 + t * (end.d2 - start.d2)
    d.d3 = start.d3 + t * (end.d3 - start.d3)
    return d


@wp.func
def towards(n: vec3, d: vec3):
    """n or -n, whichever points along d."""
    if wp.dot(n, d) < real(0.0):
        return -n
    return n


@wp.func
def from_line(d: vec3, u: vec3):
    """Part of d across u, times u^2, without the cancellation that subtracting the part along u would bring."""
    return wp.cross(u, wp.cross(d, u))


@wp.func
def vertex_triangle_direction(number: int, d: Differences):
    """Normal of the triangle, perpendicular from each side, connection to each corner."""
    n = d.d2
    if number == 0:
        n = towards(wp.cross(d.d0 - d.d1, d.d0 - d.d2), d.d0)
    elif number == 1:
        n = from_line(d.d0, d.d0 - d.d1)
    elif number == 2:
        n = from_line(d.d1, d.d1 - d.d2)
    elif number == 3:
        n = from_line(d.d2, d.d2 - d.d0)
    elif number == 4:
        n = d.d0
    elif number == 5:
        n = d.d1
    return n


@wp.func
def edge_edge_direction(number: int, d: Differences):
    """Common perpendicular, perpendicular from each end to the other edge, connection of each two ends."""
    u = d.d2 - d.d0  # along the first edge
    v = d.d0 - d.d1  # along the second
    n = d.d3
    if number == 0:
        n = towards(wp.cross(u, v), d.d0)
    elif number == 1:
        n = from_line(d.d0, v)
    elif number == 2:
        n = from_line(d.d3, v)
    elif number == 3:
        n = from_line(d.d0, u)
    elif number == 4:
        n = from_line(d.d3, u)
    elif number == 5:
        n = d.d0
    elif number == 6:
        n = d.d1
    elif number == 7:
        n = d.d2
    return n


@wp.func
def direction_count(kind: int):
    """How many directions may be the one along the shortest connection."""
    if kind == VERTEX_TRIANGLE:
        return 7
    return 9


@wp.func
def direction_of(kind: int, number: int, d: Differences):
    """Unit direction, or zero where there is none: for one number it is the one along the shortest connection."""
    if kind == VERTEX_TRIANGLE:
        return wp.normalize(vertex_triangle_direction(number, d))
    return wp.normalize(edge_edge_direction(number, d))


@wp.func
def gap_along(n: vec3, d: Differences):
    """Gap between the features along a unit direction, m: a lower bound of their distance."""
    return wp.min(wp.min(wp.dot(n, d.d0), wp.dot(n, d.d1)), wp.min(wp.dot(n, d.d2), wp.dot(n, d.d3)))


@wp.func
def root_after(t: real, start: real, end: real):
    """Until when start + t (end - start) stays positive: zero or less where it is not so at t, FREE where always."""
    if start + t * (end - start) <= real(0.0):
        return real(0.0)
    if end > real(0.0):
        return FREE
    return start / (start - end)


@wp.func
def apart_until(n: vec3, start: Differences, end: Differences, t: real, delta: real):
    """Until when n separates the features by more than delta, beginning at t; zero where it does not at t."""
    t0 = root_after(t, wp.dot(n, start.d0) - delta, wp.dot(n, end.d0) - delta)
    t1 = root_after(t, wp.dot(n, start.d1) - delta, wp.dot(n, end.d1) - delta)
    t2 = root_after(t, wp.dot(n, start.d2) - delta, wp.dot(n, end.d2) - delta)
    t3 = root_after(t, wp.dot(n, start.d3) - delta, wp.dot(n, end.d3) - delta)
    return wp.min(wp.min(t0, t1), wp.min(t2, t3))


@wp.func
def control_gap(na: vec3, nb: vec3, a: Differences, b: Differences):
    """Least middle control value, m, of the parabolas n(t) . d_k(t) between two times, n and d_k linear from a to b."""
    g0 = wp.dot(na, b.d0) + wp.dot(nb, a.d0)
    g1 = wp.dot(na, b.d1) + wp.dot(nb, a.d1)
    g2 = wp.dot(na, b.d2) + wp.dot(nb, a.d2)
    g3 = wp.dot(na, b.d3) + wp.dot(nb, a.d3)
    return real(0.5) * wp.min(wp.min(g0, g1), wp.min(g2, g3))


@wp.func
def apart_while_turning(kind: int, a: Differences, b: Differences, delta: real):
    """Whether a direction that turns with the features separates them by more than delta from a time to a later one."""
    for number in range(direction_count(kind)):
        na = direction_of(kind, number, a)
        nb = direction_of(kind, number, b)
        gap = wp.min(wp.min(gap_along(na, a), gap_along(nb, b)), control_gap(na, nb, a, b))
        if gap > delta:
            return True
    return False


@wp.func
def first_touch(kind: int, start: Differences, end: Differences, delta: real):
    """Time until which the features are proven to be farther apart than delta: FREE if always, zero if never."""
    t = real(0.0)
    stride = real(1.0)
    for _advance in range(ADVANCES):
        d = between(start, end, t)
        farthest = t
        for number in range(direction_count(kind)):
            until = apart_until(direction_of(kind, number, d), start, end, t, delta)
            if until >= real(1.0):
                return FREE
            farthest = wp.max(farthest, until)
        if farthest <= t:
            return t
        goal = wp.min(t + stride, real(1.0))
        if farthest >= goal:
            stride = real(2.0) * (farthest - t)
        elif apart_while_turning(kind, d, between(start, end, goal), delta):
            if goal >= real(1.0):
                return FREE
            farthest = goal
            stride = real(2.0) * stride
        else:
            stride = real(0.5) * stride
        t = farthest
    return t


@wp.kernel(enable_backward=False)
def advance_pairs(
    kinds: wp.array(dtype=wp.int32),
    firsts: wp.array(dtype=wp.int32),
    seconds: wp.array(dtype=wp.int32),
    start: wp.array(dtype=vec3),
    end: wp.array(dtype=vec3),
    features: Features,
    touching: real,
    # out
    times: wp.array(dtype=real),
):
    """Time of the first touch of each pair of features; zero for a pair that touches at the start, FREE if none."""
    i = wp.tid()
    times[i] = first_touch(
        kinds[i],
        differences_of(kinds[i], firsts[i], seconds[i], features, start),
        differences_of(kinds[i], firsts[i], seconds[i], features, end),
        touching,
    )
