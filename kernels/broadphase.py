"""Broad phase: pairs of boxes that overlap, counted, then filled; points near sub-triangles among them.

    candidates = { (p, t) : distance(x_p, t) <= radius }

Exact: the first pass counts what every query finds, the second writes it to where it belongs. Neither depends on the
order of threads.
"""

import warp as wp

from .box_grid import BoxGrid, BoxQueries, visit_boxes
from .closest_point import Surface, box_distance_squared, normal_of
from .ownership import Ownership, distance_to, may_touch
from .precision import real, vec3

FAR = wp.constant(real(wp.inf))


@wp.kernel(enable_backward=False)
def count_overlaps(
    grid: BoxGrid,
    queries: BoxQueries,
    nothing: wp.array(dtype=wp.int32),
    # out
    counts: wp.array(dtype=wp.int32),
):
    """How many boxes each query overlaps; `nothing` is an array without elements."""
    i = wp.tid()
    counts[i] = visit_boxes(grid, queries, i, 0, nothing)


@wp.kernel(enable_backward=False)
def fill_overlaps(
    grid: BoxGrid,
    queries: BoxQueries,
    first: int,
    starts: wp.array(dtype=wp.int32),
    # out
    found: wp.array(dtype=wp.int32),
    items: wp.array(dtype=wp.int32),
):
    """Queries from `first` on and the boxes that they overlap; `starts`: place of the first pair of each query."""
    i = wp.tid()
    count = visit_boxes(grid, queries, first + i, starts[i], items)
    for k in range(count):
        found[starts[i] + k] = first + i


@wp.func
def candidate_distance(surface: Surface, ownership: Ownership, triangle: int, point: int, x: vec3, radius: real):
    """Distance of a point from a sub-triangle, m, or FAR where it is above `radius` or they may not touch."""
    a = surface.points[surface.triangles[triangle, 0]]
    b = surface.points[surface.triangles[triangle, 1]]
    c = surface.points[surface.triangles[triangle, 2]]
    from_plane = wp.dot(x - a, normal_of(surface, triangle))
    if wp.abs(from_plane) > radius or box_distance_squared(x, a, b, c) > radius * radius:
        return FAR
    if not may_touch(ownership, point, triangle):
        return FAR
    distance = distance_to(surface, triangle, x)
    if distance > radius:
        return FAR
    return distance


@wp.kernel(enable_backward=False)
def find_candidates(
    points: wp.array(dtype=wp.int32),
    triangles: wp.array(dtype=wp.int32),
    positions: wp.array(dtype=vec3),
    radius: real,
    surface: Surface,
    ownership: Ownership,
    # out
    distances: wp.array(dtype=real),
):
    """Distance of points[i] from triangles[i], FAR where it is above `radius` or they may not touch."""
    i = wp.tid()
    distances[i] = candidate_distance(surface, ownership, triangles[i], points[i], positions[points[i]], radius)
