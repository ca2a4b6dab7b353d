"""Which edges may touch each other: boxes around their parts, and the distance of their chords.

    candidates = { (i, j), i < j : distance of chords - bulge_i - bulge_j <= radius }

Every edge is split into equal parts; the bulge is a bound of how far the curve of a part lies from its chord. Edges
that share a vertex are no pair.
"""

import warp as wp

from .edge_curve import closest_on_segments, curve_point
from .precision import real, vec2, vec3

EIGHTH = wp.constant(real(0.125))
FAR = wp.constant(real(wp.inf))


@wp.struct
class Part:
    """A part of a curve: chord from `start` along `along` (m) and the bulge of the curve over it, m."""

    start: vec3
    along: vec3
    bulge: real


@wp.func
def part_of(controls: wp.array(dtype=vec3), curve: int, part: int, divisions: int):
    """Part `part` of `divisions`; a curve lies within max |r''| / (8 divisions^2) of the chord, and r'' is linear."""
    width = real(1.0) / real(divisions)
    a = curve_point(controls, curve, width * real(part))
    b = curve_point(controls, curve, width * real(part + 1))
    p = Part()
    p.start = a.r
    p.along = b.r - a.r
    p.bulge = EIGHTH * width * width * wp.max(wp.length(a.d2), wp.length(b.d2))
    return p


@wp.func
def least_distance(a: Part, b: Part, at: vec2):
    """Least distance that the curves of two parts can have, m; `at`: closest points of the chords."""
    apart = (b.start + at[1] * b.along) - (a.start + at[0] * a.along)
    return wp.length(apart) - a.bulge - b.bulge


@wp.kernel(enable_backward=False)
def place_parts(
    controls: wp.array(dtype=vec3),
    divisions: int,
    # out
    low: wp.array(dtype=vec3),
    high: wp.array(dtype=vec3),
):
    """Box around the curve of each part."""
    i = wp.tid()
    p = part_of(controls, i // divisions, i % divisions, divisions)
    bulge = vec3(p.bulge, p.bulge, p.bulge)
    low[i] = wp.min(p.start, p.start + p.along) - bulge
    high[i] = wp.max(p.start, p.start + p.along) + bulge


@wp.func
def share_vertex(vertices: wp.array2d(dtype=wp.int32), a: int, b: int):
    """Whether two edges have an end in common; true for an edge and itself."""
    for m in range(2):
        for n in range(2):
            if vertices[a, m] == vertices[b, n]:
                return True
    return False


@wp.kernel(enable_backward=False)
def find_part_pairs(
    first: wp.array(dtype=wp.int32),
    second: wp.array(dtype=wp.int32),
    controls: wp.array(dtype=vec3),
    vertices: wp.array2d(dtype=wp.int32),
    divisions: int,
    # out
    distances: wp.array(dtype=real),
):
    """Least distance (m) that the curves of parts first[n] and second[n] can have; infinite where they are no pair."""
    n = wp.tid()
    i = wp.min(first[n], second[n])
    j = wp.max(first[n], second[n])
    if share_vertex(vertices, i // divisions, j // divisions):
        distances[n] = FAR
        return
    a = part_of(controls, i // divisions, i % divisions, divisions)
    b = part_of(controls, j // divisions, j % divisions, divisions)
    distances[n] = least_distance(a, b, closest_on_segments(a.start, a.along, b.start, b.along, real(0.5)))
