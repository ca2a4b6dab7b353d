"""Features of the sub-mesh that are near each other, found once for many steps."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import swept_search
from warp_origami.kernels.precision import real, vec3
from warp_origami.kernels.swept import EDGE_EDGE, VERTEX_TRIANGLE, Features
from warp_origami.model.submesh import Submesh

from .box_pairs import joined, near_pairs
from .features import SweptFeatures


@dataclass(frozen=True)
class NearFeatures:
    """Pairs of features that share no point, by increasing distance, then by kind and number.

    Attributes:
        positions: (np, 3) of the points for which they were found, m.
        radius: all pairs up to this distance are there, m.
        kinds: (n,) int32 VERTEX_TRIANGLE or EDGE_EDGE of kernels.swept.
        firsts, seconds: (n,) int32 point and triangle, or the two edges, the first of larger number.
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
        self._device = device
        self.features = Features()
        self.features.triangles = wp.array(features.triangles, dtype=wp.int32, device=device)
        self.features.edges = wp.array(features.edges, dtype=wp.int32, device=device)
        self.features.groups = wp.array(features.groups, dtype=wp.int32, device=device)
        self._corners = np.ascontiguousarray(features.triangles.T)
        self._ends = np.ascontiguousarray(features.edges.T)
        ends = submesh.flat[features.edges]
        self.typical_length = float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))

    def within(self, positions: np.ndarray, radius: float) -> NearFeatures:
        """All pairs closer than `radius` (m) where the points are at `positions` (np, 3)."""
        points = wp.array(positions, dtype=vec3, device=self._device)

        def distances_by(kernel: wp.Kernel):
            def distances_of(firsts: wp.array, seconds: wp.array) -> wp.array:
                distances = wp.empty(len(firsts), dtype=real, device=self._device)
                inputs = [firsts, seconds, points, real(radius), self.features]
                wp.launch(kernel, dim=len(firsts), inputs=inputs, outputs=[distances], device=self._device)
                return distances

            return distances_of

        a, b, c = (positions[corner] for corner in self._corners)
        boxes = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        near = distances_by(swept_search.find_vertices_near_triangles)
        vertices, triangles, apart = joined(near_pairs(points, points, boxes, radius, near))

        a, b = (positions[end] for end in self._ends)
        boxes = np.minimum(a, b), np.maximum(a, b)
        low, high = (wp.array(corner, dtype=vec3, device=self._device) for corner in boxes)
        near = distances_by(swept_search.find_edges_near_edges)
        one, other, between = joined(near_pairs(low, high, boxes, radius, near, among=True))

        kinds = np.repeat(np.array([VERTEX_TRIANGLE, EDGE_EDGE], dtype=np.int32), [len(apart), len(between)])
        firsts = np.concatenate([vertices, np.maximum(one, other)])
        seconds = np.concatenate([triangles, np.minimum(one, other)])
        distances = np.concatenate([apart, between])
        order = np.lexsort((seconds, firsts, kinds, distances))  # whatever order they were found in
        kinds, firsts, seconds, distances = (array[order] for array in (kinds, firsts, seconds, distances))
        arrays = tuple(wp.array(array, dtype=wp.int32, device=self._device) for array in (kinds, firsts, seconds))
        return NearFeatures(positions, radius, kinds, firsts, seconds, distances, arrays)
