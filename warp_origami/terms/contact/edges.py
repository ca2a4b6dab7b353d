"""Edge-to-edge contact: creases and free edges that cross each other between the slave points of the other elements.

    U = sum m U(g, eps_e)    over pairs of closest points inside two edges, g < 0;  m: kernels/edge_edge.py, U: law.py

Edges are the cubic curves of the sheet. Every local minimum of the distance of two edges counts, so a bent edge may
cross another twice. Within the thickness of an end (flat length) and near parallel the force fades: there the nodes and
integration points of the surfaces carry it.

The effective thickness of a pair is min(h, c s, d) as for points: s is the distance of the edges in the flat sheet
(infinite between separate sheets), d the largest that they have had in an accepted state. Left out: edges that share a
vertex. Edges at no distance in the flat sheet (lips of a cut) have no thickness: they meet a force only once they have
been apart and pass through each other.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import edge_edge, edge_search
from warp_origami.kernels.point_gap import FREE
from warp_origami.kernels.precision import real, vec2, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh
from warp_origami.model.submesh import Submesh

from ..buffers import Buffer
from ..launches import compile_now
from .active_pairs import ActivePairs
from .by_name import look_up
from .edge_curves import bernstein, build_curves, flat_distances
from .edge_narrow import EdgeNarrow
from .edge_search import EdgeSearch, NearEdges
from .law import PENALTY, ContactLaw
from .recent import Recent
from .thickness import CREASE_RATIO, ROUND_OFF, margin_of, reach_of

LONGEST_ZONE = 0.25
"""Part of an edge at each end, at most, where the force fades."""

USED_MARGIN = 0.9
"""Part of the margin that edges may come closer by before the pairs are searched anew; the rest is for round-off."""


@dataclass
class _Found:
    """Pairs that were found with the control points at `positions`, m, and what is known of them from accepted state
    number `accepted`."""

    positions: np.ndarray
    narrow: EdgeNarrow
    accepted: int


class EdgeContact:
    """Contact energy of edges as a function of q (n, 3); equal q after equal accepted states gives equal bits.

    Args:
        mesh: flat sheet.
        coordinates: numbering of q.
        submesh: sub-mesh of contact; its divisions are the parts of an edge from which closest points are looked for.
        thickness: h, m.
        stiffness: eps_e, N/m.
        initial_q: (n, 3) state of the start, free of contact force by construction.
        device: of Warp.
        law: U.

    Attributes:
        kernel_modules: Warp modules compiled for it.
        curves: the edges.
    """

    def __init__(
        self,
        mesh: Mesh,
        coordinates: Coordinates,
        submesh: Submesh,
        thickness: float,
        stiffness: float,
        initial_q: np.ndarray,
        device: str = "cpu",
        law: ContactLaw = PENALTY,
    ) -> None:
        self._law, self._stiffness, self._device = law, float(stiffness), device
        self._thickness = law.outset * float(thickness)
        self.curves = build_curves(mesh, coordinates)
        self.kernel_modules = (edge_search.find_part_pairs.module.name, edge_edge.edge_contacts.module.name)
        compile_now(edge_edge.edge_contacts, device)
        self._reach, self._margin = reach_of(mesh, self._thickness), margin_of(mesh, self._thickness)
        self._touching = 1e-9 * mesh.size
        self._search = EdgeSearch(self.curves.vertices, submesh.divisions, device)
        zones = np.minimum(self._thickness / self.curves.lengths, LONGEST_ZONE)
        self._zones = wp.array(zones, dtype=real, device=device)
        self._controls, self._accepted = (Buffer(len(zones) * 4, vec3, device) for _ in range(2))

        self._limited, self._limits = np.zeros(0, dtype=np.int64), np.zeros(0)
        self._searches: Recent[_Found] = Recent()
        self._accepted_number = 0
        self._take(np.array(initial_q), *_nothing_known())
        self._evaluate(initial_q)
        self._limit_by_start(ROUND_OFF * mesh.size)
        self.accept(initial_q)

    def accept(self, q: np.ndarray) -> None:
        """Takes q as an accepted state: from now on edges are kept on the side of each other where they are in q."""
        self._evaluate(q)
        self._take(np.array(q), *self._known_from_here())
        self._narrow.know(self._known_keys)
        self._regain_thickness()
        self._found.accepted = self._accepted_number

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Contact energy (J) and its gradient (n, 3): minus the contact forces."""
        self._evaluate(q)
        return self._forces() if len(self._active) else (0.0, np.zeros_like(q))

    def active_pairs(self) -> ActivePairs:
        """Touching pairs of the last evaluated state.

        Left out of the tangent made of them is what is proportional to the gap: the turning of the normal and the
        change of the mollifier m.
        """
        if not len(self._active):
            return ActivePairs.none(len(self._accepted_q))
        state, at = self._narrow, self._active
        stiffness = self._stiffness * state.weights.read()[at]
        factors = csr_matrix(self._gap_factors() @ self.curves.controls)
        factors.sort_indices()
        elements = self.curves.elements[np.stack([state.first[at], state.second[at]], axis=1)]
        given = (state.gaps.read()[at], stiffness, state.thickness[at])
        return ActivePairs(
            factors, state.normals.read()[at], -self._law.slope(*given), self._law.curvature(*given), elements
        )

    def flat_points(self) -> np.ndarray:
        """(k, 2, 2) flat positions (m) of the points on both edges of active_pairs()."""
        state, at = self._narrow, self._active
        start, end = self.curves.flat[np.stack([state.first[at], state.second[at]], axis=1)].transpose(2, 0, 1, 3)
        return start + state.parameters.read()[at][:, :, None] * (end - start)

    def statistics(self) -> tuple[int, float]:
        """Crossings of the last evaluated state that carry at least half of the full stiffness, and their deepest
        penetration, m."""
        at = self._active[self._narrow.weights.read()[self._active] >= 0.5]
        depths = self._law.penetration(self._narrow.gaps.read()[at], self._narrow.thickness[at])
        return len(at), float(depths.max(initial=0.0))

    def state(self) -> dict[str, np.ndarray]:
        """Accepted state for a checkpoint; after `restore` all results continue bitwise."""
        return {
            "q": self._accepted_q,
            "pairs": self._known_keys,
            "parameters": self._known_parameters,
            "sides": self._known_sides,
            "limits": self._limits,
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Takes the accepted state from `state`."""
        self._searches.forget()
        self._limits = np.array(state["limits"])
        self._take(*(np.array(state[name]) for name in ("q", "pairs", "parameters", "sides")))
        self._evaluate(self._accepted_q)

    def _take(self, q: np.ndarray, keys: np.ndarray, parameters: np.ndarray, sides: np.ndarray) -> None:
        """Sets the accepted state: q, and closest points with their sides, sorted by pair."""
        self._accepted_q, self._known_keys, self._known_parameters, self._known_sides = q, keys, parameters, sides
        self._accepted.write(self.curves.controls @ q)
        self._known = edge_edge.Known()
        self._known.controls = self._accepted.array
        self._known.parameters = wp.array(parameters, dtype=vec2, device=self._device)
        self._known.sides = wp.array(sides, dtype=wp.int32, device=self._device)
        self._accepted_number += 1

    def _known_from_here(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Closest points of the evaluated state within reach, by pair, with their sides.

        The side is kept while edges are closer than the contact thickness, on either side. It is free near parallel,
        where the direction between them turns quickly, and near ends, which an edge may go round.
        """
        state = self._narrow
        at = state.places("weights", below=np.inf, above=0.0)
        heights, sides = state.heights.read()[at], state.sides.read()[at]
        weights, angles = state.weights.read()[at], state.angle_weights.read()[at]
        kept = (sides != FREE) & (np.abs(heights) < self._thickness)
        sign = np.where(np.abs(heights) <= self._touching, FREE, np.where(heights < 0.0, -1, 1))
        result = np.where(kept, sides, np.where(weights < angles, FREE, sign))
        result[angles < 1.0] = FREE
        return state.keys[at], state.parameters.read()[at], result.astype(np.int32)

    def _limit_by_start(self, below: float) -> None:
        """Effective thickness of pairs closer than the thickness in the start, which has just been evaluated."""
        keys, distances = self._narrow.least_distances()
        close = distances < self._thickness
        self._limited = keys[close]
        self._limits = np.maximum((1.0 - 1e-9) * distances[close] - below, 0.0)
        self._searches.forget()

    def _regain_thickness(self) -> None:
        """Effective thickness after the accepted state, which has just been evaluated."""
        if (self._limits >= self._thickness).all():
            return
        keys, distances = self._narrow.least_distances()
        distances[np.isin(keys, self._narrow.keys[self._active])] = 0.0  # what touches regains nothing
        apart = look_up(self._limited, keys, (1.0 - 1e-9) * distances, otherwise=np.inf)
        self._limits = np.maximum(self._limits, np.minimum(apart, self._thickness))
        self._narrow.set_thickness(self._effective_thickness(self._narrow.near))

    def _effective_thickness(self, near: NearEdges) -> np.ndarray:
        """min(h, c s, d) of pairs, m."""
        result = np.full(len(near.keys), self._thickness)
        same = self.curves.sheets[near.first] == self.curves.sheets[near.second]
        apart = flat_distances(self.curves, near.first[same], near.second[same])
        result[same] = np.minimum(result[same], CREASE_RATIO * apart)
        return np.minimum(result, look_up(near.keys, self._limited, self._limits, otherwise=np.inf))

    def _evaluate(self, q: np.ndarray) -> None:
        """Closest points and gaps at q."""
        positions = self.curves.controls @ q
        self._controls.write(positions)
        self._find(positions)
        self._narrow.launch(self._approached, self._known)
        self._active = self._narrow.places("gaps", below=0.0)

    def _find(self, positions: np.ndarray) -> None:
        """All pairs that can touch before USED_MARGIN of the margin is used up."""

        def fits(found: _Found) -> bool:
            moved = float(np.linalg.norm(positions - found.positions, axis=1).max(initial=0.0))
            # how much closer, at most, parts of two edges have come since the pairs were found
            self._approached = self._search.speed * moved
            return self._approached <= USED_MARGIN * self._margin

        found = self._found = self._searches.use(fits, lambda: self._search_at(positions))
        self._narrow = found.narrow
        if found.accepted != self._accepted_number:
            found.accepted = self._accepted_number
            self._narrow.know(self._known_keys)
            self._narrow.set_thickness(self._effective_thickness(self._narrow.near))

    def _search_at(self, positions: np.ndarray) -> _Found:
        self._approached = 0.0
        near = self._search.within(self._controls.array, self._reach + self._margin)
        narrow = EdgeNarrow(
            near,
            self._effective_thickness(near),
            self._controls.array,
            self._zones,
            self._search.divisions,
            self._reach,
        )
        narrow.know(self._known_keys)
        return _Found(positions, narrow, self._accepted_number)

    def _forces(self) -> tuple[float, np.ndarray]:
        """Energy and its gradient."""
        state, at = self._narrow, self._active
        first, second = (bernstein(x) for x in state.parameters.read()[at].T)
        gaps, stiffness, begins = state.gaps.read()[at], self._stiffness * state.weights.read()[at], state.thickness[at]
        by_weight = self._law.energy(gaps, self._stiffness, begins)[:, None]
        slopes = self._law.slope(gaps, stiffness, begins)
        pull = slopes[:, None] * state.normals.read()[at] + by_weight * state.pulls.read()[at]
        factors = (
            (first, -pull, state.slopes1.read()[at], state.bends1.read()[at]),
            (second, pull, state.slopes2.read()[at], state.bends2.read()[at]),
        )
        on_controls = [
            values[:, :, None] * force[:, None]
            + by_weight[:, None] * (slopes[:, :, None] * slope[:, None] + bends[:, :, None] * bend[:, None])
            for (values, slopes, bends), force, slope, bend in factors
        ]
        forces = np.zeros((self.curves.controls.shape[0], 3))
        np.add.at(forces, self._control_rows().ravel(), np.stack(on_controls, axis=1).reshape(-1, 3))
        return float(self._law.energy(gaps, stiffness, begins).sum()), self.curves.controls.T @ forces

    def _gap_factors(self) -> csr_matrix:
        """(active, control points) factors of the normal in the gradient of each gap."""
        (first, _, _), (second, _, _) = (bernstein(x) for x in self._narrow.parameters.read()[self._active].T)
        values, columns = np.concatenate([-first, second], axis=1), self._control_rows()
        starts = np.arange(0, values.size + 1, 8)
        shape = (len(values), self.curves.controls.shape[0])
        return csr_matrix((values.ravel(), columns.ravel(), starts), shape=shape)

    def _control_rows(self) -> np.ndarray:
        """(active, 8) control points of the two edges of each touching pair."""
        edges = np.stack([self._narrow.first[self._active], self._narrow.second[self._active]], axis=1)
        return (4 * edges[:, :, None] + np.arange(4)).reshape(-1, 8)


def _nothing_known() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs, parameters and sides of no closest points."""
    return np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros(0, dtype=np.int32)
