"""A round sheet in rings, without creases: as many triangles around the pole as keep all of them well shaped."""

import numpy as np

from ..pattern import Pattern
from ..ring_mesh import check_rings, ring_pattern

SEGMENTS_PER_RING = 8
SYMMETRIES = (8, 6, 4, 2, 1)


def disc(
    radius: float,
    rings: int,
    segments: int | None = None,
    grading: float = 1.0,
    centre: tuple[float, float] = (0.0, 0.0),
) -> Pattern:
    """Disc in rings; vertex 0 is the centre, the rim has a vertex in the direction of x.

    The circles have edges in proportion to their number from the centre, as nearly as multiples of a symmetry allow:
    8 rings of 64 segments have 8, 16, ... 64. Constant numbers would make slivers around the pole.

    Args:
        radius: m.
        rings: rings of triangles, the innermost one a fan around the centre.
        segments: edges of the rim; 8 per ring by default. Multiples of 4 have vertices on both axes and are symmetric
            about them.
        grading: width of the outermost ring over that of the innermost one, the widths between being a geometric
            sequence: 1 is uniform, less is finer at the rim, more is finer at the centre.
        centre: m.

    Raises:
        InputError: an impossible value, or rings too thin for so few segments.
    """
    check_rings({"radius": radius}, rings, segments, grading, centre)
    segments = SEGMENTS_PER_RING * rings if segments is None else segments
    return ring_pattern(0.0, radius, edge_counts(rings, segments), grading, centre)


def edge_counts(rings: int, segments: int) -> np.ndarray:
    """(rings + 1,) edges of the circles from the centre (counted as 1) to the rim."""
    each, rest = divmod(segments, rings)
    exact = rest == 0 and each >= 4 and (each % 2 == 0 or segments % 2 == 1)
    symmetry = each if exact else next(s for s in SYMMETRIES if segments % s == 0)
    least = -(-min(6, segments) // symmetry)
    share = segments // symmetry
    counts = symmetry * np.maximum(np.round(share * np.arange(rings + 1) / rings).astype(int), min(least, share))
    counts[0] = 1
    return counts
