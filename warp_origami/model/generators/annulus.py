"""A ring-shaped sheet without creases: every circle has the same number of edges, turned by half from ring to ring."""

import numpy as np

from ...errors import InputError
from ..pattern import Pattern
from ..ring_mesh import check_rings, ring_pattern


def annulus(
    inner_radius: float,
    outer_radius: float,
    rings: int,
    segments: int | None = None,
    grading: float = 1.0,
    centre: tuple[float, float] = (0.0, 0.0),
) -> Pattern:
    """Annulus in rings of isosceles triangles, which look alike from every segment.

    The outer rim has a vertex in the direction of x; the inner one has for an even number of rings, and the middle of
    an edge for an odd one.

    Args:
        inner_radius, outer_radius: m.
        rings: rings of triangles.
        segments: edges of every circle; by default those that make edges halfway between the rims as long as the mean
            width of the rings, in multiples of 8.
        grading: width of the outermost ring over that of the innermost one, the widths between being a geometric
            sequence: 1 is uniform, less is finer at the outer rim, more is finer at the inner one. With
            (outer_radius / inner_radius)^((rings - 1) / rings) the triangles of all rings are similar.
        centre: m.

    Raises:
        InputError: an impossible value, or rings too thin for so few segments.
    """
    check_rings({"inner_radius": inner_radius, "outer_radius": outer_radius}, rings, segments, grading, centre)
    if not inner_radius < outer_radius:
        raise InputError("pattern.inner_radius", inner_radius, f"less than the outer radius {outer_radius} (m)")
    segments = default_segments(inner_radius, outer_radius, rings) if segments is None else segments
    return ring_pattern(inner_radius, outer_radius, np.full(rings + 1, segments), grading, centre)


def default_segments(inner_radius: float, outer_radius: float, rings: int) -> int:
    """Edges of every circle, see `annulus`."""
    edges = np.pi * (inner_radius + outer_radius) * rings / (outer_radius - inner_radius)
    return max(8, 8 * round(edges / 8))
