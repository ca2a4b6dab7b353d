"""Features that are near each other, found once for many steps."""

from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import swept_search
from warp_origami.kernels.precision import real, vec3
from warp_origami.kernels.swept import EDGE_EDGE, VERTEX_TRIANGLE, Features

from .box_pairs import Part, joined, near_pairs
from .features import FeatureMesh


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

    Where the mesh has islands, all pairs of each are kept and looked at.

    Attributes:
        features: for launches.
        typical_length: median length of the edges in the flat sheet, m.
    """

    def __init__(self, mesh: FeatureMesh, device: str) -> None:
        self._device = device
        self.features = Features()
        self.features.triangles = wp.array(mesh.triangles, dtype=wp.int32, device=device)
        self.features.edges = wp.array(mesh.edges, dtype=wp.int32, device=device)
        self.features.groups = wp.array(mesh.groups, dtype=wp.int32, device=device)
        self._corners = np.ascontiguousarray(mesh.triangles.T)
        self._ends = np.ascontiguousarray(mesh.edges.T)
        self._among = None if mesh.islands is None else _pairs_in_islands(mesh)
        self.typical_length = float(np.median(mesh.edge_lengths))

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

        vertices, triangles, apart = self._vertices_near_triangles(positions, points, radius, distances_by)
        one, other, between = self._edges_near_edges(positions, radius, distances_by)

        kinds = np.repeat(np.array([VERTEX_TRIANGLE, EDGE_EDGE], dtype=np.int32), [len(apart), len(between)])
        firsts = np.concatenate([vertices, np.maximum(one, other)])
        seconds = np.concatenate([triangles, np.minimum(one, other)])
        distances = np.concatenate([apart, between])
        order = np.lexsort((seconds, firsts, kinds, distances))  # whatever order they were found in
        kinds, firsts, seconds, distances = (array[order] for array in (kinds, firsts, seconds, distances))
        arrays = tuple(wp.array(array, dtype=wp.int32, device=self._device) for array in (kinds, firsts, seconds))
        return NearFeatures(positions, radius, kinds, firsts, seconds, distances, arrays)

    def _vertices_near_triangles(self, positions: np.ndarray, points: wp.array, radius: float, distances_by) -> Part:
        near = distances_by(swept_search.find_vertices_near_triangles)
        if self._among is not None:
            return self._near_ones(self._among[0], radius, near)
        a, b, c = (positions[corner] for corner in self._corners)
        boxes = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        return joined(near_pairs(points, points, boxes, radius, near))

    def _edges_near_edges(self, positions: np.ndarray, radius: float, distances_by) -> Part:
        near = distances_by(swept_search.find_edges_near_edges)
        if self._among is not None:
            return self._near_ones(self._among[1], radius, near)
        a, b = (positions[end] for end in self._ends)
        boxes = np.minimum(a, b), np.maximum(a, b)
        low, high = (wp.array(corner, dtype=vec3, device=self._device) for corner in boxes)
        return joined(near_pairs(low, high, boxes, radius, near, among=True))

    def _near_ones(self, pairs: tuple[np.ndarray, np.ndarray], radius: float, distances_of) -> Part:
        """Those of given pairs that are closer than `radius`."""
        firsts, seconds = pairs
        arrays = (wp.array(numbers, dtype=wp.int32, device=self._device) for numbers in pairs)
        distances = distances_of(*arrays).numpy()
        near = np.flatnonzero(distances <= radius)
        return firsts[near], seconds[near], distances[near]


def _pairs_in_islands(mesh: FeatureMesh) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """All pairs of a vertex and a triangle, and of two edges, of one island."""
    of_triangles, of_edges = mesh.islands[mesh.triangles[:, 0]], mesh.islands[mesh.edges[:, 0]]
    first, second = _equal_labels(of_edges, of_edges)
    return _equal_labels(mesh.islands, of_triangles), (first[first > second], second[first > second])


def _equal_labels(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers i, j (int32) of all pairs with one[i] == other[j]."""
    count = max(one.max(), other.max()) + 1
    rows, columns = (
        csr_matrix((np.ones(len(labels), dtype=np.int32), (np.arange(len(labels)), labels)), shape=(len(labels), count))
        for labels in (one, other)
    )
    pairs = (rows @ columns.T).tocoo()
    return pairs.row.astype(np.int32), pairs.col.astype(np.int32)
