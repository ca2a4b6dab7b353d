"""Edge-to-edge contact: where two creases or free edges cross, between the points that the other two elements see.

    U = 1/2 eps_e m g^2  for g < 0,   g = S n . delta - h,   n = r_1' x r_2' / |r_1' x r_2'|
    m = M(sin^2 / e) M(rho / e) M(s / z_1) M((1 - s) / z_1) M(t / z_2) M((1 - t) / z_2)
    M(x) = x^3 (10 - 15 x + 6 x^2)

at every pair of closest points inside both edges. S is the side on which edge 2 was at the last accepted state. rho is
the determinant of the second derivatives of |delta|^2 / 2 over |r_1'|^2 |r_2'|^2: sin^2 of the angle between straight
edges; it vanishes where closest points of bent edges cease to be. So U goes to zero with its derivative towards the
ends (zones z), towards parallel, and before closest points disappear. Gradient:

    dg = S n . (dr_2 - dr_1)                                  delta is orthogonal to every way the points can go
    dm = partial dm - lambda . dF,   lambda = H^-1 (m_s, m_t)    F = (-delta . r_1', delta . r_2') = 0 moves s and t
"""

import warp as wp

from .edge_curve import CurvePoint, closest_on_curves, closest_on_segments, curve_point
from .edge_search import least_distance, part_of
from .point_gap import FREE, NO_CONTACT
from .precision import real, vec2, vec3

NEAR_PARALLEL = wp.constant(real(1e-3))  # e: squared sine below which the force fades
SAME = wp.constant(real(1e-6))  # difference of parameters below which closest points are the same
TURNED = wp.constant(real(0.5))  # least cosine between n now and at the accepted state for which the side holds


@wp.struct
class EdgePairs:
    """Pairs of edges near each other.

    first, second: edges; candidates[starts : ends]: parts near each other, i * divisions + j, increasing; thickness:
    effective thickness h of the pair, m; known_starts, known_ends: closest points of the pair in `Known`.
    """

    first: wp.array(dtype=wp.int32)
    second: wp.array(dtype=wp.int32)
    starts: wp.array(dtype=wp.int32)
    ends: wp.array(dtype=wp.int32)
    candidates: wp.array(dtype=wp.int32)
    thickness: wp.array(dtype=real)
    known_starts: wp.array(dtype=wp.int32)
    known_ends: wp.array(dtype=wp.int32)


@wp.struct
class Known:
    """Last accepted state: control points (m), closest points of pairs that were near, and their sides +1, -1, FREE."""

    controls: wp.array(dtype=vec3)
    parameters: wp.array(dtype=vec2)
    sides: wp.array(dtype=wp.int32)


@wp.struct
class EdgeContacts:
    """Closest points, one place per candidate; places that found nothing, or what an earlier one has, are empty.

    gaps: g, m; weights, angle_weights: m, and its first two factors; parameters: s, t; normals: S n, where S is free
    along delta; heights: n . delta, m; distances: |delta|, m, also at the ends; sides: S; pulls, slopes1, slopes2,
    bends1, bends2: dm as factors of dr_2 - dr_1, dr_1', dr_2', dr_1'', dr_2''. All but the first two, parameters and
    distances only where m > 0 within the reach.
    """

    gaps: wp.array(dtype=real)
    weights: wp.array(dtype=real)
    angle_weights: wp.array(dtype=real)
    parameters: wp.array(dtype=vec2)
    normals: wp.array(dtype=vec3)
    heights: wp.array(dtype=real)
    distances: wp.array(dtype=real)
    sides: wp.array(dtype=wp.int32)
    pulls: wp.array(dtype=vec3)
    slopes1: wp.array(dtype=vec3)
    slopes2: wp.array(dtype=vec3)
    bends1: wp.array(dtype=vec3)
    bends2: wp.array(dtype=vec3)


@wp.struct
class Weight:
    """m, its factor of angle and curvature, and its derivatives as in EdgeContacts."""

    value: real
    angle: real
    pull: vec3
    slope1: vec3
    slope2: vec3
    bend1: vec3
    bend2: vec3


@wp.func
def fade(x: real):
    """M(x): 0 below 0, 1 above 1, twice continuously differentiable."""
    y = wp.clamp(x, real(0.0), real(1.0))
    return y * y * y * (real(10.0) - y * (real(15.0) - real(6.0) * y))


@wp.func
def fade_slope(x: real):
    """dM/dx."""
    y = wp.clamp(x, real(0.0), real(1.0))
    return real(30.0) * y * y * (real(1.0) - y) * (real(1.0) - y)


@wp.func
def fade_ends(s: real, zone: real):
    """Product of M towards both ends of an edge, and its derivative."""
    one = real(1.0)
    a = fade(s / zone)
    b = fade((one - s) / zone)
    return a * b, (fade_slope(s / zone) * b - a * fade_slope((one - s) / zone)) / zone


@wp.func
def weight_at(p: CurvePoint, q: CurvePoint, at: vec2, zone1: real, zone2: real):
    """m and its derivative at closest points p, q with parameters `at`; zones: of the ends."""
    one = real(1.0)
    delta = q.r - p.r
    aa = wp.dot(p.d1, p.d1)
    bb = wp.dot(q.d1, q.d1)
    c = wp.dot(p.d1, q.d1)
    a = wp.dot(delta, p.d2) / aa
    b = wp.dot(delta, q.d2) / bb
    sine = wp.length_sq(wp.cross(p.d1, q.d1)) / (aa * bb)
    rho = sine - a + b - a * b
    end1, end1_s = fade_ends(at[0], zone1)
    end2, end2_t = fade_ends(at[1], zone2)
    ends = end1 * end2
    m = Weight()
    m.angle = fade(sine / NEAR_PARALLEL) * fade(rho / NEAR_PARALLEL)
    if a >= one:  # no minimum
        m.angle = real(0.0)
    m.value = m.angle * ends
    if m.value <= real(0.0):
        return m
    by_rho = ends * fade(sine / NEAR_PARALLEL) * fade_slope(rho / NEAR_PARALLEL) / NEAR_PARALLEL
    by_sine = by_rho + ends * fade_slope(sine / NEAR_PARALLEL) * fade(rho / NEAR_PARALLEL) / NEAR_PARALLEL
    by_a = -by_rho * (one + b)
    by_b = by_rho * (one - a)
    turn = -real(2.0) * by_sine * c / (aa * bb)
    m.pull = (by_a / aa) * p.d2 + (by_b / bb) * q.d2
    m.slope1 = turn * (q.d1 - (c / aa) * p.d1) - (real(2.0) * by_a * a / aa) * p.d1
    m.slope2 = turn * (p.d1 - (c / bb) * q.d1) - (real(2.0) * by_b * b / bb) * q.d1
    m.bend1 = (by_a / aa) * delta
    m.bend2 = (by_b / bb) * delta
    m_s = wp.dot(m.slope1, p.d2) + wp.dot(m.bend1, p.d3) - wp.dot(m.pull, p.d1) + m.angle * end1_s * end2
    m_t = wp.dot(m.slope2, q.d2) + wp.dot(m.bend2, q.d3) + wp.dot(m.pull, q.d1) + m.angle * end1 * end2_t
    # lambda = H^-1 (m_s, m_t),  det H = aa bb rho
    l1 = (bb * (one + b) * m_s + c * m_t) / (aa * bb * rho)
    l2 = (aa * (one - a) * m_t + c * m_s) / (aa * bb * rho)
    m.pull += l1 * p.d1 - l2 * q.d1
    m.slope1 += l1 * delta
    m.slope2 -= l2 * delta
    return m


@wp.func
def direction_before(
    pair: int, first: int, second: int, at: vec2, zone1: real, zone2: real, pairs: EdgePairs, known: Known
):
    """Unit vector from edge 1 to the side of it where edge 2 was at the accepted state; zero where that is free."""
    before = closest_on_curves(known.controls, first, second, at)
    p = curve_point(known.controls, first, before[0])
    q = curve_point(known.controls, second, before[1])
    normal = wp.normalize(wp.cross(p.d1, q.d1))
    for k in range(pairs.known_starts[pair], pairs.known_ends[pair]):
        if wp.length(known.parameters[k] - before) < SAME:
            return real(known.sides[k]) * normal
    if weight_at(p, q, before, zone1, zone2).value < real(1.0):
        return vec3()
    return wp.sign(wp.dot(normal, q.r - p.r)) * normal


@wp.func
def side_now(normal: vec3, before: vec3):
    """+1, -1 or FREE for n from the direction at the accepted state.

    Comparing directions, not signs of the triple product: that changes also where edges turn past parallel.
    """
    cosine = wp.dot(normal, before)
    if cosine >= TURNED:
        return 1
    if cosine <= -TURNED:
        return -1
    return FREE


@wp.func
def found_before(contacts: EdgeContacts, start: int, place: int, at: vec2):
    """Whether a place from `start` on before `place` holds the closest points `at`."""
    for k in range(start, place):
        if contacts.distances[k] < NO_CONTACT and wp.length(contacts.parameters[k] - at) < SAME:
            return True
    return False


@wp.kernel(enable_backward=False)
def edge_contacts(
    controls: wp.array(dtype=vec3),
    zones: wp.array(dtype=real),
    divisions: int,
    reach: real,
    pairs: EdgePairs,
    known: Known,
    begin: int,
    # out
    contacts: EdgeContacts,
):
    """Gaps of pairs of edges, one thread per pair; edges farther apart than `reach` (m) have none."""
    pair = begin + wp.tid()
    first = pairs.first[pair]
    second = pairs.second[pair]
    start = pairs.starts[pair]
    zone1 = zones[first]
    zone2 = zones[second]
    h = pairs.thickness[pair]
    for k in range(start, pairs.ends[pair]):
        contacts.gaps[k] = NO_CONTACT
        contacts.weights[k] = real(0.0)
        contacts.distances[k] = NO_CONTACT
        i = pairs.candidates[k] // divisions
        j = pairs.candidates[k] % divisions
        a = part_of(controls, first, i, divisions)
        b = part_of(controls, second, j, divisions)
        chord = closest_on_segments(a.start, a.along, b.start, b.along, real(0.5))
        # which parts count depends on this state alone, not on when the candidates were found: same bits
        if least_distance(a, b, chord) > reach:
            continue
        at = closest_on_curves(controls, first, second, (vec2(real(i), real(j)) + chord) / real(divisions))
        if found_before(contacts, start, k, at):
            continue
        p = curve_point(controls, first, at[0])
        q = curve_point(controls, second, at[1])
        distance = wp.length(q.r - p.r)
        contacts.parameters[k] = at
        contacts.distances[k] = distance
        m = weight_at(p, q, at, zone1, zone2)
        if distance > reach or m.value <= real(0.0):
            continue
        normal = wp.normalize(wp.cross(p.d1, q.d1))
        height = wp.dot(normal, q.r - p.r)
        side = side_now(normal, direction_before(pair, first, second, at, zone1, zone2, pairs, known))
        sign = real(side)
        if side == FREE:
            sign = real(1.0)
            if height < real(0.0):
                sign = real(-1.0)
        contacts.gaps[k] = sign * height - h
        contacts.weights[k] = m.value
        contacts.angle_weights[k] = m.angle
        contacts.normals[k] = sign * normal
        contacts.heights[k] = height
        contacts.sides[k] = side
        contacts.pulls[k] = m.pull
        contacts.slopes1[k] = m.slope1
        contacts.slopes2[k] = m.slope2
        contacts.bends1[k] = m.bend1
        contacts.bends2[k] = m.bend2
