"""Which edges are near each other: the launches of the broad phase for edges."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import edge_search
from warp_origami.kernels.precision import real, vec3


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
    """Finds all pairs of edges within a radius that share no vertex, on a hash grid over parts of the edges.

    Arrays that are too small grow and the search is repeated: no pair is ever dropped.

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
        self._middles = wp.zeros(self._count, dtype=vec3, device=device)
        self._sizes = wp.zeros(self._count, dtype=real, device=device)
        self._allocate(4 * self._count)
        dimension = int(np.clip(2 ** np.ceil(np.log2(2.0 * max(self._count, 1) ** (1 / 3))), 16, 128))
        self._grid = wp.HashGrid(dimension, dimension, dimension, device=device, dtype=real)

    def within(self, controls: wp.array, radius: float) -> NearEdges:
        """All pairs of edges with parts that may be within `radius` (m) of each other."""
        self._launch(edge_search.place_parts, [controls, self.divisions], [self._middles, self._sizes])
        sizes = self._sizes.numpy()
        largest = float(sizes.max(initial=0.0))
        self._grid.build(self._middles, radius + 2.0 * float(np.median(sizes)))
        inputs = [wp.uint64(self._grid.id), self._middles, self._sizes, real(largest), real(radius)]
        inputs += [controls, self._vertices, self.divisions]
        while True:
            self._found.count.zero_()
            self._launch(edge_search.find_part_pairs, inputs, [self._found])
            total = int(self._found.count.numpy()[0])
            if total <= self._found.first.shape[0]:
                break
            self._allocate(total + total // 4)
        found = (self._found.first, self._found.second, self._found.distances)
        return self._grouped(*(array[:total].numpy() for array in found))

    def _grouped(self, first: np.ndarray, second: np.ndarray, distances: np.ndarray) -> NearEdges:
        """Pairs of parts in whatever order as pairs of edges."""
        k = self.divisions
        keys = (first // k).astype(np.int64) * self.edge_count + second // k
        candidates = (first % k) * k + second % k
        pairs, pair = np.unique(keys, return_inverse=True)
        nearest = np.full(len(pairs), np.inf)
        np.minimum.at(nearest, pair, distances)
        by_distance = np.lexsort((pairs, nearest))
        rank = np.empty_like(by_distance)
        rank[by_distance] = np.arange(len(pairs))
        order = np.lexsort((candidates, rank[pair]))
        pairs = pairs[by_distance]
        sizes = np.bincount(rank[pair], minlength=len(pairs))
        return NearEdges(
            keys=pairs,
            first=(pairs // self.edge_count).astype(np.int32),
            second=(pairs % self.edge_count).astype(np.int32),
            starts=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
            candidates=candidates[order].astype(np.int32),
            distances=nearest[by_distance],
        )

    def _allocate(self, capacity: int) -> None:
        """Room for so many pairs of parts; a search that finds more is repeated with more room."""
        self._found = edge_search.PartPairs()
        self._found.count = wp.zeros(1, dtype=wp.int32, device=self._device)
        self._found.first = wp.empty(capacity, dtype=wp.int32, device=self._device)
        self._found.second = wp.empty(capacity, dtype=wp.int32, device=self._device)
        self._found.distances = wp.empty(capacity, dtype=real, device=self._device)

    def _launch(self, kernel: wp.Kernel, inputs: list, outputs: list) -> None:
        wp.launch(kernel, dim=self._count, inputs=inputs, outputs=outputs, device=self._device)
