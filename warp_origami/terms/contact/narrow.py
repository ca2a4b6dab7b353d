"""Gaps of given pairs of points and layers: the launches of the contact kernels."""

import numpy as np
import warp as wp

from warp_origami.kernels import nts, point_gap, sts
from warp_origami.kernels.precision import real, vec3, vec9

from ..buffers import Buffer
from ..launches import Launch, launch_together
from .search import LayerPairs

GRAIN = 300
"""Pairs that are worth a thread: the nearest ones cost a microsecond each, the others a tenth of it."""


class SlaveKernels:
    """The kernels of a contact method, compiled now rather than when layers first come near each other in mid-run.

    Args:
        method: mixed, sts or nts.
        integration_stiffness: (sts_count,) eps_s w A / 2 of each integration point, N/m.
        node_stiffness: eps_n, N/m.
    """

    def __init__(self, method: str, integration_stiffness: np.ndarray, node_stiffness: float, device: str):
        self.sts_count = len(integration_stiffness)
        self.node_stiffness = node_stiffness
        self.integration_stiffness = integration_stiffness
        self.sts = self.nts = None
        self.modules: tuple[str, ...] = ()
        if method in ("sts", "mixed"):
            self.sts = sts.sts_contacts
            self.modules += (self.sts.module.name,)
        if method in ("nts", "mixed"):
            self.nts = nts.nts_contacts
            self.modules += (self.nts.module.name,)
        target = wp.get_device(device)
        for kernel in (self.sts, self.nts):
            if kernel is not None:  # Warp launches with blocks of 1 on the CPU, and compiles for each block size anew
                kernel.module.load(target, block_dim=1 if target.is_cpu else None)

    def stiffness_of(self, points: np.ndarray) -> np.ndarray:
        """Stiffness of slave points, N/m."""
        result = np.full(len(points), self.node_stiffness)
        integration = points < self.sts_count
        result[integration] = self.integration_stiffness[points[integration]]
        return result


class NarrowPhase:
    """Recorded launches that evaluate pairs at the current positions, only those that can be near by now.

    Pairs are held in the order of their distance when they were found, integration points before nodes: no pair beyond
    the first so many can have come within reach since.

    Attributes:
        keys, points: names and slave points of the pairs.
        sts_count: number of pairs whose slave is an integration point; they come first.
        thickness: (n,) distance at which each pair begins to press, m.
        sides: (n,) buffer of +1, -1, FREE or UNKNOWN.
        least: (n,) buffer of how far the sub-triangles were at least in the accepted state, m.
        gaps, normals, elements, shapes, distances, heights, facets, outer: buffers, see point_gap.Contacts.
        reached: pairs that the last launch has evaluated; all others are farther than the reach.
    """

    def __init__(
        self,
        pairs: LayerPairs,
        thickness: np.ndarray,
        sides: np.ndarray,
        layers: np.ndarray,
        slaves: wp.array,
        masters: point_gap.Masters,
        motion: point_gap.Motion,
        kernels: SlaveKernels,
        reach: float,
        device: str,
    ):
        count = len(pairs.keys)
        of_node = pairs.points >= kernels.sts_count
        order = np.lexsort((pairs.distances, of_node))
        self.sts_count = count - int(np.count_nonzero(of_node))
        self.keys, self.points = pairs.keys[order], pairs.points[order]
        self.thickness = thickness[order]
        self._reach = reach
        found_at = pairs.distances[order]
        self._groups = [
            (first, found_at[first:end], kernel)
            for first, end, kernel in ((0, self.sts_count, kernels.sts), (self.sts_count, count, kernels.nts))
            if end > first
        ]
        self._counts: tuple[int, ...] = ()
        self._seen = reach
        self.reached = np.zeros(0, dtype=int)

        self.sides = Buffer(count, wp.int32, device)
        self.sides.write(sides[order])
        given = point_gap.Pairs()
        given.points = wp.array(self.points, dtype=wp.int32, device=device)
        given.layers = wp.array(layers[order], dtype=wp.int32, device=device)
        given.starts = wp.array(pairs.starts[:-1][order], dtype=wp.int32, device=device)
        given.ends = wp.array(pairs.starts[1:][order], dtype=wp.int32, device=device)
        given.candidates = wp.array(pairs.candidates, dtype=wp.int32, device=device)
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
        self._launches = [
            Launch(
                kernel,
                len(found_at),
                [slaves, real(reach), real(reach), masters, given, motion],
                [contacts],
                device,
                GRAIN,
                begin=first,
                falling=True,
            )
            for first, found_at, kernel in self._groups
        ]

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
        counts = tuple(int(np.searchsorted(g[1], seen + 2.0 * moved, side="right")) for g in self._groups)
        if seen != self._seen:
            self._seen = seen
            for command in self._launches:
                command.set_param("seen", real(seen))
        if counts != self._counts:
            self._counts = counts
            self.reached = np.concatenate([g[0] + np.arange(n) for g, n in zip(self._groups, counts, strict=True)])
        for command, count in zip(self._launches, counts, strict=True):
            command.set_dim(count)
        launch_together(self._launches)

    def least_distances(self) -> np.ndarray:
        """How far the sub-triangles of each pair are at least in the state that was evaluated last, (n,), m."""
        least = np.full(len(self.keys), self._seen)
        least[self.reached] = np.minimum(self.facets.read()[self.reached], self._seen)
        return least

    def sorted_by_key(self, where: np.ndarray) -> np.ndarray:
        """`where` in the order of the pairs' names, which does not depend on when they were found."""
        return where[np.argsort(self.keys[where])]
