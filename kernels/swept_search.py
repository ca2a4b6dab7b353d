"""Which features of the sub-triangles are near each other: the distance of those whose boxes overlap.

near = { (A, B) : distance(A, B) <= radius, A and B share no point }      A, B a vertex and a triangle, or two edges
"""

import warp as wp

from .precision import real, vec3
from .swept import (
    EDGE_EDGE,
    VERTEX_TRIANGLE,
    Differences,
    Features,
    differences_of,
    direction_count,
    direction_of,
    gap_along,
)

FAR = wp.constant(real(wp.inf))


@wp.func
def box_distance(d: Differences):
    """Distance of zero from the box around all differences, m: a cheap bound from below."""
    low = wp.min(wp.min(d.d0, d.d1), wp.min(d.d2, d.d3))
    high = wp.max(wp.max(d.d0, d.d1), wp.max(d.d2, d.d3))
    return wp.length(wp.max(wp.max(low, -high), vec3()))


@wp.func
def distance_within(kind: int, d: Differences, radius: real):
    """Distance between two features, m, or some bound above `radius` where it is larger than that."""
    distance = wp.min(box_distance(d), real(0.0))
    if box_distance(d) > radius:
        return box_distance(d)
    for number in range(direction_count(kind)):
        distance = wp.max(distance, gap_along(direction_of(kind, number, d), d))
        if distance > radius:
            return distance
    return distance


@wp.kernel(enable_backward=False)
def find_vertices_near_triangles(
    points: wp.array(dtype=wp.int32),
    triangles: wp.array(dtype=wp.int32),
    positions: wp.array(dtype=vec3),
    radius: real,
    features: Features,
    # out
    distances: wp.array(dtype=real),
):
    """Distance of points[i] from triangles[i], m, as distance_within; infinite for corners of the triangle."""
    i = wp.tid()
    point = points[i]
    triangle = triangles[i]
    distances[i] = FAR
    g = features.groups[point]
    ga = features.groups[features.triangles[triangle, 0]]
    gb = features.groups[features.triangles[triangle, 1]]
    gc = features.groups[features.triangles[triangle, 2]]
    if g != ga and g != gb and g != gc:
        differences = differences_of(VERTEX_TRIANGLE, point, triangle, features, positions)
        distances[i] = distance_within(VERTEX_TRIANGLE, differences, radius)


@wp.kernel(enable_backward=False)
def find_edges_near_edges(
    firsts: wp.array(dtype=wp.int32),
    seconds: wp.array(dtype=wp.int32),
    positions: wp.array(dtype=vec3),
    radius: real,
    features: Features,
    # out
    distances: wp.array(dtype=real),
):
    """Distance of two edges, m, as distance_within; infinite where they share a point."""
    i = wp.tid()
    # one order of the two whichever was looked up: what is found later must not depend on the state here
    first = wp.max(firsts[i], seconds[i])
    second = wp.min(firsts[i], seconds[i])
    distances[i] = FAR
    ga = features.groups[features.edges[first, 0]]
    gb = features.groups[features.edges[first, 1]]
    gc = features.groups[features.edges[second, 0]]
    ge = features.groups[features.edges[second, 1]]
    if ga != gc and ga != ge and gb != gc and gb != ge:
        distances[i] = distance_within(EDGE_EDGE, differences_of(EDGE_EDGE, first, second, features, positions), radius)
