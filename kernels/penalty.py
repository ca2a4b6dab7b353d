"""Gap and normal force between a slave point and a layer, paper (30), (36), (44): shared by sts and nts.

    delta = x - c,   d = +-|delta|  (sign: side of the layer, by its normal at the closest point c)
    g = s d - h      where the side s = +1, -1 of the pair is known and c lies inside the layer
    g = |d| - h      where c lies on the outer boundary of the layer, or s is free (0)
    dU/dg = k g  for g < 0,   dg/dx = s n,   dg/dx_m = -s w_m n,   n = delta / d

h is the effective thickness of the pair; (30) has (th_M + th_S) / 2. The gap is measured to the closest point of the
whole layer, one force per point and layer: so it is continuous between sub-triangles and never counted twice.
"""

import warp as wp

from .closest_point import (
    CORNER,
    INSIDE,
    SIDE,
    Surface,
    box_distance_squared,
    closest_of,
    corner_angle,
    is_outer,
    normal_of,
    point_of,
)
from .precision import real, vec3

FREE = wp.constant(0)  # side of a pair that may lie on either side: unsigned distance
UNKNOWN = wp.constant(2)  # side of a pair that was not looked at yet: no force
NO_CONTACT = wp.constant(real(1.0e30))  # gap of a pair that cannot touch, m


@wp.struct
class Pairs:
    """Slave point and layer pairs.

    points: slave point of each pair; candidates[starts : ends]: sub-triangles of its layer; thickness: effective
    thickness, m; sides: +1, -1, FREE or UNKNOWN.
    """

    points: wp.array(dtype=wp.int32)
    starts: wp.array(dtype=wp.int32)
    ends: wp.array(dtype=wp.int32)
    candidates: wp.array(dtype=wp.int32)
    thickness: wp.array(dtype=real)
    sides: wp.array(dtype=wp.int32)


@wp.struct
class Contacts:
    """State of every pair.

    gaps: g, m; forces: dU/dg, N; normals: dg/dx; triangles, weights: closest sub-triangle and area coordinates there;
    distances: d, m; outer: whether the closest point is on the layer's outer boundary; heights: signed distance from
    the layer's tangent plane there, m.
    """

    gaps: wp.array(dtype=real)
    forces: wp.array(dtype=real)
    normals: wp.array(dtype=vec3)
    triangles: wp.array(dtype=wp.int32)
    weights: wp.array(dtype=vec3)
    distances: wp.array(dtype=real)
    heights: wp.array(dtype=real)
    outer: wp.array(dtype=wp.bool)


@wp.struct
class LayerPoint:
    """Closest point of a layer: signed distance d, unit normal n = dd/dx, height over the tangent plane."""

    distance: real
    height: real
    normal: vec3
    weights: vec3
    triangle: wp.int32
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
def layer_point(surface: Surface, candidates: wp.array(dtype=wp.int32), start: int, end: int, x: vec3, reach: real):
    """Closest point to x of the sub-triangles candidates[start:end], all of one layer; triangle -1 beyond `reach`."""
    p = LayerPoint()
    p.triangle = -1
    best = reach * reach
    feature = INSIDE
    for k in range(start, end):
        t = candidates[k]
        if box_distance_squared(surface, t, x) <= best:
            weights, here = closest_of(surface, t, x)
            delta = x - point_of(surface, t, weights)
            d2 = wp.dot(delta, delta)
            if d2 < best:
                best = d2
                p.weights = weights
                p.triangle = t
                feature = here
    if p.triangle < 0:
        return p
    p.outer = is_outer(surface.outer[p.triangle], feature)
    delta = x - point_of(surface, p.triangle, p.weights)
    if feature == INSIDE:
        p.normal = normal_of(surface, p.triangle)
        p.distance = wp.dot(delta, p.normal)
        p.height = p.distance
        return p
    normal = feature_normal(surface, candidates, start, end, p.triangle, feature)
    p.height = wp.dot(delta, normal)
    p.distance = wp.length(delta)
    if p.distance > real(0.0):
        normal = delta / p.distance
    if p.height < real(0.0):
        p.distance = -p.distance
        normal = -normal
    p.normal = normal
    return p


@wp.func
def write_contact(pair: int, x: vec3, stiffness: real, reach: real, surface: Surface, pairs: Pairs, contacts: Contacts):
    """Gap, force and direction of one pair; no contact beyond `reach` (m), up to where the candidates are complete."""
    p = layer_point(surface, pairs.candidates, pairs.starts[pair], pairs.ends[pair], x, reach)
    if p.triangle < 0:
        contacts.gaps[pair] = NO_CONTACT
        contacts.distances[pair] = NO_CONTACT
        return
    side = pairs.sides[pair]
    direction = real(side)
    if p.outer or side == FREE:
        direction = real(1.0)
        if p.distance < real(0.0):
            direction = real(-1.0)
    gap = direction * p.distance - pairs.thickness[pair]
    if side == UNKNOWN:
        gap = NO_CONTACT
    contacts.gaps[pair] = gap
    contacts.forces[pair] = stiffness * wp.min(gap, real(0.0))
    contacts.normals[pair] = direction * p.normal
    contacts.triangles[pair] = p.triangle
    contacts.weights[pair] = p.weights
    contacts.distances[pair] = p.distance
    contacts.heights[pair] = p.height
    contacts.outer[pair] = p.outer
