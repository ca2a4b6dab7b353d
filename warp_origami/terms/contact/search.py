"""Which points may touch which layers: the launches of the broad phase."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import broadphase
from warp_origami.kernels.closest_point import Surface
from warp_origami.kernels.precision import real, vec3
from warp_origami.model.submesh import Submesh

from .points import ContactPoints


@dataclass(frozen=True)
class LayerPairs:
    """Pairs of a slave point and a layer (a face), ordered by point, then layer.

    Attributes:
        keys: (n,) point * faces + layer, increasing: the name of the pair over the whole run.
        points: (n,) slave point.
        layers: (n,) face.
        starts: (n + 1,) first candidate of each pair.
        candidates: sub-triangles of the layer near the point, increasing within a pair.
        distances: (n,) distance of the point from the candidates, m; zero where it is not known.
    """

    keys: np.ndarray
    points: np.ndarray
    layers: np.ndarray
    starts: np.ndarray
    candidates: np.ndarray
    distances: np.ndarray


class Search:
    """Finds all pairs of a slave point and a sub-triangle within a radius, on a hash grid over the slave points.

    The grid's cells follow the search radius and the size of the sub-triangles; every sub-triangle queries with its own
    size, so graded meshes are searched completely. Arrays that are too small grow and the search is repeated: no pair
    is ever dropped.

    Attributes:
        layer_count: number of faces.
    """

    def __init__(self, points: ContactPoints, submesh: Submesh, apart: float, device: str):
        self._device = device
        self.layer_count = int(submesh.triangle_faces.max()) + 1
        self._faces = submesh.triangle_faces
        order = np.argsort(submesh.triangle_faces, kind="stable")
        self._by_face = order
        self._rank = np.empty_like(order)
        self._rank[order] = np.arange(len(order))
        self._face_starts = np.searchsorted(submesh.triangle_faces[order], np.arange(self.layer_count + 1))

        side = [1, 2, 4]
        outer = submesh.outer_edges @ side + 8 * (submesh.outer_corners @ side)
        self._triangles = wp.array(submesh.triangles, dtype=wp.int32, device=device)
        self._outer = wp.array(outer.astype(np.int32), device=device)
        flat = np.pad(points.flat, ((0, 0), (0, 1)))
        self._ownership = broadphase.Ownership()
        self._ownership.faces = wp.array(submesh.triangle_faces, dtype=wp.int32, device=device)
        self._ownership.starts = wp.array(points.owner_starts, dtype=wp.int32, device=device)
        self._ownership.owners = wp.array(points.owners, dtype=wp.int32, device=device)
        self._ownership.points = wp.array(flat[points.node_count :], dtype=vec3, device=device)
        self._ownership.flat = self.surface(wp.array(flat[: points.node_count], dtype=vec3, device=device))
        self._ownership.apart = apart

        self._allocate(4 * points.slave_count)
        self._sub_size = float(np.sqrt(2.0 * np.median(submesh.triangle_areas)))
        # about one cell per point in a cube; fewer cells would only make the hash collide more often
        dimension = int(np.clip(2 ** np.ceil(np.log2(2.0 * max(points.slave_count, 1) ** (1 / 3))), 16, 128))
        self._grid = wp.HashGrid(dimension, dimension, dimension, device=device, dtype=real)

    def surface(self, nodes: wp.array) -> Surface:
        """The sub-triangulated surface with nodes at `nodes`, for launches."""
        surface = Surface()
        surface.points = nodes
        surface.triangles = self._triangles
        surface.outer = self._outer
        return surface

    def upload(self, positions: np.ndarray) -> wp.array:
        """(n, 3) positions on the device of the search."""
        return wp.array(positions, dtype=vec3, device=self._device)

    def key_of(self, points: np.ndarray, layers: np.ndarray) -> np.ndarray:
        """Names of pairs."""
        return points.astype(np.int64) * self.layer_count + layers

    def layers_of(self, keys: np.ndarray) -> np.ndarray:
        """Layers of pairs."""
        return keys % self.layer_count

    def within(self, slaves: wp.array, nodes: wp.array, radius: float) -> LayerPairs:
        """All pairs with a sub-triangle within `radius` (m) of the point."""
        self._grid.build(slaves, radius + self._sub_size)
        inputs = [wp.uint64(self._grid.id), slaves, real(radius), self.surface(nodes), self._ownership]
        while True:
            self._found.count.zero_()
            self._launch(broadphase.find_candidates, len(self._rank), inputs, [self._found])
            total = int(self._found.count.numpy()[0])
            if total <= self._found.points.shape[0]:
                break
            self._allocate(total + total // 4)
        found = (self._found.points, self._found.triangles, self._found.distances)
        return self.grouped(*(array[:total].numpy() for array in found))

    def _allocate(self, capacity: int) -> None:
        """Room for so many candidates; a search that finds more is repeated with more room."""
        self._found = broadphase.Candidates()
        self._found.count = wp.zeros(1, dtype=wp.int32, device=self._device)
        self._found.points = wp.empty(capacity, dtype=wp.int32, device=self._device)
        self._found.triangles = wp.empty(capacity, dtype=wp.int32, device=self._device)
        self._found.distances = wp.empty(capacity, dtype=real, device=self._device)

    def whole_layers(self, keys: np.ndarray) -> LayerPairs:
        """Given pairs with all sub-triangles of their layers that may touch the point; without distances."""
        points, layers = keys // self.layer_count, self.layers_of(keys)
        sizes = self._face_starts[layers + 1] - self._face_starts[layers]
        offsets = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        triangles = self._by_face[np.repeat(self._face_starts[layers], sizes) + offsets]
        points = np.repeat(points, sizes)
        allowed = wp.empty(len(points), dtype=wp.bool, device=self._device)
        inputs = [
            wp.array(points.astype(np.int32), device=self._device),
            wp.array(triangles.astype(np.int32), device=self._device),
            self._ownership,
        ]
        self._launch(broadphase.mark_allowed, len(points), inputs, [allowed])
        keep = allowed.numpy()
        return self.grouped(points[keep], triangles[keep], np.zeros(np.count_nonzero(keep)))

    def grouped(self, points: np.ndarray, triangles: np.ndarray, distances: np.ndarray) -> LayerPairs:
        """Candidates in whatever order as pairs of points and layers."""
        # one integer that sorts by point, layer, sub-triangle: the result does not depend on the order of the search
        order = np.argsort(points.astype(np.int64) * len(self._rank) + self._rank[triangles])
        points, triangles, distances = points[order], triangles[order], distances[order]
        keys = self.key_of(points, self._faces[triangles])
        first = np.flatnonzero(np.diff(keys, prepend=-1))
        nearest = np.minimum.reduceat(distances, first) if len(first) else np.zeros(0)
        return LayerPairs(
            keys=keys[first],
            points=points[first].astype(np.int32),
            layers=self._faces[triangles[first]],
            starts=np.append(first, len(keys)).astype(np.int32),
            candidates=triangles.astype(np.int32),
            distances=nearest,
        )

    def _launch(self, kernel: wp.Kernel, dim: int, inputs: list, outputs: list) -> None:
        wp.launch(kernel, dim=dim, inputs=inputs, outputs=outputs, device=self._device)
