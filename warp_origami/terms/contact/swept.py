"""Whether anything passes through anything between two states: the swept test of a step.

    x(t) = S (q_0 + t (q_1 - q_0)),   0 <= t <= 1      for all points of the sub-mesh

Free only if every vertex stays away from every triangle, and every edge from every edge, that it shares no point with:
sub-triangles that do not cross at the start then do not cross at any time (those that share a point meet first with
features that do not share it). The test is conservative: it may report a passage where features touch without passing,
it never misses one.

What is not looked at. Features that touch at the start of the step, at a distance of `touching` or less (creases folded
flat, sheets that lie on each other): on which side they are is not known. As no pair may come that close during a step
that is free, only what touches from the start of a run remains so. The lips of a cut: a point of the pattern that a cut
has doubled counts as one, as nothing holds lips apart that slide in the plane of the sheet.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import swept, swept_search
from warp_origami.kernels.precision import real, vec3
from warp_origami.model.mesh import Mesh

from ..buffers import Buffer
from .features import FeatureMesh
from .near_features import FeatureSearch, NearFeatures

TOUCHING_SHARE = 1e-10
"""Distance at which features touch, over the size of the sheet: far above round-off, far below any thickness."""

RADIUS_SHARE = 0.25
"""Radius of the search over the length of an edge: below the distance of features of a flat sheet from each other."""

KINDS = ("vertex-triangle", "edge-edge")


@dataclass(frozen=True)
class Passage:
    """The first touch in a step.

    Attributes:
        kind: "vertex-triangle", "edge-edge" or, of a state that a step leads to, "point-layer".
        t: part of the step until which nothing is known to touch.
        elements: an element of the vertex and that of the triangle, or an element of each edge.
        faces: the mesh faces of these elements.
        flat: flat positions (m) of the touching points of the first and of the second feature.
    """

    kind: str
    t: float
    elements: tuple[int, int]
    faces: tuple[int, int]
    flat: tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class SweptCost:
    """What tests have cost so far: searches for near features, pairs the last one found, pairs advanced in all."""

    searches: int
    near: int
    advanced: int


class SweptTest:
    """Decides whether steps are free of passages; the answer depends on the two states of a step alone.

    Near features are searched within a radius and kept: as long as no point has moved by half of it against the others,
    what is farther apart cannot touch, and of the rest only pairs closer than twice that motion are advanced. A step
    that moves farther is cut into parts for the search.

    Args:
        mesh: flat sheet.
        features: which must not pass through each other.
        device: of Warp.
        touching: m, distance at which features touch; None: TOUCHING_SHARE of the size of the sheet.

    Attributes:
        kernel_modules: Warp modules compiled for it.
        cost: so far.
    """

    def __init__(self, mesh: Mesh, features: FeatureMesh, device: str, touching: float | None = None) -> None:
        self._mesh, self._features, self._device = mesh, features, device
        self._touching = TOUCHING_SHARE * mesh.size if touching is None else touching
        self._search = FeatureSearch(features, device)
        self._radius = max(RADIUS_SHARE * self._search.typical_length, 8.0 * self._touching)
        self._start, self._end = (Buffer(len(features.flat), vec3, device) for _ in range(2))
        self._near: NearFeatures | None = None
        self.cost = SweptCost(0, 0, 0)
        self.kernel_modules = (swept.advance_pairs.module.name, swept_search.find_edges_near_edges.module.name)

    def first_passage(self, q0: np.ndarray, q1: np.ndarray) -> Passage | None:
        """The first touch between the states q0 and q1 (n, 3) of a step, or None if it is free.

        Raises:
            ValueError: a state is not finite.
        """
        start, end = (self._features.interpolation @ q for q in (q0, q1))
        if not (np.isfinite(start).all() and np.isfinite(end).all()):
            raise ValueError("a state with numbers that are not finite cannot be tested for passages")
        self._start.write(start)
        self._end.write(end)
        first = None
        parts = 1 if self._reach(start, end) <= self._radius else self._parts(start, end)
        for part in range(parts):
            a, b = (start + (k / parts) * (end - start) for k in (part, part + 1))
            reach = self._reach(a, b)
            if reach > self._radius:
                self._near = self._search.within(b, self._radius)
                self.cost = SweptCost(self.cost.searches + 1, len(self._near.kinds), self.cost.advanced)
                reach = self._reach(a, b)
            first = _earlier(first, self._advance(reach))
            if first is not None and first[0] * parts <= part + 1:
                break
        return None if first is None else self._passage(*first, start, end)

    def largest_safe_fraction(self, q0: np.ndarray, q1: np.ndarray) -> float:
        """Part of the step from q0 to q1 until which nothing touches; 1 if it is free."""
        passage = self.first_passage(q0, q1)
        return 1.0 if passage is None else passage.t

    def _reach(self, start: np.ndarray, end: np.ndarray) -> float:
        """Distance at the last search above which a pair cannot touch between two states, m."""
        if self._near is None:
            return np.inf
        at = self._near.positions
        # twice `touching` as margin: what is left out stays clear of touching, so that advancing it could not differ
        return 2.0 * max(relative_motion(at, start), relative_motion(at, end)) + 2.0 * self._touching

    def _parts(self, start: np.ndarray, end: np.ndarray) -> int:
        """In how many parts a step is cut so that a search at the end of each reaches back to its start."""
        room = self._radius - 4.0 * self._touching
        return max(1, int(np.ceil(2.0 * relative_motion(start, end) / room)))

    def _advance(self, reach: float) -> tuple[float, int, int, int] | None:
        """Time, kind and features of the first touch among the pairs that were within `reach`."""
        near = self._near
        count = int(np.searchsorted(near.distances, reach, side="right"))
        if not count:
            return None
        self.cost = SweptCost(self.cost.searches, self.cost.near, self.cost.advanced + count)
        times = wp.empty(count, dtype=real, device=self._device)
        inputs = [*near.arrays, self._start.array, self._end.array, self._search.features, real(self._touching)]
        wp.launch(swept.advance_pairs, dim=count, inputs=inputs, outputs=[times], device=self._device)
        times = times.numpy()
        # a time of zero: it touches at the start
        touches = np.flatnonzero((times > 0.0) & (times <= 1.0))
        if not len(touches):
            return None
        names = (near.seconds[touches], near.firsts[touches], near.kinds[touches])
        first = touches[np.lexsort((*names, times[touches]))[0]]
        return float(times[first]), int(near.kinds[first]), int(near.firsts[first]), int(near.seconds[first])

    def _passage(self, t: float, kind: int, first: int, second: int, start: np.ndarray, end: np.ndarray) -> Passage:
        features = self._features
        if kind == 0:
            a, b = np.array([first]), features.triangles[second]
            elements = (int(features.elements[first]), int(features.triangle_elements[second]))
        else:
            a, b = features.edges[first], features.edges[second]
            elements = (int(features.edge_elements[first]), int(features.edge_elements[second]))
        x = start + t * (end - start)
        weights_a, weights_b = _meeting(x[a], x[b])
        flat = tuple(tuple((w @ features.flat[p]).tolist()) for w, p in ((weights_a, a), (weights_b, b)))
        faces = (int(self._mesh.faces[elements[0]]), int(self._mesh.faces[elements[1]]))
        return Passage(KINDS[kind], t, elements, faces, flat)


def _earlier(one, other):
    """The smaller of two tuples of which either may be None."""
    return min((found for found in (one, other) if found is not None), default=None)


def relative_motion(a: np.ndarray, b: np.ndarray) -> float:
    """Largest distance (m) by which a point moves from a to b, but for a translation that all points share.

    No two points move by more than twice this against each other.
    """
    step = np.ascontiguousarray((b - a).T)
    step -= 0.5 * (step.min(axis=1) + step.max(axis=1))[:, None]
    return float(np.sqrt(np.einsum("ij,ij->j", step, step).max()))


def _meeting(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weights of the corners a (m, 3) and b (n, 3) of two features where they meet."""
    spans = np.concatenate([a[1:] - a[0], b[0] - b[1:]])
    found = np.linalg.lstsq(spans.T, b[0] - a[0], rcond=None)[0]
    weights = []
    for part in (found[: len(a) - 1], found[len(a) - 1 :]):
        inside = np.clip(np.concatenate([[1.0 - part.sum()], part]), 0.0, 1.0)
        weights.append(inside / inside.sum())
    return weights[0], weights[1]
