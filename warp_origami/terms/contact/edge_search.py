"""Which edges are near each other: the launches of the broad phase for edges."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import edge_search
from warp_origami.kernels.precision import real, vec3

from .box_pairs import joined, near_pairs


@dataclass(frozen=True)
class NearEdges:
    """Pairs of edges in the order of the least distance that they can have.

    Attributes:
        keys: (n,) first * edges + second: the name of the pair over the whole run.
        first, second: (n,) int32 edges, first < second.
        starts: (n + 1,) int32 first candidate of each pair.
        candidates: (m,) int32 parts near each other, i * divisions + j, increasing within a pair.
        distances: (n,) bound from below of the distance, m, increasing.
    """

    keys: np.ndarray
    first: np.ndarray
    second: np.ndarray
    starts: np.ndarray
    candidates: np.ndarray
    distances: np.ndarray


class EdgeSearch:
    """Finds all pairs of edges within a radius that share no vertex: boxes around parts of the edges that overlap.

    Args:
        vertices: (k, 2) ends of the edges.
        divisions: parts of each edge.

    Attributes:
        speed: the bound of distance of two parts falls by at most so many times the way of a control point: their
            chords move by 1 each, and their bulges, |r''| / (8 divisions^2), by 24 / 8 / divisions^2 each.
    """

    def __init__(self, vertices: np.ndarray, divisions: int, device: str):
        self.divisions, self._device = divisions, device
        self.edge_count = len(vertices)
        self._count = self.edge_count * divisions
        self.speed = 2.0 + 6.0 / divisions**2
        self._vertices = wp.array(vertices, dtype=wp.int32, device=device)
        self._low, self._high = (wp.zeros(self._count, dtype=vec3, device=device) for _ in range(2))

    def within(self, controls: wp.array, radius: float) -> NearEdges:
        """All pairs of edges with parts that may be within `radius` (m) of each other."""
        wp.launch(
            edge_search.place_parts,
            dim=self._count,
            inputs=[controls, self.divisions],
            outputs=[self._low, self._high],
            device=self._device,
        )

        def distances_of(first: wp.array, second: wp.array) -> wp.array:
            distances = wp.empty(len(first), dtype=real, device=self._device)
            inputs = [first, second, controls, self._vertices, self.divisions]
            wp.launch(
                edge_search.find_part_pairs, dim=len(first), inputs=inputs, outputs=[distances], device=self._device
            )
            return distances

        boxes = self._low.numpy(), self._high.numpy()
        one, other, distances = joined(near_pairs(self._low, self._high, boxes, radius, distances_of, among=True))
        return self._grouped(np.minimum(one, other), np.maximum(one, other), distances)

    def _grouped(self, first: np.ndarray, second: np.ndarray, distances: np.ndarray) -> NearEdges:
        """Pairs of parts in whatever order as pairs of edges."""
        k = self.divisions
        keys = (first // k).astype(np.int64) * self.edge_count + second // k
        candidates = (first % k) * k + second % k
        order = np.argsort(keys * k**2 + candidates)
        keys, candidates, distances = keys[order], candidates[order], distances[order]
        starts = np.flatnonzero(np.diff(keys, prepend=-1))
        sizes = np.diff(starts, append=len(keys))
        nearest = np.minimum.reduceat(distances, starts) if len(starts) else np.zeros(0)
        by_distance = np.argsort(nearest, kind="stable")  # pairs equally far apart stay in the order of their names
        pairs, starts, sizes = keys[starts][by_distance], starts[by_distance], sizes[by_distance]
        ends = np.concatenate([[0], np.cumsum(sizes)])
        of_pair = np.arange(len(keys)) + np.repeat(starts - ends[:-1], sizes)
        return NearEdges(
            keys=pairs,
            first=(pairs // self.edge_count).astype(np.int32),
            second=(pairs % self.edge_count).astype(np.int32),
            starts=ends.astype(np.int32),
            candidates=candidates[of_pair].astype(np.int32),
            distances=nearest[by_distance],
        )
