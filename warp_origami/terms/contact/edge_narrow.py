"""Closest points and gaps of given pairs of edges: the launches of the edge-to-edge kernel."""

import numpy as np
import warp as wp

from warp_origami.kernels import edge_edge
from warp_origami.kernels.precision import real, vec2, vec3

from ..buffers import Buffer
from ..launches import Launch
from .edge_search import NearEdges

FIELDS = {
    "parameters": vec2,
    "sides": wp.int32,
    **dict.fromkeys(("normals", "pulls", "slopes1", "slopes2", "bends1", "bends2"), vec3),
    **dict.fromkeys(("gaps", "weights", "angle_weights", "heights", "distances"), real),
}


GRAIN = 300
"""Pairs of edges that are worth a thread: half a microsecond each and more."""


class EdgeNarrow:
    """Evaluates pairs of edges at the current control points, only those that can be near by now.

    Every candidate has a place for one pair of closest points.

    Args:
        near: pairs, in the order of their distance.
        thickness: (pairs,) distance at which each pair begins to press, m.
        controls: control points at launch.
        zones: part of each edge at its ends where the force fades.
        divisions: parts of each edge.
        reach: distance beyond which edges have no gap, m.

    Attributes:
        near: the pairs.
        keys, first, second, thickness: pair, edges and thickness of each place.
        evaluated: number of places that the last launch has evaluated; edges of all others are farther than the reach.
        gaps, weights, ...: buffers, see edge_edge.EdgeContacts.
    """

    def __init__(
        self, near: NearEdges, thickness: np.ndarray, controls: wp.array, zones: wp.array, divisions: int, reach: float
    ):
        device = self._device = controls.device
        self.near, self._reach = near, reach
        sizes = np.diff(near.starts)
        self.keys, self.first, self.second = (np.repeat(a, sizes) for a in (near.keys, near.first, near.second))
        self.evaluated = 0

        self._known_starts, self._known_ends = (Buffer(len(near.keys), wp.int32, device) for _ in range(2))
        self._pairs = edge_edge.EdgePairs()
        self._pairs.first = wp.array(near.first, dtype=wp.int32, device=device)
        self._pairs.second = wp.array(near.second, dtype=wp.int32, device=device)
        self._pairs.starts = wp.array(near.starts[:-1], dtype=wp.int32, device=device)
        self._pairs.ends = wp.array(near.starts[1:], dtype=wp.int32, device=device)
        self._pairs.candidates = wp.array(near.candidates, dtype=wp.int32, device=device)
        self._thickness = Buffer(len(near.keys), real, device)
        self._pairs.thickness = self._thickness.array
        self.set_thickness(thickness)
        self._pairs.known_starts, self._pairs.known_ends = self._known_starts.array, self._known_ends.array
        self._contacts = edge_edge.EdgeContacts()
        for name, kind in FIELDS.items():
            buffer = Buffer(len(self.keys), kind, device)
            setattr(self, name, buffer)
            setattr(self._contacts, name, buffer.array)
        self._inputs = [controls, zones, divisions, real(reach), self._pairs]
        self._command: Launch | None = None

    def set_thickness(self, thickness: np.ndarray) -> None:
        """Takes another thickness of the pairs, (pairs,)."""
        self._thickness.write(thickness)
        self.thickness = np.repeat(thickness, np.diff(self.near.starts))

    def know(self, keys: np.ndarray) -> None:
        """Takes the pairs (sorted) of the closest points known from the accepted state."""
        for buffer, side in ((self._known_starts, "left"), (self._known_ends, "right")):
            buffer.write(np.searchsorted(keys, self.near.keys, side=side).astype(np.int32))

    def launch(self, approach: float, known: edge_edge.Known) -> None:
        """Evaluates all pairs within reach; `approach` (m): how much closer any may have come since they were found."""
        count = int(np.searchsorted(self.near.distances, self._reach + approach, side="right"))
        self.evaluated = int(self.near.starts[count])
        if self._command is None:
            inputs = [*self._inputs, known]
            self._command = Launch(edge_edge.edge_contacts, count, inputs, [self._contacts], self._device, GRAIN)
        self._command.set_param("known", known)
        self._command.set_dim(count)
        self._command.launch()

    def places(self, name: str, below: float, above: float = -np.inf) -> np.ndarray:
        """Evaluated places where a field lies between two bounds, in an order that does not depend on the search."""
        values = getattr(self, name).read()[: self.evaluated]
        at = np.flatnonzero((values > above) & (values < below))
        s, t = self.parameters.read()[at].T
        return at[np.lexsort((t, s, self.keys[at]))]

    def least_distances(self) -> tuple[np.ndarray, np.ndarray]:
        """Evaluated pairs, sorted, and their least distance (m), also at ends; large where it is beyond the reach."""
        keys, inverse = np.unique(self.keys[: self.evaluated], return_inverse=True)
        least = np.full(len(keys), np.inf)
        np.minimum.at(least, inverse, self.distances.read()[: self.evaluated])
        return keys, least
