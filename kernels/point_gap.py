"""Gap between a slave point and a layer, paper (28)-(30).

    delta = x - r(P),   d = +-|delta|  (sign: side of the layer, by its normal at the closest point P)
    g = s d - h      where the side s = +1, -1 of the pair is known and P lies inside the layer
    g = |d| - h      where P lies on the outer boundary of the layer, or s is free (0)
    dg/dx = s n,   dg/dq_i = -s S_i(P) n,   n = delta / d

h is the distance at which the pair begins to press; (30) has (th_M + th_S) / 2. The gap is measured to the closest
point of the whole layer, one force per point and layer: so it is continuous between elements and never counted twice.
The nearest plane sub-triangles of each element start the projection on its cubic surface; dP/dq does not matter,
because delta is orthogonal to every way that P can go.
"""

import warp as wp

from .closest_point import (
    CORNER,
    INSIDE,
    SIDE,
    Surface,
    box_distance_squared,
    closest_on_triangle,
    corner_angle,
    is_outer,
    normal_of,
    point_of,
)
from .precision import real, vec3, vec9
from .projection import FAR, Elements, Foot, element_of, feature_of, project
from .specht import shape_values

FREE = wp.constant(0)  # side of a pair that may lie on either side: unsigned distance
UNKNOWN = wp.constant(2)  # side of a pair that was not looked at yet: no force
NO_CONTACT = wp.constant(real(1.0e30))  # gap of a pair that cannot touch, m

NONE = wp.constant(-1)
ITERATIONS = wp.constant(8)  # of the projection; 2 or 3 settle it in contact range
ASTRAY = wp.constant(real(2e-3))  # squared sine between delta and the normal of a closest point, at most
TIE = wp.constant(real(1e-9))  # relative difference of squared distances that are taken to be equal


@wp.struct
class Masters:
    """Layers: their cubic elements and the sub-triangles of these.

    facets: sub-triangulated surface, those of one element follow each other; corners: area coordinates of the corners
    of one element's sub-triangles, three each; elements: cubic surface; outer: bits 0-2 side m, bits 3-5 corner m of
    the element lies on the outer boundary of its layer; errors: how far the cubic surface may lie from the
    sub-triangles in an element and those around it, m; zone: distance (m) up to which the cubic surface counts.
    """

    facets: Surface
    corners: wp.array(dtype=vec3)
    elements: Elements
    outer: wp.array(dtype=wp.int32)
    errors: wp.array(dtype=real)
    zone: real


@wp.struct
class Pairs:
    """Slave point and layer pairs.

    points, layers: slave point and layer of each pair; candidates[starts : ends]: sub-triangles of the layer; found:
    their distances when they were found, m, which have changed by no more than change[0] since; thickness: h, m;
    sides: +1, -1, FREE or UNKNOWN; least: how far at least the sub-triangles were from the point in the accepted state,
    m, negative where it was through.
    """

    points: wp.array(dtype=wp.int32)
    layers: wp.array(dtype=wp.int32)
    starts: wp.array(dtype=wp.int32)
    ends: wp.array(dtype=wp.int32)
    candidates: wp.array(dtype=wp.int32)
    found: wp.array(dtype=real)
    change: wp.array(dtype=real)
    thickness: wp.array(dtype=real)
    sides: wp.array(dtype=wp.int32)
    least: wp.array(dtype=real)


@wp.struct
class Motion:
    """Motion since the accepted state.

    slaves: positions of the slave points in that state, m; shifts, spreads: no node of a layer has moved by more than
    its spread, m, from being shifted; error: largest error of all elements (one number, m). Infinite spreads and error
    where nothing is known: then every pair is looked at.
    """

    slaves: wp.array(dtype=vec3)
    shifts: wp.array(dtype=vec3)
    spreads: wp.array(dtype=real)
    error: wp.array(dtype=real)


@wp.struct
class Contacts:
    """State of every pair.

    gaps: g, m; normals: dg/dx; elements, shapes: element of the closest point and its shape functions
    there (these for g < 0 only); distances: d, m; outer: whether the closest point is on the layer's outer boundary;
    heights: signed distance from the layer's tangent plane there, m; facets: distance of the sub-triangles, m.
    """

    gaps: wp.array(dtype=real)
    normals: wp.array(dtype=vec3)
    elements: wp.array(dtype=wp.int32)
    shapes: wp.array(dtype=vec9)
    distances: wp.array(dtype=real)
    heights: wp.array(dtype=real)
    facets: wp.array(dtype=real)
    outer: wp.array(dtype=wp.bool)


@wp.struct
class LayerPoint:
    """Closest point of a layer: signed distance d, unit normal n = dd/dx, height over the tangent plane."""

    distance: real
    height: real
    normal: vec3
    areas: vec3
    element: wp.int32
    outer: wp.bool


@wp.func
def feature_normal(
    surface: Surface, candidates: wp.array(dtype=wp.int32), start: int, end: int, triangle: int, feature: int
):
    """Normal of the layer at a side or corner: sum over its sub-triangles there, by angle (Baerentzen, Aanaes 2005)."""
    total = vec3()
    if feature >= CORNER:
        corner = surface.triangles[triangle, feature - CORNER]
        for k in range(start, end):
            t = candidates[k]
            for m in range(3):
                if surface.triangles[t, m] == corner:
                    total += corner_angle(surface, t, m) * normal_of(surface, t)
    else:
        a = surface.triangles[triangle, feature - SIDE]
        b = surface.triangles[triangle, (feature - SIDE + 1) % 3]
        for k in range(start, end):
            t = candidates[k]
            for m in range(3):
                i = surface.triangles[t, m]
                j = surface.triangles[t, (m + 1) % 3]
                if (i == a and j == b) or (i == b and j == a):
                    total += normal_of(surface, t)
    return wp.normalize(total)


@wp.func
def placed(p: LayerPoint, feature: int, outer: int, delta: vec3, normal: vec3, astray: bool):
    """p with distance, height and direction of `delta` from it; `normal` is that of the layer there.

    `astray`: p lies inside, but is not the closest point.
    """
    p.outer = is_outer(outer, feature)
    p.height = wp.dot(delta, normal)
    p.normal = normal
    p.distance = p.height
    if feature != INSIDE or astray:
        p.distance = wp.length(delta)
        if p.distance > real(0.0):
            p.normal = delta / p.distance
        if p.height < real(0.0):
            p.distance = -p.distance
            p.normal = -p.normal
    return p


@wp.func
def element_areas(masters: Masters, triangle: int, weights: vec3):
    """Element of a sub-triangle, and area coordinates there of a point given by those in the sub-triangle."""
    per_element = masters.corners.shape[0] // 3
    element = triangle // per_element
    first = 3 * (triangle - element * per_element)
    areas = (
        weights[0] * masters.corners[first]
        + weights[1] * masters.corners[first + 1]
        + weights[2] * masters.corners[first + 2]
    )
    return element, areas


@wp.func
def facet_point(masters: Masters, pairs: Pairs, start: int, end: int, x: vec3, reach: real):
    """Closest point to x of the sub-triangles candidates[start:end], all of one layer; element -1 beyond `reach`."""
    surface = masters.facets
    change = pairs.change[0]
    p = LayerPoint()
    p.element = NONE
    triangle = NONE
    nearest = reach
    best = reach * reach
    feature = INSIDE
    weights = vec3()
    for k in range(start, end):
        if pairs.found[k] - change <= nearest:
            t = pairs.candidates[k]
            # not by functions of the surface: on the CPU a call copies all its arrays' headers
            a = surface.points[surface.triangles[t, 0]]
            b = surface.points[surface.triangles[t, 1]]
            c = surface.points[surface.triangles[t, 2]]
            if box_distance_squared(x, a, b, c) <= best:
                there, here = closest_on_triangle(x, a, b, c)
                d2 = wp.length_sq(x - (there[0] * a + there[1] * b + there[2] * c))
                if d2 < best:
                    best = d2
                    nearest = wp.sqrt(d2)
                    weights = there
                    triangle = t
                    feature = here
    if triangle < 0:
        return p
    element, areas = element_areas(masters, triangle, weights)
    p.element = element
    p.areas = areas
    normal = normal_of(surface, triangle)
    if feature != INSIDE:
        normal = feature_normal(surface, pairs.candidates, start, end, triangle, feature)
    return placed(p, feature, surface.outer[triangle], x - point_of(surface, triangle, weights), normal, False)


@wp.func
def cubic_point(
    masters: Masters,
    pairs: Pairs,
    start: int,
    end: int,
    x: vec3,
    facet: LayerPoint,
    least: real,
):
    """Closest point to x of the cubic surface of the layer whose nearest sub-triangle point is `facet`.

    Where its distance is sure to be above `least`, m, it may be a point near the closest one.

    Every element is projected on that has a sub-triangle almost as near, from the nearest of its own: so the least
    distance of the layer is found on both sides of a border between elements, where the sub-triangles may order the
    elements the other way round.
    """
    surface = masters.facets
    per_element = masters.corners.shape[0] // 3
    farthest = wp.abs(facet.distance) * (real(1.0) + TIE) + real(2.0) * masters.errors[facet.element]
    farthest = wp.min(farthest, masters.zone)
    nearest = farthest * farthest
    triangle = NONE
    weights = vec3()
    best = NO_CONTACT
    foot = Foot()
    normal = vec3()
    total = vec3()
    p = facet
    change = pairs.change[0]
    for k in range(start, end):
        t = pairs.candidates[k]
        element = t // per_element
        if pairs.found[k] - change <= farthest:
            a = surface.points[surface.triangles[t, 0]]
            b = surface.points[surface.triangles[t, 1]]
            c = surface.points[surface.triangles[t, 2]]
            if box_distance_squared(x, a, b, c) <= nearest:
                there, _feature = closest_on_triangle(x, a, b, c)
                d2 = wp.length_sq(x - (there[0] * a + there[1] * b + there[2] * c))
                if d2 <= nearest:
                    nearest = d2
                    triangle = t
                    weights = there
        if (k + 1 == end or pairs.candidates[wp.min(k + 1, end - 1)] // per_element != element) and triangle >= 0:
            _same, areas = element_areas(masters, triangle, weights)
            found = project(x, areas, element_of(masters.elements, element), masters.elements, ITERATIONS, least)
            d2 = wp.length_sq(x - found.r)
            here = wp.normalize(wp.cross(found.x, found.y))
            if d2 < best * (real(1.0) - TIE):
                best = d2
                foot = found
                normal = here
                total = here
                p.element = element
            elif d2 <= best * (real(1.0) + TIE):
                total += here
            nearest = farthest * farthest
            triangle = NONE
    if best == NO_CONTACT:  # the nearest sub-triangle lies on the border of the zone, within round-off
        return facet
    p.areas = foot.areas
    feature = feature_of(foot.areas)
    if feature != INSIDE:  # elements that meet in the point
        normal = wp.normalize(total)
    delta = x - foot.r
    height = wp.dot(delta, normal)
    # the surface may be bent too sharply to find its closest point: being low over a tangent plane is not being near
    length_sq = wp.length_sq(delta)
    astray = length_sq - height * height > ASTRAY * (length_sq + ASTRAY * masters.zone * masters.zone)
    return placed(p, feature, masters.outer[p.element], delta, normal, astray)


@wp.func
def side_of(p: LayerPoint, side: int):
    """+1 or -1: what makes the distance of p a gap for a pair on `side`."""
    direction = real(side)
    if p.outer or side == FREE:
        direction = real(1.0)
        if p.distance < real(0.0):
            direction = real(-1.0)
    return direction


@wp.func
def farthest_of_interest(side: int, reach: real, seen: real, presses: real, least: real, change: real):
    """Distance of sub-triangles, m, beyond which a pair can have no force; negative where it has none for sure.

    presses: farthest distance at which a pair can press on the side where it was, m; change: of its distance since the
    accepted state, where that was at least `least`, m, at most.

    A point that has gone through has done so by no more than `change` less its distance then. Beyond that, a point on
    the other side of what is nearest has gone through nothing: another part of the layer is nearest.
    """
    # how much more than the reach is known depends on when the pairs were found, and must not matter
    known = wp.min(least, reach)
    farthest = wp.min(seen, wp.max(presses, change - known))
    if side == UNKNOWN:
        known = least
        farthest = seen
    elif side == FREE:
        farthest = wp.min(seen, presses)
    if known - change > farthest:
        farthest = real(-1.0)
    return farthest


@wp.func
def out_of_reach(pair: int, gaps: wp.array(dtype=real), distances: wp.array(dtype=real), facets: wp.array(dtype=real)):
    """Writes that a pair is too far apart to be looked at."""
    gaps[pair] = NO_CONTACT
    distances[pair] = NO_CONTACT
    facets[pair] = NO_CONTACT


@wp.func
def write_contact(pair: int, x: vec3, reach: real, farthest: real, masters: Masters, pairs: Pairs, contacts: Contacts):
    """Gap and direction of one pair; no contact beyond `reach` (m).

    Distances are found up to `farthest`, m, not beyond where the candidates are complete. Where the sub-triangles alone
    say that there is no force, what they say of the distance is kept.
    """
    start = pairs.starts[pair]
    end = pairs.ends[pair]
    p = facet_point(masters, pairs, start, end, x, farthest)
    if p.element < 0:
        out_of_reach(pair, contacts.gaps, contacts.distances, contacts.facets)
        return
    side = pairs.sides[pair]
    contacts.facets[pair] = wp.abs(p.distance)
    gap = side_of(p, side) * p.distance - pairs.thickness[pair]
    near = gap <= masters.errors[p.element] or side == UNKNOWN
    if near and wp.abs(p.distance) <= masters.zone:
        facet = p
        p = cubic_point(masters, pairs, start, end, x, facet, pairs.thickness[pair])
        if side_of(p, side) * p.distance < -pairs.thickness[pair]:  # far on the wrong side
            p = cubic_point(masters, pairs, start, end, x, facet, FAR)
    direction = side_of(p, side)
    gap = direction * p.distance - pairs.thickness[pair]
    if side == UNKNOWN or wp.abs(p.distance) > reach:
        gap = NO_CONTACT
    contacts.gaps[pair] = gap
    contacts.normals[pair] = direction * p.normal
    contacts.elements[pair] = p.element
    contacts.distances[pair] = p.distance
    contacts.heights[pair] = p.height
    contacts.outer[pair] = p.outer
    if gap < real(0.0):
        contacts.shapes[pair] = shape_values(p.areas, element_of(masters.elements, p.element).c)
