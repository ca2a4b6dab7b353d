"""Which sub-triangles may touch which points: hash grid over the points, queried by every sub-triangle.

    candidates = { (p, t) : distance(x_p, t) <= radius }

Exact: pairs are first counted, then filled into arrays of that size. A sub-triangle of a face the point itself belongs
to counts only where it is at least `apart` away from the point in the flat sheet: a face that curls back on itself.
"""

import warp as wp

from .closest_point import Surface, closest_of, point_of
from .precision import real, vec3


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


@wp.kernel(enable_backward=False)
def count_candidates(
    grid: wp.uint64,
    positions: wp.array(dtype=vec3),
    radius: real,
    surface: Surface,
    ownership: Ownership,
    # out
    counts: wp.array(dtype=wp.int32),
):
    """Number of points within `radius` of each sub-triangle."""
    triangle = wp.tid()
    centre, size = bounding_ball(surface, triangle)
    total = wp.int32(0)
    for point in wp.hash_grid_query(grid, centre, radius + size):
        x = positions[point]
        if wp.length(x - centre) <= radius + size and may_touch(ownership, point, triangle):
            if distance_to(surface, triangle, x) <= radius:
                total += 1
    counts[triangle] = total


@wp.kernel(enable_backward=False)
def fill_candidates(
    grid: wp.uint64,
    positions: wp.array(dtype=vec3),
    radius: real,
    surface: Surface,
    ownership: Ownership,
    starts: wp.array(dtype=wp.int32),
    # out
    points: wp.array(dtype=wp.int32),
    distances: wp.array(dtype=real),
):
    """Points within `radius` of each sub-triangle from place starts[triangle] on, and their distances, m."""
    triangle = wp.tid()
    centre, size = bounding_ball(surface, triangle)
    place = starts[triangle]
    for point in wp.hash_grid_query(grid, centre, radius + size):
        x = positions[point]
        if wp.length(x - centre) <= radius + size and may_touch(ownership, point, triangle):
            distance = distance_to(surface, triangle, x)
            if distance <= radius:
                points[place] = point
                distances[place] = distance
                place += 1


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
