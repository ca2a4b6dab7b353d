"""Points of the sheet against its layers: surface-to-surface and node-to-surface contact, paper (23)-(46).

    U = sum_sts U(g, eps_s w_I A_I / 2) + sum_nts U(g, eps_n)    over pairs (slave point, layer) with g < 0;  U: law.py

Conventions. A layer is a face (elements connected without a crease); every slave point has one gap to every layer. Each
of two touching surfaces is slave to the other, so each pass carries half of eps_s and together they are pressed apart
by eps_s |g| per area (two equal free sheets of areal mass m that meet flat separate after pi sqrt(m / (2 eps_s))). A
node carries the whole eps_n.

Masters are the cubic elements: the nearest plane sub-triangle starts the projection (28), (29) of a slave point on
their surface, and forces act on all coordinates of the element by its shape functions, as they do on the slave's.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.kernels import broadphase
from warp_origami.kernels.point_contact import point_contacts
from warp_origami.kernels.point_gap import FREE, UNKNOWN
from warp_origami.kernels.precision import vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh
from warp_origami.model.submesh import Submesh

from ..buffers import Buffer
from ..launches import compile_now
from ..shapes import flat_of
from .accepted_pairs import AcceptedPairs
from .active_pairs import ActivePairs
from .by_name import look_up
from .law import contact_law
from .layer_motion import LayerMotion
from .masters import MasterSurfaces
from .narrow import NarrowPhase, SlaveStiffness
from .points import build_points
from .recent import Recent
from .search import LayerPairs, Search
from .settings import ContactSettings
from .sides import ordered_sides, pattern_normals, sides_at, unordered_layers
from .summary import ContactSummary, summarize
from .swept import relative_motion
from .thickness import CREASE_RATIO, build_thickness, margin_of, reach_of

ROUND_OFF = 1e-9
"""Share of the margin that is left for round-off."""

REBUILD_FRACTION = 0.45
"""Part of the margin that a point may move before the candidates are searched anew; below 1/2, both sides move."""


@dataclass
class _Found:
    """Pairs that were found with points at `positions`, m, and what is known of them from accepted state number
    `accepted`."""

    positions: np.ndarray
    narrow: NarrowPhase | None
    accepted: int


class SurfaceContact:
    """Contact energy of points and layers as a function of q (n, 3); see `Contact` for its arguments.

    Args:
        submesh: nearest sub-triangles lead to the elements.

    Attributes:
        kernel_modules: Warp modules compiled for it.
        coincident_layers: as in `Contact`.
    """

    def __init__(
        self,
        mesh: Mesh,
        coordinates: Coordinates,
        submesh: Submesh,
        settings: ContactSettings,
        initial_q: np.ndarray,
        face_orders: np.ndarray | None = None,
        pattern_faces: np.ndarray | None = None,
        device: str = "cpu",
        sts_degree: int | None = None,
    ) -> None:
        k = submesh.divisions
        self._mesh, self._device = mesh, device
        self._law = contact_law(settings.method, settings.exact, settings.thickness)
        self._thickness = self._law.outset * float(settings.thickness)
        self._submesh = submesh
        self._points = build_points(
            mesh, coordinates, self._submesh, settings.method, sts_degree or (2 if k >= 4 else 4)
        )
        self._interpolation = self._points.interpolation
        self._element_rows = coordinates.elements
        self._slave_rows, self._slave_shapes = self._points.slave_shapes()
        self._slave_elements = self._points.owner_elements[self._points.owner_starts[:-1]]
        self._stiffness = SlaveStiffness(0.5 * settings.sts_stiffness * self._points.areas, settings.nts_stiffness)

        self._reach, self._margin = reach_of(mesh, self._thickness), margin_of(mesh, self._thickness)
        self._touching = 1e-9 * mesh.size
        apart = max(self._thickness / CREASE_RATIO, 1.5 * (self._reach + self._margin))
        self._search = Search(self._points, self._submesh, apart, device)
        self._nodes = Buffer(self._points.node_count, vec3, device)
        self._slaves = Buffer(self._points.slave_count, vec3, device)
        facets = self._search.surface(self._nodes.array)
        self._surfaces = MasterSurfaces(mesh, coordinates, k, facets, self._reach, device)
        self.kernel_modules = (
            tuple(kernel.module.name for kernel in (broadphase.find_candidates, point_contacts))
            + self._surfaces.modules
        )

        compile_now(point_contacts, device)
        start = self._interpolation @ initial_q
        self._table = build_thickness(self._search, self._points, start, self._thickness)
        self._searches: Recent[_Found] = Recent()
        self._accepted_number, self._moved = 0, 0.0
        self._accepted = AcceptedPairs.none(np.array(initial_q), others_beyond=0.0)
        self._motion = LayerMotion(submesh, self._points.node_count, self._points.slave_count, device)
        self._motion.accept(start)
        self._active = np.zeros(0, dtype=int)
        self._narrow: NarrowPhase | None = None
        self.coincident_layers = self._start(initial_q, face_orders, pattern_faces)

    @property
    def reach(self) -> float:
        """Distance (m) up to which a point is seen by a layer, on either side."""
        return self._reach

    def accept(self, q: np.ndarray) -> None:
        """Takes q as an accepted state: from now on points are kept on the side of each layer where they are in q."""
        self._evaluate(q, everything=True)
        self._accepted = AcceptedPairs.none(np.array(q), self._reach)
        self._motion.accept(self._positions)
        self._take_sides()
        self._take_distances()
        self._regain_thickness()
        self._accepted_number += 1
        self._found.accepted = self._accepted_number

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Contact energy (J) and its gradient (n, 3): minus the contact forces (36), (44)."""
        self._evaluate(q)
        if not len(self._active):
            return 0.0, np.zeros_like(q)
        given = self._given_to_law()
        pull = self._law.slope(*given)[:, None] * self._narrow.normals.read()[self._active]
        rows, factors = self._rows_and_factors()
        forces = [np.bincount(rows.ravel(), (factors * p[:, None]).ravel(), minlength=len(q)) for p in pull.T]
        return float(self._law.energy(*given).sum()), np.stack(forces, axis=1)

    def active_pairs(self) -> ActivePairs:
        """Touching pairs of the last evaluated state."""
        if not len(self._active):
            return ActivePairs.none(len(self._accepted.q))
        state, active = self._narrow, self._active
        slaves = state.points[active]
        return ActivePairs(
            self._factors(),
            state.normals.read()[active],
            -self._law.slope(*self._given_to_law()),
            self._law.curvature(*self._given_to_law()),
            np.stack([self._slave_elements[slaves], state.elements.read()[active]], axis=1),
        )

    def flat_points(self) -> np.ndarray:
        """(k, 2, 2) flat positions (m) of slave and master points of active_pairs()."""
        state, active = self._narrow, self._active
        if not len(active):
            return np.zeros((0, 2, 2))
        masters = flat_of(self._mesh, state.elements.read()[active], state.shapes.read()[active])
        slaves = self._points.flat[self._points.node_count + state.points[active]]
        return np.stack([slaves, masters], axis=1)

    def statistics(self) -> tuple[int, int, float]:
        """Integration points and nodes that touch in the last evaluated state, and the deepest penetration, m."""
        if not len(self._active):
            return 0, 0, 0.0
        sts = int(np.count_nonzero(self._narrow.points[self._active] < self._stiffness.sts_count))
        gaps, _, begins = self._given_to_law()
        return sts, len(self._active) - sts, float(self._law.penetration(gaps, begins).max())

    def through(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points on the wrong side of a layer at q (n, 3): (k, 2) elements of the point and of the place where it is
        through, and (k, 2, 2) their flat positions, m.

        A distance changes by no more than the two points move. Where it has changed sign by more since the accepted
        state, the point has not gone through: another part of the layer that is turned over has become the nearest, and
        the side of the pair is forgotten.
        """
        self._evaluate(q)
        gaps, _, begins = self._given_to_law() if len(self._active) else 3 * (np.zeros(0),)
        found = np.flatnonzero(gaps + begins < -self._touching)
        if not len(found):
            return np.zeros((0, 2), dtype=int), np.zeros((0, 2, 2))
        elements, flat = self.active_pairs().elements[found], self.flat_points()[found]
        keys, depths, here = self._narrow.keys[self._active[found]], -(gaps + begins)[found], self._positions
        before = self._least_distances(keys)
        self._forget(keys[before + depths > 2.0 * relative_motion(here, self._positions) + self._touching])
        return elements, flat

    def _least_distances(self, keys: np.ndarray) -> np.ndarray:
        """Distance that pairs have at least in the accepted state, where evaluation ends, m; up to the reach."""
        self._evaluate(self._accepted.q, everything=True)
        state = self._narrow
        if state is None:
            return np.full(len(keys), self._reach)
        at = state.sorted_by_key(state.reached)
        # sub-triangles alone tell the distance only up to their error
        errors = self._surfaces.errors.read()[state.elements.read()[at]]
        distances = np.maximum(np.abs(state.distances.read()[at]) - errors, 0.0)
        return look_up(keys, state.keys[at], np.minimum(distances, self._reach), otherwise=self._reach)

    def _forget(self, keys: np.ndarray) -> None:
        """Makes pairs free to be on either side until the next accepted state."""
        self._accepted = self._accepted.without(keys)
        self._searches.forget()

    def summary(self, edges: int) -> ContactSummary:
        """What will be modelled, for `check`, beside a number of edges."""
        return summarize(self._mesh, self._submesh, self._points, self._table, self._search, self._narrow, edges)

    def state(self) -> dict[str, np.ndarray]:
        """Accepted state for a checkpoint; after `restore` all results continue bitwise."""
        return {
            "q": self._accepted.q,
            "pairs": self._accepted.keys,
            "sides": self._accepted.sides,
            "thickness": self._table.values,
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Takes the accepted state from `state`."""
        accepted = AcceptedPairs.none(np.array(state["q"]), self._reach)
        self._accepted = replace(accepted, keys=np.array(state["pairs"]), sides=np.array(state["sides"]))
        self._table = replace(self._table, values=np.array(state["thickness"]))
        self._searches.forget()
        self._motion.accept(self._interpolation @ self._accepted.q)
        self._evaluate(self._accepted.q, everything=True)
        self._take_distances()

    def _start(self, q: np.ndarray, face_orders: np.ndarray | None, pattern_faces: np.ndarray | None) -> np.ndarray:
        """Sides in the start state; returns the layers whose order is unknown."""
        self._place(q)
        self._find()
        if self._narrow is None:
            return np.zeros((0, 2), dtype=int)
        self._motion.forget()
        self._launch()
        self._free_start()
        state = self._narrow
        at = state.reached[np.abs(state.distances.read()[state.reached]) <= self._touching]
        if len(at) and face_orders is not None and len(face_orders) and pattern_faces is not None:
            masters = state.elements.read()[at]
            corners = self._positions[self._submesh.triangles]
            normals = pattern_normals(corners, pattern_faces[self._submesh.triangle_elements])
            sides = state.sides.read().copy()
            sides[at] = ordered_sides(self._points, state.points[at], masters, pattern_faces, face_orders, normals)
            state.sides.write(sides)
        self._take_sides()
        self._take_distances()
        self._launch()
        # points on the rim of a layer only touch it, as the lips of a cut do: no layer lies on another there
        unknown = at[(state.sides.read()[at] == FREE) & ~state.outer.read()[at]]
        return unordered_layers(
            self._mesh, self._points, state.points[unknown], self._search.layers_of(state.keys[unknown])
        )

    def _free_start(self) -> None:
        """Limits the thickness where the cubic surface bulges out of the sub-triangles towards a point in the start."""
        state = self._narrow
        distances = np.abs(state.distances.read()[state.reached])
        closer = distances < state.thickness[state.reached]
        if closer.any():
            self._table = self._table.limited(state.keys[state.reached[closer]], distances[closer])
            self._searches.forget()
            self._find()
            self._launch()

    def _take_sides(self) -> None:
        """Sides at the accepted state, which has just been evaluated."""
        state = self._narrow
        if state is None:
            return
        sides = np.full(len(state.keys), UNKNOWN, dtype=np.int32)
        sides[state.reached] = sides_at(state, self._thickness, self._touching)
        sides[state.reached[np.abs(state.distances.read()[state.reached]) > state.seen]] = UNKNOWN
        self._accepted = self._accepted.with_sides(state, sides)
        state.sides.write(sides)

    def _take_distances(self) -> None:
        """How far all pairs are apart at the accepted state, where everything has just been evaluated."""
        state = self._narrow
        if state is None:
            return
        least = state.least_distances(self._surfaces.errors.read())
        self._accepted = self._accepted.with_distances(state, least)
        state.least.write(least)

    def _regain_thickness(self) -> None:
        """Effective thickness after the accepted state, which has just been evaluated."""
        if not self._table.limited_by_distance:
            return
        state = self._narrow
        if state is None:
            self._table = self._table.regained(np.zeros(0, dtype=np.int64), np.zeros(0))
            return
        at = state.reached[np.abs(state.distances.read()[state.reached]) <= self._reach]
        # sub-triangles alone tell the distance only up to their error; what touches regains nothing
        errors = self._surfaces.errors.read()[state.elements.read()[at]]
        distances = (1.0 - 1e-9) * (np.abs(state.distances.read()[at]) - errors)
        distances[state.gaps.read()[at] < 0.0] = 0.0
        self._table = self._table.regained(state.keys[at], distances)
        state.set_thickness(self._table.of(state.keys))

    def _evaluate(self, q: np.ndarray, everything: bool = False) -> None:
        """Gaps of all pairs at q, of those that can touch or of `everything` that is near."""
        self._place(q)
        self._find()
        state = self._narrow
        if state is None:
            self._active = np.zeros(0, dtype=int)
            return
        if everything:
            self._motion.forget()
        else:
            self._motion.follow(self._positions, float(self._surfaces.errors.read().max()))
        farther = (self._margin - 2.0 * self._moved) * (1.0 - ROUND_OFF) if everything else 0.0
        self._launch(farther)
        near = np.abs(state.distances.read()[state.reached]) <= self._reach
        unknown = state.reached[near & (state.sides.read()[state.reached] == UNKNOWN)]
        if len(unknown):
            self._look_up_sides(state.sorted_by_key(unknown), q)
            self._launch(farther)

    def _place(self, q: np.ndarray) -> None:
        """Brings the surface and its points to `q`."""
        positions = self._interpolation @ q
        self._positions = positions
        self._nodes.write(positions[: self._points.node_count])
        self._slaves.write(positions[self._points.node_count :])
        self._surfaces.place(q)

    def _launch(self, farther: float = 0.0) -> None:
        state = self._narrow
        state.launch(self._moved, farther)
        self._active = state.sorted_by_key(state.reached[state.gaps.read()[state.reached] < 0.0])

    def _find(self) -> None:
        """All pairs that can touch, as long as no point has moved by more than REBUILD_FRACTION of the margin."""
        found = self._found = self._searches.use(self._fits, self._search_here)
        self._narrow = state = found.narrow
        if found.accepted != self._accepted_number:
            found.accepted = self._accepted_number
            if state is not None:
                state.sides.write(self._accepted.sides_of(state.keys))
                state.least.write(self._accepted.distances_of(state.keys))
                state.set_thickness(self._table.of(state.keys))

    def _fits(self, found: _Found) -> bool:
        self._moved = _largest_distance(self._positions, found.positions)
        return self._moved <= REBUILD_FRACTION * self._margin

    def _search_here(self) -> _Found:
        self._moved = 0.0
        pairs = self._search.within(self._slaves.array, self._nodes.array, self._reach + self._margin)
        state = self._narrow_phase(pairs, self._accepted.sides_of(pairs.keys)) if len(pairs.keys) else None
        if state is not None:
            state.least.write(self._accepted.distances_of(state.keys))
        return _Found(self._positions, state, self._accepted_number)

    def _narrow_phase(self, pairs: LayerPairs, sides: np.ndarray, reach: float | None = None) -> NarrowPhase:
        return NarrowPhase(
            pairs,
            self._table.of(pairs.keys),
            sides,
            self._slaves.array,
            self._surfaces.masters,
            self._motion.motion,
            self._reach if reach is None else reach,
            self._device,
        )

    def _look_up_sides(self, where: np.ndarray, q: np.ndarray) -> None:
        """Sides of pairs, by name, that have come near since the last accepted state: from there; back to q."""
        self._place(self._accepted.q)
        keys = self._narrow.keys[where]
        pairs = self._search.nearest(keys, self._slaves.array, self._nodes.array, self._reach + self._margin)
        state = self._narrow_phase(pairs, np.full(len(keys), UNKNOWN), reach=np.inf)
        state.launch(0.0)
        found = np.empty(len(keys), dtype=np.int32)
        found[np.searchsorted(keys, state.keys[state.reached])] = sides_at(state, self._thickness, self._touching)
        sides = self._narrow.sides.read().copy()
        sides[where] = found
        self._narrow.sides.write(sides)
        self._place(q)

    def _given_to_law(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gaps, stiffnesses and distances at which they begin to press, of the touching pairs."""
        state, active = self._narrow, self._active
        return state.gaps.read()[active], self._stiffness.of(state.points[active]), state.thickness[active]

    def _rows_and_factors(self) -> tuple[np.ndarray, np.ndarray]:
        """(active, 18) rows of q, and the factors of the normal in the gradient of each gap that belong to them."""
        state, active = self._narrow, self._active
        slaves = state.points[active]
        rows = np.concatenate([self._slave_rows[slaves], self._element_rows[state.elements.read()[active]]], axis=1)
        return rows, np.concatenate([self._slave_shapes[slaves], -state.shapes.read()[active]], axis=1)

    def _factors(self) -> csr_matrix:
        """(active, n) factors of the normal in the gradient of each gap."""
        rows, factors = self._rows_and_factors()
        starts = np.arange(0, rows.size + 1, rows.shape[1], dtype=np.int32)
        return csr_matrix((factors.ravel(), rows.ravel(), starts), shape=(len(rows), len(self._accepted.q)))


def _largest_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Largest distance between points of the same number, m."""
    step = a - b
    return float(np.sqrt(np.einsum("ij,ij->i", step, step).max()))
