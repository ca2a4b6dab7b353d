"""Triangles between concentric rings of equally spaced vertices.

Each edge of a ring is joined to the vertex of the neighbouring ring that is nearest in angle to the edge's middle. This
is symmetric about every line through the centre about which both rings are, unless an edge has its middle between two
vertices. Every second ring is therefore turned by half an edge where the number of its edges stays the same: the
triangles there are isosceles. The outermost ring has a vertex in the direction of x.

Numbers of edges and half turns are integers here, so that symmetry does not depend on round-off.
"""

import numpy as np

from ..errors import InputError
from .mesh import build_mesh, signed_areas
from .pattern import Pattern
from .rings import Rings

GRADINGS = (1e-3, 1e3)


def check_rings(radii: dict[str, float], rings: int, segments: int | None, grading: float, centre) -> None:
    """Raises InputError for values that no rings have; `radii` by their names in the scene file, m."""
    for key, value in radii.items():
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"pattern.{key}", value, "a length above 0 (m)")
    if rings < 1:
        raise InputError("pattern.rings", rings, "at least 1 ring")
    if segments is not None and segments < 3:
        raise InputError("pattern.segments", segments, "at least 3 segments")
    if not GRADINGS[0] <= grading <= GRADINGS[1]:
        raise InputError("pattern.grading", grading, "a ratio of widths from {:g} to {:g}".format(*GRADINGS))
    if rings == 1 and grading != 1:
        raise InputError("pattern.grading", grading, "1 for a single ring, which is its outermost and its innermost")
    if not np.isfinite(centre).all():
        raise InputError("pattern.centre", list(centre), "two finite coordinates (m)")


def ring_pattern(
    inner_radius: float, outer_radius: float, counts: np.ndarray, grading: float, centre: tuple[float, float]
) -> Pattern:
    """Pattern without creases, of rings from the inside outwards.

    Args:
        inner_radius, outer_radius: m. An inner radius of 0 is the pole of a disc, vertex 0.
        counts: edges of each circle, of the innermost first; 1 for a pole.
        grading: width of the outermost ring over that of the innermost one.
        centre: m.

    Raises:
        InputError: a ring is so thin that its triangles would cross the chords of the next.
    """
    ring_count = len(counts) - 1
    halves = _half_turns(counts)
    angles = [np.pi * (2 * np.arange(n) + h) / n for n, h in zip(counts, halves, strict=True)]
    rings = Rings(
        centre=centre,
        inner_radius=inner_radius,
        outer_radius=outer_radius,
        growth=0.0 if ring_count == 1 else np.log(grading) * ring_count / (ring_count - 1),
        levels=np.repeat(np.arange(ring_count + 1) / ring_count, counts),
        angles=np.concatenate(angles),
    )
    starts = np.concatenate([[0], np.cumsum(counts)])
    strips = [_strip(*((counts[k], halves[k], starts[k]) for k in (ring, ring + 1))) for ring in range(ring_count)]
    triangles = np.concatenate(strips)
    if signed_areas(rings.vertices, triangles).min() <= 0.0:
        raise InputError(
            "pattern.segments",
            int(counts[-1]),
            "more segments, fewer rings or a milder grading: the rings are thinner than the circles' chords are deep",
        )
    mesh = build_mesh(rings.vertices, triangles)
    return Pattern(mesh, None, np.arange(len(triangles)), np.zeros((0, 3), dtype=int), rings)


def _half_turns(counts: np.ndarray) -> np.ndarray:
    """Of each circle, 1 where its vertices are turned by half an edge."""
    halves = np.zeros(len(counts), dtype=int)
    for k in range(len(counts) - 2, -1, -1):
        common = np.gcd(counts[k], counts[k + 1])
        both_odd = (counts[k] // common) % 2 == 1 and (counts[k + 1] // common) % 2 == 1
        halves[k] = both_odd and not halves[k + 1]
    return halves


def _strip(inner: tuple[int, int, int], outer: tuple[int, int, int]) -> np.ndarray:
    """(k, 3) triangles between two circles, each given by its edges, its half turns and its first vertex."""
    (n, _, first), (m, _, start) = inner, outer
    j = np.arange(m)
    on_outer = np.stack([start + j, start + (j + 1) % m, first + _nearest(outer, inner, lower=True)], axis=1)
    if n == 1:
        return on_outer
    i = np.arange(n)
    on_inner = np.stack([first + (i + 1) % n, first + i, start + _nearest(inner, outer, lower=False)], axis=1)
    return np.concatenate([on_inner, on_outer])


def _nearest(ring: tuple[int, int, int], other: tuple[int, int, int], lower: bool) -> np.ndarray:
    """Vertex of the other circle nearest to the middle of each edge.

    Of two equally near ones the lower or the upper, in turn from quadrant to quadrant, which mirrors across the axes;
    the two circles have to be asked for different ones.
    """
    (n, half, _), (m, other_half, _) = ring, other
    middle = 2 * np.arange(n) + 1 + half  # in turns of 1 / (2 n)
    place = middle * m - other_half * n  # in edges of the other circle of 1 / (2 n)
    low, high = -((n - place) // (2 * n)), (n + place) // (2 * n)
    first_or_third = (2 * middle // n) % 2 == 0
    return np.where(first_or_third == lower, low, high) % m
