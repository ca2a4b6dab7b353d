"""What is known of pairs (slave point, layer) from the last accepted state, by their name.

A pair keeps the side on which it was there, which gives its gap (23) a sign; how far it was apart says whether it can
touch at all in the next state.
"""

from dataclasses import dataclass, replace

import numpy as np

from warp_origami.kernels.point_gap import FREE, UNKNOWN

from .by_name import look_up
from .narrow import NarrowPhase


@dataclass(frozen=True)
class AcceptedPairs:
    """Pairs of an accepted state.

    Attributes:
        q: (n, 3) the state.
        others_beyond: all pairs but those of near_keys were at least so far apart, m.
        keys: names of the pairs whose side is known, ascending.
        sides: of these.
        near_keys: names of the pairs whose distance is known, ascending.
        near_distances: least distances of their sub-triangles, m.
        forgotten: names of pairs that are free to be on either side until the next accepted state.
    """

    q: np.ndarray
    others_beyond: float
    keys: np.ndarray
    sides: np.ndarray
    near_keys: np.ndarray
    near_distances: np.ndarray
    forgotten: np.ndarray

    @classmethod
    def none(cls, q: np.ndarray, others_beyond: float) -> "AcceptedPairs":
        """Nothing is known of single pairs."""
        names = np.zeros(0, dtype=np.int64)
        return cls(q, others_beyond, names, np.zeros(0, dtype=np.int32), names, np.zeros(0), names)

    def sides_of(self, keys: np.ndarray) -> np.ndarray:
        """Sides of pairs, UNKNOWN where they were too far apart to be looked at."""
        sides = look_up(keys, self.keys, self.sides, otherwise=UNKNOWN)
        sides[np.isin(keys, self.forgotten)] = FREE
        return sides

    def distances_of(self, keys: np.ndarray) -> np.ndarray:
        """How far sub-triangles of pairs were apart at least, m."""
        return look_up(keys, self.near_keys, self.near_distances, otherwise=self.others_beyond)

    def without(self, keys: np.ndarray) -> "AcceptedPairs":
        """The same with the sides of these pairs forgotten."""
        return replace(self, forgotten=np.union1d(self.forgotten, keys))

    def with_sides(self, state: NarrowPhase, sides: np.ndarray) -> "AcceptedPairs":
        """With the sides of the pairs that were evaluated in this state."""
        known = state.sorted_by_key(np.flatnonzero(sides != UNKNOWN))
        return replace(self, keys=state.keys[known], sides=sides[known])

    def with_distances(self, state: NarrowPhase, least: np.ndarray) -> "AcceptedPairs":
        """With the distances (m) of the pairs, and what they were seen up to."""
        order = np.argsort(state.keys)
        return replace(self, near_keys=state.keys[order], near_distances=least[order], others_beyond=state.seen)
