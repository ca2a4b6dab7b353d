"""Which of many pairs of plane features can be near by now, from their distances in one state and the motion since.

    |d(x) - d(x_0)| <= 2 max |x - x_0|      whichever points are closest, a translation of all of them left out

In Newton's iteration states lie close to each other, and of thousands of pairs that are near enough to be looked at
some tens can touch. A pair whose distance is sure to exceed its limit is not evaluated; as it would have had no force,
the result does not depend on where the bounds were taken. The corners of plane features are all that moves them; a
cubic surface moves farther between its points.
"""

import numpy as np

from .swept import relative_motion

RENEWED_SHARE = 0.1
"""Part of the pairs that may be left before bounds should be taken anew."""

PER_MOTION = 2.002
"""Change of a distance over the largest motion of a point, at most: 2, and a little for round-off."""


class DistanceBounds:
    """Lower bounds of the distances of n pairs.

    Args:
        stale: change of distances, m, below which bounds are never taken anew.
    """

    def __init__(self, stale: float) -> None:
        self._stale = stale

    def take(self, positions: np.ndarray, distances: np.ndarray) -> None:
        """Takes the distances (n,), m, where the points are at `positions` (np, 3)."""
        self._positions, self._distances = positions, distances

    def within(self, positions: np.ndarray, limits: np.ndarray) -> np.ndarray | None:
        """Pairs whose distance at `positions` can be as small as their limit (n,), m; None where those of the state
        that bounds come from are of little use, and new ones are to be taken."""
        change = change_of_distances(self._positions, positions)
        which = np.flatnonzero(self._distances <= limits + change)
        return which if change <= self._stale or len(which) <= RENEWED_SHARE * len(self._distances) else None


def change_of_distances(before: np.ndarray, after: np.ndarray) -> float:
    """How much a distance can change from one state of the points (np, 3) to another, m."""
    return PER_MOTION * relative_motion(before, after)
