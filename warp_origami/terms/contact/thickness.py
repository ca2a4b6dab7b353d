"""Effective thickness of a pair of point and layer: min(thickness, c s, d).

s is the distance of the point from the layer in the flat sheet (infinite between separate sheets): at a crease, points
nearer to it than the thickness always lie "inside" the neighbour, so there only c s counts. d is the largest distance
that both have had in an accepted state: at first that of the stowed state, so that the start is free of contact force
whatever the layer distance, and none once they have been apart. It grows only where the pair does not touch, to a gap
of zero: that takes no energy, and within a step the contact force stays the gradient of one.
"""

from dataclasses import dataclass, replace

import numpy as np

from warp_origami.model.mesh import Mesh

from .by_name import look_up
from .points import ContactPoints
from .search import Search

CREASE_RATIO = 0.02
"""c: must lie below the smallest (distance / s) of the stowed state, or the crease rule alone would load it."""

ROUND_OFF = 1e-13
"""The stowed distance counts less by this part of the sheet's size, so that round-off cannot load the start."""


def reach_of(mesh: Mesh, thickness: float) -> float:
    """How deep an iterate may be through what it touches and still be pushed back to where it came from, m."""
    return thickness + max(2.0 * thickness, 0.03 * _typical_edge(mesh))


def margin_of(mesh: Mesh, thickness: float) -> float:
    """How much farther than the reach pairs are searched, m.

    It balances searching anew against launching on pairs that are still far.
    """
    return max(4.0 * thickness, 0.08 * _typical_edge(mesh))


def _typical_edge(mesh: Mesh) -> float:
    return float(np.sqrt(2.0 * mesh.areas.mean()))


@dataclass(frozen=True)
class ThicknessTable:
    """Pairs whose effective thickness is below the contact thickness; all others have the latter.

    Attributes:
        thickness: contact thickness, m.
        keys: (n,) sorted names of the pairs.
        values: (n,) effective thickness, m.
        by_crease: (n,) bool, limited by the crease rule (else by the start).
        caps: (n,) min(thickness, c s), m.
    """

    thickness: float
    keys: np.ndarray
    values: np.ndarray
    by_crease: np.ndarray
    caps: np.ndarray

    @property
    def limited_by_distance(self) -> bool:
        """Whether some pairs have never been as far apart as they may."""
        return bool((self.values < self.caps).any())

    def of(self, keys: np.ndarray) -> np.ndarray:
        """Effective thickness of pairs, m."""
        return look_up(keys, self.keys, self.values, otherwise=self.thickness)

    def limited(self, keys: np.ndarray, distances: np.ndarray) -> "ThicknessTable":
        """Table in which given pairs have at most their distance in the start, m, to the cubic surface."""
        names = np.union1d(self.keys, keys)
        limits = np.full(len(names), np.inf)
        limits[np.searchsorted(names, keys)] = (1.0 - 1e-9) * distances
        by_crease = np.zeros(len(names), dtype=bool)
        by_crease[np.searchsorted(names, self.keys)] = self.by_crease
        caps = np.full(len(names), self.thickness)
        caps[np.searchsorted(names, self.keys)] = self.caps
        values = self.of(names)
        return ThicknessTable(self.thickness, names, np.minimum(values, limits), by_crease & (values <= limits), caps)

    def regained(self, keys: np.ndarray, distances: np.ndarray) -> "ThicknessTable":
        """Table for the next step: given pairs have been at the distances, m, all others are farther than they may."""
        place = np.searchsorted(self.keys, keys)
        known = np.flatnonzero(place < len(self.keys))
        known = known[self.keys[place[known]] == keys[known]]
        at = place[known]
        values = self.caps.copy()
        values[at] = np.maximum(self.values[at], np.minimum(self.caps[at], distances[known]))
        return replace(self, values=values)


def build_thickness(search: Search, points: ContactPoints, start: np.ndarray, thickness: float) -> ThicknessTable:
    """Effective thickness with the points of the start (nodes, then slaves; (n, 3), m)."""
    flat = np.pad(points.flat, ((0, 0), (0, 1)))
    keys, limits = [], []
    below = ROUND_OFF * float(np.linalg.norm(np.ptp(points.flat, axis=0)))
    for positions, radius in ((flat, thickness / CREASE_RATIO), (start, thickness)):
        nodes, slaves = positions[: points.node_count], positions[points.node_count :]
        # in the flat sheet a point lies beside a layer, in the start it may lie over it
        name, distances = search.distances(search.upload(slaves), search.upload(nodes), radius, rims=positions is flat)
        limit = distances - below
        if positions is flat:
            own = points.owners[points.owner_starts[search.points_of(name)]]
            same_sheet = points.sheets[search.layers_of(name)] == points.sheets[own]
            name, limit = name[same_sheet], CREASE_RATIO * distances[same_sheet]
        keys.append(name)
        limits.append(limit)
    name, inverse = np.unique(np.concatenate(keys), return_inverse=True)
    table = np.full((2, len(name)), np.inf)
    for row, places in enumerate(np.split(inverse, [len(keys[0])])):
        table[row, places] = limits[row]
    values = np.minimum(table.min(axis=0), thickness)
    thin = values < thickness
    caps = np.minimum(table[0], thickness)
    return ThicknessTable(thickness, name[thin], values[thin], (table[0] <= table[1])[thin], caps[thin])
