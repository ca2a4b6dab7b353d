"""Contact of the plane sub-triangles themselves: what keeps apart the facets that are drawn and swept.

    U = sum m(c) b(d)   over pairs (vertex, triangle), (edge, edge) of sub-triangles that share no point, d < a
    b(d) = 1/2 k (a - d)^2 a / d,   for d < a / 10 the parabola with the same value, slope and curvature
    m(c) = c / c_0 (2 - c / c_0)    for edges with c = |e_1 x e_2|^2 < c_0 = 1e-3 (L_1 L_2)^2, else 1

Points and edges keep the cubic surfaces apart by the thickness h. Where elements bend so much that the facets lie
farther from their surface than that, facets meet before surfaces do, and the swept test would refuse steps that no
force avoids. The range a = min(h, c s, d_0) / 4 (s, d_0: distance in the flat sheet and in the start) is out of
reach of layers that press on each other as usual. The barrier grows as 1 / d, so that a press is resisted long before
facets touch.

Source of barrier and mollifier: M. Li et al., Incremental Potential Contact, ACM Transactions on Graphics 39 (2020);
its barrier is a logarithm, and has no sides: here the side of a pair is that of the last accepted state, so that an
iterate that is through is pushed back.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import facet_pairs
from warp_origami.kernels.precision import real, vec3, vec4
from warp_origami.kernels.swept import EDGE_EDGE
from warp_origami.model.connectivity import sheet_labels
from warp_origami.model.mesh import Mesh

from ..buffers import Buffer
from ..launches import Launch
from .active_pairs import ActivePairs
from .distance_bounds import DistanceBounds, change_of_distances
from .features import FeatureMesh
from .near_features import FeatureSearch, NearFeatures
from .recent import Recent
from .swept import relative_motion
from .thickness import CREASE_RATIO, reach_of

RANGE_SHARE = 0.25
"""Range over the effective thickness min(h, c s, d_0)."""

RADIUS_SHARE = 0.25
"""Radius of the search over the length of an edge."""

GRAIN = 3000
"""Pairs that are worth a thread: some 50 ns each."""

CAP = 0.1
"""Distance over the range below which the barrier is a parabola: 1000 times as stiff as at its begin, and finite."""

PARALLEL = 1e-3
"""c_0 over the product of the squared flat lengths."""


@dataclass
class _Found:
    """Pairs of features near each other, with the launch that evaluates them.

    Attributes:
        near: the pairs, (n,).
        which: buffer of the pairs to be evaluated.
        command: evaluates them.
        state: buffers of FacetDistances, by name.
        bounds: of their distances.
        ranges: (n,) distance at which each begins to press, m.
        sides, distances: (n,) +1, -1 or 0, and m, in the accepted state; None where that was not looked at.
    """

    near: NearFeatures
    which: Buffer
    command: Launch
    state: dict[str, Buffer]
    bounds: DistanceBounds
    ranges: np.ndarray
    sides: np.ndarray | None = None
    distances: np.ndarray | None = None


class FacetContact:
    """Contact energy of facets as a function of q (n, 3); equal q after equal accepted states gives equal bits.

    Args:
        mesh: flat sheet.
        features: the facets.
        thickness: h, m.
        stiffness: k, N/m.
        initial_q: (n, 3) state of the start, free of contact force by construction.
        device: of Warp.

    Attributes:
        kernel_modules: Warp modules compiled for it.
    """

    def __init__(
        self,
        mesh: Mesh,
        features: FeatureMesh,
        thickness: float,
        stiffness: float,
        initial_q: np.ndarray,
        device: str = "cpu",
    ) -> None:
        self._features, self._stiffness, self._device = features, float(stiffness), device
        self._thickness = float(thickness)
        self._reach = reach_of(mesh, self._thickness)
        self._touching = 1e-9 * mesh.size
        self.kernel_modules = (facet_pairs.find_facet_distances.module.name,)
        self._interpolation, self._lengths = features.interpolation, features.edge_lengths
        self._search = FeatureSearch(features, device)
        self._radius = max(RADIUS_SHARE * self._search.typical_length, 3.0 * self._reach)
        self._sheets = sheet_labels(mesh.edges, len(mesh.vertices))[mesh.triangles[features.elements, 0]]
        count = len(features.flat)
        self._positions = Buffer(count, vec3, device)
        self._flat, self._start = np.pad(features.flat, ((0, 0), (0, 1))), self._interpolation @ initial_q
        self._searches: Recent[_Found] = Recent()
        self.accept(np.array(initial_q))

    def accept(self, q: np.ndarray) -> None:
        """Takes q as an accepted state: from now on features are kept on the side of each other where they are in q."""
        self._accepted_q, self._accepted_x = np.array(q), self._interpolation @ q
        for found in self._searches:
            found.sides = None
        self._evaluate(q)

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Contact energy (J) and its gradient (n, 3): minus the contact forces."""
        self._evaluate(q)
        if not len(self._active):
            return 0.0, np.zeros_like(q)
        energy, slope, _ = self._barrier()
        mollifier, on_edges = self._mollifier()
        corners = self._corners()
        forces = np.zeros_like(self._x)
        pull = (mollifier * slope)[:, None, None] * self._weights[:, :, None] * self._directions[:, None]
        np.add.at(forces, corners, pull + energy[:, None, None] * on_edges)
        return float(mollifier @ energy), self._interpolation.T @ forces

    def active_pairs(self) -> ActivePairs:
        """Touching pairs of the last evaluated state; the derivative of the mollifier is left out of them."""
        if not len(self._active):
            return ActivePairs.none(len(self._accepted_q))
        _, slope, curvature = self._barrier()
        mollifier, _ = self._mollifier()
        rows = np.repeat(np.arange(len(slope)), 4)
        shape = (len(slope), len(self._x))
        factors = csr_matrix((self._weights.ravel(), (rows, self._corners().ravel())), shape=shape)
        factors = csr_matrix(factors @ self._interpolation)
        factors.sort_indices()
        return ActivePairs(factors, self._directions, -mollifier * slope, mollifier * curvature, self._elements())

    def flat_points(self) -> np.ndarray:
        """(k, 2, 2) flat positions (m) of the two points of each of active_pairs()."""
        if not len(self._active):
            return np.zeros((0, 2, 2))
        parts = np.maximum(self._weights, 0.0), np.maximum(-self._weights, 0.0)
        flat = self._features.flat[self._corners()]
        return np.stack([np.einsum("kc,kcd->kd", part, flat) for part in parts], axis=1)

    def counts(self) -> tuple[int, int]:
        """Vertices on triangles and edges on edges that touch in the last evaluated state."""
        edges = int(np.count_nonzero(self._found.near.kinds[self._active] == EDGE_EDGE))
        return len(self._active) - edges, edges

    def state(self) -> dict[str, np.ndarray]:
        """Accepted state for a checkpoint; after `restore` all results continue bitwise."""
        return {"q": self._accepted_q}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Takes the accepted state from `state`."""
        self._searches.forget()
        self.accept(state["q"])

    def _evaluate(self, q: np.ndarray) -> None:
        """Distances of all pairs that can touch at q."""
        self._x = self._interpolation @ q
        self._active = np.zeros(0, dtype=int)
        found = self._found = self._searches.use(self._fits, self._search_here)
        if not len(found.near.kinds):
            return
        if found.sides is None:
            self._look_at_accepted_state()
        since = change_of_distances(self._accepted_x, self._x)
        through = np.minimum(since - found.distances, self._reach)
        which = found.bounds.within(self._x, np.maximum(found.ranges, through))
        if which is None:
            which = np.arange(len(found.near.kinds))
            self._launch(which, self._x)
            found.bounds.take(self._x, np.abs(found.state["distances"].read()))
        else:
            self._launch(which, self._x)
        if len(which):
            self._touch(which, through)

    def _fits(self, found: _Found) -> bool:
        """Whether the sheet has not yet moved by half of the radius of a search."""
        return self._reach + 2.0 * relative_motion(found.near.positions, self._x) <= self._radius

    def _touch(self, which: np.ndarray, through: np.ndarray) -> None:
        """What touches among the pairs `which`, in an order that does not depend on the search.

        `through` (pairs,), m: up to which distance a pair may be on the wrong side, having moved as little as it has.
        """
        state = self._found.state
        distances = state["distances"].read()[which]
        limits = np.maximum(self._found.ranges, through)[which]
        close = (np.abs(distances) < limits) & (self._found.ranges[which] > self._touching)
        at, distances = which[close], distances[close]
        sided = state["facing"].read()[at] & (self._found.sides[at] != 0.0)
        # where the side is not known, the one that the pair is on
        sides = np.where(sided, self._found.sides[at], np.where(distances < 0.0, -1.0, 1.0))
        gaps = sides * distances
        touching = gaps < self._found.ranges[at]
        at = at[touching]
        order = np.lexsort((self._found.near.seconds[at], self._found.near.firsts[at], self._found.near.kinds[at]))
        self._active = at[order]
        self._gaps = gaps[touching][order]
        self._directions = sides[touching][order][:, None] * state["normals"].read()[self._active]
        self._weights = state["weights"].read()[self._active].copy()

    def _look_at_accepted_state(self) -> None:
        """Distances of all pairs in the accepted state, and +1 or -1 where they have a sign there, else 0."""
        self._launch(np.arange(len(self._found.near.kinds)), self._accepted_x)
        distances = self._found.state["distances"].read()
        self._found.distances = np.abs(distances)
        known = self._found.state["facing"].read() & (self._found.distances > self._touching)
        self._found.sides = np.where(known, np.sign(distances), 0.0)
        self._found.bounds.take(self._accepted_x, self._found.distances)

    def _launch(self, which: np.ndarray, positions: np.ndarray) -> None:
        """Evaluates the pairs `which` where the points are at `positions`."""
        if not len(which):
            return
        self._positions.write(positions)
        self._found.which.write_first(which)
        self._found.command.set_dim(len(which))
        self._found.command.launch()

    def _search_here(self) -> _Found:
        """Searches all pairs that can touch before the sheet has moved by half of the radius."""
        near = self._search.within(self._x, self._radius)
        count = len(near.kinds)
        pairs, out = facet_pairs.FacetPairs(), facet_pairs.FacetDistances()
        pairs.kinds, pairs.firsts, pairs.seconds = near.arrays
        kinds = {"weights": vec4, "distances": real, "normals": vec3, "facing": wp.bool}
        state = {name: Buffer(count, kind, self._device) for name, kind in kinds.items()}
        for name, buffer in state.items():
            setattr(out, name, buffer.array)
        which = Buffer(count, wp.int32, self._device)
        inputs = [pairs, self._search.features, self._positions.array, which.array]
        command = Launch(facet_pairs.find_facet_distances, count, inputs, [out], self._device, GRAIN)
        ranges = np.full(count, RANGE_SHARE * self._thickness)
        found = self._found = _Found(near, which, command, state, DistanceBounds(self._thickness), ranges)
        if not count:
            return found
        sheets = self._sheets[self._corners(np.arange(count))[:, [0, 3]]]
        for positions, share in ((self._flat, CREASE_RATIO), (self._start, 1.0)):
            self._launch(np.arange(count), positions)
            limits = RANGE_SHARE * share * np.abs(state["distances"].read())
            if positions is self._flat:
                limits[sheets[:, 0] != sheets[:, 1]] = np.inf
            found.ranges = np.minimum(found.ranges, limits)
        return found

    def _corners(self, at: np.ndarray | None = None) -> np.ndarray:
        """(k, 4) points of the two features of pairs `at`, or of all that touch."""
        near, features = self._found.near, self._features
        at = self._active if at is None else at
        first, second = near.firsts[at], near.seconds[at]
        edges = near.kinds[at] == EDGE_EDGE
        corners = np.empty((len(at), 4), dtype=int)
        corners[edges] = np.concatenate([features.edges[first[edges]], features.edges[second[edges]]], axis=1)
        corners[~edges, 0] = first[~edges]
        corners[~edges, 1:] = features.triangles[second[~edges]]
        return corners

    def _elements(self) -> np.ndarray:
        """(active, 2) an element that holds each feature of touching pairs."""
        near, at = self._found.near, self._active
        edges = near.kinds[at] == EDGE_EDGE
        elements = np.empty((len(at), 2), dtype=int)
        for column, numbers, others in (
            (0, near.firsts[at], self._features.elements),
            (1, near.seconds[at], self._features.triangle_elements),
        ):
            elements[edges, column] = self._features.edge_elements[numbers[edges]]
            elements[~edges, column] = others[numbers[~edges]]
        return elements

    def _barrier(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """b, db/dd and d2b/dd2 of touching pairs (J, N, N/m)."""
        k, a, d = self._stiffness, self._found.ranges[self._active], self._gaps
        at = np.maximum(d, CAP * a)
        slope, curvature = -0.5 * k * a * (a**2 - at**2) / at**2, k * (a / at) ** 3
        beyond = d - at
        energy = 0.5 * k * (a - at) ** 2 * a / at + (slope + 0.5 * curvature * beyond) * beyond
        return energy, slope + curvature * beyond, curvature

    def _mollifier(self) -> tuple[np.ndarray, np.ndarray]:
        """m of touching pairs, and its derivatives (active, 4, 3) by the corners, 1/m."""
        edges = np.flatnonzero(self._found.near.kinds[self._active] == EDGE_EDGE)
        value, slopes = np.ones(len(self._active)), np.zeros((len(self._active), 4, 3))
        x = self._x[self._corners()[edges]]
        u, v = x[:, 1] - x[:, 0], x[:, 3] - x[:, 2]
        cross = np.cross(u, v)
        c = np.einsum("kd,kd->k", cross, cross)
        first, second = (self._found.near.firsts[self._active[edges]], self._found.near.seconds[self._active[edges]])
        full = PARALLEL * (self._lengths[first] * self._lengths[second]) ** 2
        share = np.minimum(c / full, 1.0)
        value[edges] = share * (2.0 - share)
        by_c = (2.0 * (1.0 - share) / full)[:, None]
        by_u, by_v = 2.0 * by_c * np.cross(v, cross), 2.0 * by_c * np.cross(cross, u)
        slopes[edges] = np.stack([-by_u, by_u, -by_v, by_v], axis=1)
        return value, slopes
