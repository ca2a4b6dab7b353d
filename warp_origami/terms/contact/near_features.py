"""Features of the sub-mesh that are near each other, found once for many steps."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import swept_search
from warp_origami.kernels.precision import real, vec3
from warp_origami.kernels.swept import Features
from warp_origami.model.submesh import Submesh

from .features import SweptFeatures


@dataclass(frozen=True)
class NearFeatures:
    """Pairs of features that share no point, by increasing distance, then by kind and number.

    Attributes:
        positions: (np, 3) of the points for which they were found, m.
        radius: all pairs up to this distance are there, m.
        kinds, firsts, seconds: (n,) int32, see kernels.swept_search.NearPairs.
        distances: (n,) m; zero or less where they touch.
        arrays: kinds, firsts and seconds on the device.
    """

    positions: np.ndarray
    radius: float
    kinds: np.ndarray
    firsts: np.ndarray
    seconds: np.ndarray
    distances: np.ndarray
    arrays: tuple[wp.array, wp.array, wp.array]


class FeatureSearch:
    """Finds all pairs of features within a radius; the cost is linear in their number and that of the pairs.

    Attributes:
        features: for launches.
        typical_length: median length of the edges in the flat sheet, m.
    """

    def __init__(self, submesh: Submesh, features: SweptFeatures, device: str) -> None:
        self._device, self._edges = device, features.edges
        self.features = Features()
        self.features.triangles = wp.array(features.triangles, dtype=wp.int32, device=device)
        self.features.edges = wp.array(features.edges, dtype=wp.int32, device=device)
        self.features.groups = wp.array(features.groups, dtype=wp.int32, device=device)
        self._triangle_count = len(features.triangles)
        ends = submesh.flat[features.edges]
        self.typical_length = float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))
        self._points_grid = _grid(len(submesh.flat), device)
        self._middles_grid = _grid(len(features.edges), device)
        self._allocate(1024)

    def within(self, positions: np.ndarray, radius: float) -> NearFeatures:
        """All pairs closer than `radius` (m) where the points are at `positions` (np, 3)."""
        ends = positions[self._edges]
        points = wp.array(positions, dtype=vec3, device=self._device)
        middles = wp.array(0.5 * (ends[:, 0] + ends[:, 1]), dtype=vec3, device=self._device)
        lengths = wp.array(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), dtype=real, device=self._device)
        cell = radius + self.typical_length
        self._points_grid.build(points, cell)
        self._middles_grid.build(middles, cell)
        point_inputs = [wp.uint64(self._points_grid.id), points, real(radius), self.features]
        edge_inputs = [wp.uint64(self._middles_grid.id), middles, lengths, points, real(radius), self.features]
        while True:
            self._found.count.zero_()
            self._launch(swept_search.find_vertices_near_triangles, self._triangle_count, point_inputs)
            self._launch(swept_search.find_edges_near_edges, len(self._edges), edge_inputs)
            total = int(self._found.count.numpy()[0])
            if total <= self._found.kinds.shape[0]:
                break
            self._allocate(total + total // 4)
        return self._sorted(positions, radius, total)

    def _sorted(self, positions: np.ndarray, radius: float, total: int) -> NearFeatures:
        found = self._found
        kinds, firsts, seconds, distances = (
            array[:total].numpy() for array in (found.kinds, found.firsts, found.seconds, found.distances)
        )
        order = np.lexsort((seconds, firsts, kinds, distances))  # whatever order they were found in
        kinds, firsts, seconds, distances = (array[order] for array in (kinds, firsts, seconds, distances))
        arrays = tuple(wp.array(array, dtype=wp.int32, device=self._device) for array in (kinds, firsts, seconds))
        return NearFeatures(positions, radius, kinds, firsts, seconds, distances, arrays)

    def _allocate(self, capacity: int) -> None:
        """Room for so many pairs; a search that finds more is repeated with more room."""
        self._found = swept_search.NearPairs()
        self._found.count = wp.zeros(1, dtype=wp.int32, device=self._device)
        self._found.kinds = wp.empty(capacity, dtype=wp.int32, device=self._device)
        self._found.firsts = wp.empty(capacity, dtype=wp.int32, device=self._device)
        self._found.seconds = wp.empty(capacity, dtype=wp.int32, device=self._device)
        self._found.distances = wp.empty(capacity, dtype=real, device=self._device)

    def _launch(self, kernel: wp.Kernel, dim: int, inputs: list) -> None:
        wp.launch(kernel, dim=dim, inputs=inputs, outputs=[self._found], device=self._device)


def _grid(count: int, device: str) -> wp.HashGrid:
    """Hash grid for so many points: about one cell per point in a cube."""
    dimension = int(np.clip(2 ** np.ceil(np.log2(2.0 * max(count, 1) ** (1 / 3))), 16, 128))
    return wp.HashGrid(dimension, dimension, dimension, device=device, dtype=real)
