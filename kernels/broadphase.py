"""Which sub-triangles may touch which points: hash grid over the points, queried by every sub-triangle.

    candidates = { (p, t) : distance(x_p, t) <= radius }

Exact: the pairs are counted whether or not the arrays hold them all; if not, larger ones are filled anew. Sub-triangles
of a face that the point itself belongs to count only where they are at least `apart` away from it in the flat sheet: a
face that curls back on itself.
"""

import warp as wp

from .closest_point import Surface, box_distance_squared, closest_of, normal_of, point_of
from .precision import real, vec3

FAR = wp.constant(real(-1.0))


@wp.struct
class Ownership:
    """What belongs together in the flat sheet.

    faces: face of each sub-triangle; starts, owners: faces that each point belongs to; points: flat positions of the
    slave points (z = 0), m; flat: the flat surface; apart: m.
    """

    faces: wp.array(dtype=wp.int32)
    starts: wp.array(dtype=wp.int32)
    owners: wp.array(dtype=wp.int32)
    points: wp.array(dtype=vec3)
    flat: Surface
    apart: real


@wp.struct
class Candidates:
    """Found pairs of points and sub-triangles in any order, their distances (m), and (1,) how many there are."""

    count: wp.array(dtype=wp.int32)
    points: wp.array(dtype=wp.int32)
    triangles: wp.array(dtype=wp.int32)
    distances: wp.array(dtype=real)


@wp.func
def distance_to(surface: Surface, triangle: int, x: vec3):
    """Distance of x from a sub-triangle, m."""
    weights, _ = closest_of(surface, triangle, x)
    return wp.length(x - point_of(surface, triangle, weights))


@wp.func
def may_touch(ownership: Ownership, point: int, triangle: int):
    """False for a sub-triangle of the point's own face near the point."""
    face = ownership.faces[triangle]
    for k in range(ownership.starts[point], ownership.starts[point + 1]):
        if ownership.owners[k] == face:
            return distance_to(ownership.flat, triangle, ownership.points[point]) >= ownership.apart
    return True


@wp.func
def bounding_ball(surface: Surface, triangle: int):
    """Centroid of a sub-triangle and the distance of its farthest corner."""
    a = surface.points[surface.triangles[triangle, 0]]
    b = surface.points[surface.triangles[triangle, 1]]
    c = surface.points[surface.triangles[triangle, 2]]
    centre = (a + b + c) / real(3.0)
    return centre, wp.max(wp.max(wp.length(a - centre), wp.length(b - centre)), wp.length(c - centre))


@wp.func
def candidate_distance(
    surface: Surface, ownership: Ownership, triangle: int, normal: vec3, point: int, x: vec3, radius: real
):
    """Distance of a point from a sub-triangle, m, or FAR where it is above `radius` or they may not touch."""
    from_plane = wp.dot(x - surface.points[surface.triangles[triangle, 0]], normal)
    if wp.abs(from_plane) > radius or box_distance_squared(surface, triangle, x) > radius * radius:
        return FAR
    distance = distance_to(surface, triangle, x)
    if distance > radius or not may_touch(ownership, point, triangle):
        return FAR
    return distance


@wp.kernel(enable_backward=False)
def find_candidates(
    grid: wp.uint64,
    positions: wp.array(dtype=vec3),
    radius: real,
    surface: Surface,
    ownership: Ownership,
    # out
    candidates: Candidates,
):
    """Points within `radius` of each sub-triangle; counts on beyond the arrays' size, so that the caller can tell."""
    triangle = wp.tid()
    centre, size = bounding_ball(surface, triangle)
    normal = normal_of(surface, triangle)
    for point in wp.hash_grid_query(grid, centre, radius + size):
        distance = candidate_distance(surface, ownership, triangle, normal, point, positions[point], radius)
        if distance != FAR:
            place = wp.atomic_add(candidates.count, 0, 1)
            if place < candidates.points.shape[0]:
                candidates.points[place] = point
                candidates.triangles[place] = triangle
                candidates.distances[place] = distance


@wp.kernel(enable_backward=False)
def mark_allowed(
    points: wp.array(dtype=wp.int32),
    triangles: wp.array(dtype=wp.int32),
    ownership: Ownership,
    # out
    allowed: wp.array(dtype=wp.bool),
):
    """Whether points[i] and triangles[i] may touch at all."""
    i = wp.tid()
    allowed[i] = may_touch(ownership, points[i], triangles[i])
