"""Which of many pairs can be near by now, from their distances in one state and the motion since.

    |d(x) - d(x_0)| <= 2 max |x - x_0|      of a pair, whichever points are closest, a common translation left out

In Newton's iteration states lie close to each other, and of thousands of pairs that are near enough to be looked at
some tens can touch. A pair whose distance is sure to exceed its limit is not evaluated; as it would have had no force,
the result does not depend on where the bounds were taken.
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
        per_motion: change of a distance over the largest motion of a point, at most.
    """

    def __init__(self, stale: float, per_motion: float = PER_MOTION) -> None:
        self._stale, self._per_motion = stale, per_motion
        self._positions: np.ndarray | None = None

    def forget(self) -> None:
        """Takes nothing for known: the pairs are others."""
        self._positions = None

    def take(self, positions: np.ndarray, bounds: np.ndarray) -> None:
        """Takes lower bounds (n,), m, where the points are at `positions` (np, 3)."""
        self._positions, self._bounds = positions, bounds

    def change(self, before: np.ndarray, after: np.ndarray) -> float:
        """How much a distance can change from one state of the points to another, m."""
        return self._per_motion * relative_motion(before, after)

    def within(self, positions: np.ndarray, limits: np.ndarray) -> np.ndarray | None:
        """Pairs whose distance at `positions` can be as small as their limit (n,), m; None if bounds are to be taken
        there: they are not known, or are of little use."""
        if self._positions is None:
            return None
        change = self.change(self._positions, positions)
        which = np.flatnonzero(self._bounds <= limits + change)
        return which if change <= self._stale or len(which) <= RENEWED_SHARE * len(self._bounds) else None
