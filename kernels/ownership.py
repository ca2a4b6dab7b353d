"""What belongs together in the flat sheet, and so cannot touch.

A point does not touch the face that it is part of, but for what lies at least `apart` away from it in the flat sheet: a
face that curls back on itself.
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
            x = ownership.points[point]
            # a corner that is near settles it for most
            if wp.length(x - ownership.flat.points[ownership.flat.triangles[triangle, 0]]) < ownership.apart:
                return False
            return distance_to(ownership.flat, triangle, x) >= ownership.apart
    return True
