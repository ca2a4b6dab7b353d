"""Gaps of given pairs of points and layers: the launches of the contact kernels."""

import numpy as np
import warp as wp

from warp_origami.kernels import point_contact, point_gap
from warp_origami.kernels.precision import real, vec3, vec9

from ..buffers import Buffer
from ..launches import Launch
from .search import LayerPairs

GRAIN = 1000
"""Pairs that are worth a thread: the nearest ones cost a microsecond each, most others a twentieth of it."""


class SlaveStiffness:
    """Stiffness of slave points: of integration points, which come first, and of nodes.

    Args:
        integration_stiffness: (sts_count,) eps_s w A / 2 of each integration point, N/m.
        node_stiffness: eps_n, N/m.
    """

    def __init__(self, integration_stiffness: np.ndarray, node_stiffness: float):
        self.sts_count = len(integration_stiffness)
        self._of_nodes, self._of_integration = node_stiffness, integration_stiffness

    def of(self, points: np.ndarray) -> np.ndarray:
        """Stiffness of slave points, N/m."""
        result = np.full(len(points), self._of_nodes)
        integration = points < self.sts_count
        result[integration] = self._of_integration[points[integration]]
        return result


class NarrowPhase:
    """Recorded launches that evaluate pairs at the current positions, only those that can be near by now.

    Pairs are held in the order of their distance when they were found: no pair beyond the first so many can have come
    within reach since.

    Attributes:
        keys, points: names and slave points of the pairs.
        thickness: (n,) distance at which each pair begins to press, m.
        sides: (n,) buffer of +1, -1, FREE or UNKNOWN.
        least: (n,) buffer of how far the sub-triangles were at least in the accepted state, m.
        gaps, normals, elements, shapes, distances, heights, facets, outer: buffers, see point_gap.Contacts.
        seen: m, up to where the last launch has found distances.
        reached: pairs that the last launch has evaluated; all others are farther than the reach.
    """

    def __init__(
        self,
        pairs: LayerPairs,
        thickness: np.ndarray,
        sides: np.ndarray,
        slaves: wp.array,
        masters: point_gap.Masters,
        motion: point_gap.Motion,
        reach: float,
        device: str,
    ):
        count = len(pairs.keys)
        order = np.argsort(pairs.distances, kind="stable")
        self.keys, self.points = pairs.keys[order], pairs.points[order]
        self.thickness = thickness[order]
        self._reach = reach
        self._found_at = pairs.distances[order]
        self.seen = reach
        self.reached = np.arange(count)

        self.sides = Buffer(count, wp.int32, device)
        self.sides.write(sides[order])
        given = point_gap.Pairs()
        given.points = wp.array(self.points, dtype=wp.int32, device=device)
        given.layers = wp.array(pairs.layers[order], dtype=wp.int32, device=device)
        given.starts = wp.array(pairs.starts[:-1][order], dtype=wp.int32, device=device)
        given.ends = wp.array(pairs.starts[1:][order], dtype=wp.int32, device=device)
        given.candidates = wp.array(pairs.candidates, dtype=wp.int32, device=device)
        given.found = wp.array(pairs.candidate_distances, dtype=real, device=device)
        self._change = Buffer(1, real, device)
        given.change = self._change.array
        self._thickness = Buffer(count, real, device)
        self.set_thickness(self.thickness)
        given.thickness = self._thickness.array
        given.sides = self.sides.array
        self.least = Buffer(count, real, device)
        given.least = self.least.array

        contacts = point_gap.Contacts()
        kinds = {"normals": vec3, "shapes": vec9, "elements": wp.int32, "outer": wp.bool}
        for name in ("gaps", "normals", "elements", "shapes", "distances", "heights", "facets", "outer"):
            buffer = Buffer(count, kinds.get(name, real), device)
            setattr(self, name, buffer)
            setattr(contacts, name, buffer.array)
        inputs = [slaves, real(reach), real(reach), masters, given, motion]
        self._command = Launch(point_contact.point_contacts, count, inputs, [contacts], device, GRAIN, falling=True)

    def set_thickness(self, thickness: np.ndarray) -> None:
        """Takes another thickness of the pairs, (n,) in their order."""
        self.thickness = thickness
        self._thickness.write(thickness)

    def launch(self, moved: float, farther: float = 0.0) -> None:
        """Evaluates all pairs within reach.

        Args:
            moved: how far any point has gone since the pairs were found, m.
            farther: m beyond the reach, up to where distances are found too.
        """
        seen = self._reach + farther
        if seen != self.seen:
            self.seen = seen
            self._command.set_param("seen", real(seen))
        count = int(np.searchsorted(self._found_at, seen + 2.0 * moved, side="right"))
        if count != len(self.reached):
            self.reached = np.arange(count)
            self._command.set_dim(count)
        self._change.write(np.array([2.0 * moved]))
        self._command.launch()

    def least_distances(self, errors: np.ndarray) -> np.ndarray:
        """How far the sub-triangles of each pair are at least in the state that was evaluated last, (n,), m; negative
        where the point may be through them.

        It may be so on the right side of the surface: between that and the sub-triangles, which lie within `errors`
        (ne,), m, of it.
        """
        at = self.reached
        least = np.full(len(self.keys), self.seen)
        least[at] = np.minimum(self.facets.read()[at], self.seen)
        sides = self.sides.read()[at]
        between = self.facets.read()[at] <= errors[self.elements.read()[at]]
        through = (np.abs(sides) == 1) & (between | (sides * self.distances.read()[at] < 0.0))
        least[at[through]] *= -1.0
        return least

    def sorted_by_key(self, where: np.ndarray) -> np.ndarray:
        """`where` in the order of the pairs' names, which does not depend on when they were found."""
        return where[np.argsort(self.keys[where])]
