"""Which points may touch which layers: the launches of the broad phase."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import broadphase
from warp_origami.kernels.closest_point import Surface
from warp_origami.kernels.ownership import Ownership
from warp_origami.kernels.precision import real, vec3
from warp_origami.model.submesh import Submesh

from .box_pairs import Part, joined, near_pairs
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
        distances: (n,) distance of the point from the nearest candidate, m.
        candidate_distances: distance of each candidate, m.
    """

    keys: np.ndarray
    points: np.ndarray
    layers: np.ndarray
    starts: np.ndarray
    candidates: np.ndarray
    distances: np.ndarray
    candidate_distances: np.ndarray


class Search:
    """Finds all pairs of a slave point and a sub-triangle within a radius: points look into a grid of sub-triangles.

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
        self._corners = np.ascontiguousarray(submesh.triangles.T)
        self._at_rim = submesh.outer_corners.any(axis=1)
        side = [1, 2, 4]
        outer = submesh.outer_edges @ side + 8 * (submesh.outer_corners @ side)
        self._triangles = wp.array(submesh.triangles, dtype=wp.int32, device=device)
        self._outer = wp.array(outer.astype(np.int32), device=device)
        flat = np.pad(points.flat, ((0, 0), (0, 1)))
        self._ownership = Ownership()
        self._ownership.faces = wp.array(submesh.triangle_faces, dtype=wp.int32, device=device)
        self._ownership.starts = wp.array(points.owner_starts, dtype=wp.int32, device=device)
        self._ownership.owners = wp.array(points.owners, dtype=wp.int32, device=device)
        self._ownership.points = wp.array(flat[points.node_count :], dtype=vec3, device=device)
        self._ownership.flat = self.surface(wp.array(flat[: points.node_count], dtype=vec3, device=device))
        self._ownership.apart = apart

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

    def points_of(self, keys: np.ndarray) -> np.ndarray:
        """Slave points of pairs."""
        return keys // self.layer_count

    def layers_of(self, keys: np.ndarray) -> np.ndarray:
        """Layers of pairs."""
        return keys % self.layer_count

    def within(self, slaves: wp.array, nodes: wp.array, radius: float) -> LayerPairs:
        """All pairs with a sub-triangle within `radius` (m) of the point."""
        return self.grouped(*joined(self._near(slaves, nodes, radius, self._by_face)))

    def distances(
        self, slaves: wp.array, nodes: wp.array, radius: float, rims: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """Names of all pairs within `radius` (m), increasing, and their distances, m.

        Args:
            rims: look at the sub-triangles along the outer boundary of every layer only, which are those nearest to
                points beside it.
        """
        members = self._by_face[self._at_rim[self._by_face]] if rims else self._by_face
        parts = [self.grouped(*part) for part in self._near(slaves, nodes, radius, members)]
        none = (np.zeros(0, dtype=np.int64), np.zeros(0))
        keys, distances = zip(none, *((part.keys, part.distances) for part in parts), strict=True)
        return np.concatenate(keys), np.concatenate(distances)

    def nearest(self, keys: np.ndarray, slaves: wp.array, nodes: wp.array, radius: float) -> LayerPairs:
        """Given pairs (names, increasing) with all sub-triangles of their layers that may be nearest to the point.

        They are those within `radius` (m) where it reaches the layer, else within the first of its doubles that does.
        """
        size = float(np.linalg.norm(np.ptp(slaves.numpy(), axis=0))) + radius
        parts, left = [], keys
        while len(left) and radius <= 2.0 * size:
            layers = np.zeros(self.layer_count, dtype=bool)
            layers[self.layers_of(left)] = True
            members = self._by_face[layers[self._faces[self._by_face]]]
            points, triangles, distances = joined(
                self._near(slaves, nodes, radius, members, np.unique(self.points_of(left)))
            )
            names = self.key_of(points, self._faces[triangles])
            # a distance that is the radius but for round-off is left to the next one: others may be equally near
            within = np.isin(names, names[distances <= 0.999 * radius]) & np.isin(names, left)
            parts.append((points[within], triangles[within], distances[within]))
            left = np.setdiff1d(left, names[within])
            radius *= 2.0
        return self.grouped(*joined(parts))

    def _near(
        self, slaves: wp.array, nodes: wp.array, radius: float, members: np.ndarray, only: np.ndarray | None = None
    ) -> Iterator[Part]:
        """Points (all, or `only` these), sub-triangles among `members` and distances, by point."""
        surface = self.surface(nodes)
        queries = slaves if only is None else self.upload(slaves.numpy()[only])

        def distances_of(points: wp.array, triangles: wp.array) -> wp.array:
            if only is not None:
                points = wp.array(only[points.numpy()], dtype=wp.int32, device=self._device)
            distances = wp.empty(len(points), dtype=real, device=self._device)
            wp.launch(
                broadphase.find_candidates,
                dim=len(points),
                inputs=[points, triangles, slaves, real(radius), surface, self._ownership],
                outputs=[distances],
                device=self._device,
            )
            return distances

        a, b, c = (nodes.numpy()[corner] for corner in self._corners)
        boxes = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        for points, triangles, distances in near_pairs(queries, queries, boxes, radius, distances_of, members):
            yield points if only is None else only[points], triangles, distances

    def grouped(self, points: np.ndarray, triangles: np.ndarray, distances: np.ndarray) -> LayerPairs:
        """Candidates in whatever order as pairs of points and layers."""
        # one integer that sorts by point, layer, sub-triangle: the result does not depend on the order of the search
        names = points.astype(np.int64) * len(self._rank) + self._rank[triangles]
        if np.any(names[1:] < names[:-1]):
            order = np.argsort(names, kind="stable")
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
            candidate_distances=distances,
        )
