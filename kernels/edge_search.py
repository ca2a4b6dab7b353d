"""Which edges may touch each other: hash grid over the chords of their parts.

    candidates = { (i, j), i < j : distance of chords - bulge_i - bulge_j <= radius }

Every edge is split into equal parts; the bulge is a bound of how far the curve of a part lies from its chord. Exact:
the pairs are counted whether or not the arrays hold them all; if not, larger ones are filled anew. Edges that share a
vertex are no pair.
"""

import warp as wp

from .edge_curve import closest_on_segments, curve_point
from .precision import real, vec2, vec3

EIGHTH = wp.constant(real(0.125))


@wp.struct
class Part:
    """A part of a curve: chord from `start` along `along` (m) and the bulge of the curve over it, m."""

    start: vec3
    along: vec3
    bulge: real


@wp.struct
class PartPairs:
    """Found pairs of parts in any order, the least distance their curves can have (m), and (1,) how many there are."""

    count: wp.array(dtype=wp.int32)
    first: wp.array(dtype=wp.int32)
    second: wp.array(dtype=wp.int32)
    distances: wp.array(dtype=real)


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
    middles: wp.array(dtype=vec3),
    sizes: wp.array(dtype=real),
):
    """Middle of each part's chord and the distance from there within which its curve lies."""
    i = wp.tid()
    p = part_of(controls, i // divisions, i % divisions, divisions)
    middles[i] = p.start + real(0.5) * p.along
    sizes[i] = real(0.5) * wp.length(p.along) + p.bulge


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
    grid: wp.uint64,
    middles: wp.array(dtype=vec3),
    sizes: wp.array(dtype=real),
    largest: real,
    radius: real,
    controls: wp.array(dtype=vec3),
    vertices: wp.array2d(dtype=wp.int32),
    divisions: int,
    # out
    found: PartPairs,
):
    """Pairs of parts within `radius` of each other; counts on beyond the arrays' size, so that the caller can tell."""
    i = wp.tid()
    edge = i // divisions
    part = part_of(controls, edge, i % divisions, divisions)
    for j in wp.hash_grid_query(grid, middles[i], radius + sizes[i] + largest):
        if j > i and wp.length(middles[j] - middles[i]) <= radius + sizes[i] + sizes[j]:
            if not share_vertex(vertices, edge, j // divisions):
                other = part_of(controls, j // divisions, j % divisions, divisions)
                at = closest_on_segments(part.start, part.along, other.start, other.along, real(0.5))
                distance = least_distance(part, other, at)
                if distance <= radius:
                    place = wp.atomic_add(found.count, 0, 1)
                    if place < found.first.shape[0]:
                        found.first[place] = i
                        found.second[place] = j
                        found.distances[place] = distance
