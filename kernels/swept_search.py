"""Which features of the sub-triangles are near each other: hash grids over points and over middles of edges.

    near = { (A, B) : distance(A, B) <= radius, A and B share no point }      A, B a vertex and a triangle, or two edges

The longer of two edges finds the shorter one, whose middle is at most half of both lengths and the radius away from its
own: every feature queries with its own size, so that graded meshes cost no more than even ones. Exact: the pairs are
counted whether or not the arrays hold them all; if not, larger ones are filled anew.
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


@wp.struct
class NearPairs:
    """Found pairs in any order, their distances (m; zero or less where they touch), and (1,) how many there are.

    kinds: VERTEX_TRIANGLE (first: point, second: triangle) or EDGE_EDGE (two edges).
    """

    count: wp.array(dtype=wp.int32)
    kinds: wp.array(dtype=wp.int32)
    firsts: wp.array(dtype=wp.int32)
    seconds: wp.array(dtype=wp.int32)
    distances: wp.array(dtype=real)


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


@wp.func
def note_pair(
    kind: int,
    first: int,
    second: int,
    radius: real,
    positions: wp.array(dtype=vec3),
    features: Features,
    pairs: NearPairs,
):
    """Adds a pair if it is near."""
    distance = distance_within(kind, differences_of(kind, first, second, features, positions), radius)
    if distance <= radius:
        place = wp.atomic_add(pairs.count, 0, 1)
        if place < pairs.kinds.shape[0]:
            pairs.kinds[place] = kind
            pairs.firsts[place] = first
            pairs.seconds[place] = second
            pairs.distances[place] = distance


@wp.kernel(enable_backward=False)
def find_vertices_near_triangles(
    grid: wp.uint64,
    positions: wp.array(dtype=vec3),
    radius: real,
    features: Features,
    # out
    pairs: NearPairs,
):
    """Points within `radius` of each triangle but for its corners; `grid` holds the points."""
    triangle = wp.tid()
    a = positions[features.triangles[triangle, 0]]
    b = positions[features.triangles[triangle, 1]]
    c = positions[features.triangles[triangle, 2]]
    ga = features.groups[features.triangles[triangle, 0]]
    gb = features.groups[features.triangles[triangle, 1]]
    gc = features.groups[features.triangles[triangle, 2]]
    centre = (a + b + c) / real(3.0)
    size = wp.max(wp.max(wp.length(a - centre), wp.length(b - centre)), wp.length(c - centre))
    for point in wp.hash_grid_query(grid, centre, radius + size):
        g = features.groups[point]
        if g != ga and g != gb and g != gc:
            note_pair(VERTEX_TRIANGLE, point, triangle, radius, positions, features, pairs)


@wp.kernel(enable_backward=False)
def find_edges_near_edges(
    grid: wp.uint64,
    middles: wp.array(dtype=vec3),
    lengths: wp.array(dtype=real),
    positions: wp.array(dtype=vec3),
    radius: real,
    features: Features,
    # out
    pairs: NearPairs,
):
    """Shorter edges within `radius` of each edge that share no point with it; `grid` holds the middles."""
    edge = wp.tid()
    length = lengths[edge]
    ga = features.groups[features.edges[edge, 0]]
    gb = features.groups[features.edges[edge, 1]]
    for other in wp.hash_grid_query(grid, middles[edge], radius + length):
        if lengths[other] < length or (lengths[other] == length and other < edge):
            gc = features.groups[features.edges[other, 0]]
            ge = features.groups[features.edges[other, 1]]
            if ga != gc and ga != ge and gb != gc and gb != ge:
                # one order of the two whichever is longer: what is found later must not depend on the state here
                note_pair(EDGE_EDGE, wp.max(edge, other), wp.min(edge, other), radius, positions, features, pairs)
