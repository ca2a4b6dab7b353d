"""Gaps of given pairs of points and layers: the launches of the contact kernels."""

import numpy as np
import warp as wp

from warp_origami.kernels import nts, penalty, sts
from warp_origami.kernels.closest_point import Surface
from warp_origami.kernels.precision import real, vec3

from ..buffers import Buffer
from .search import LayerPairs


class SlaveKernels:
    """The kernels of a contact method; Warp compiles the module of a kernel when it is first launched, so only these.

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
            self.sts_stiffness = wp.array(integration_stiffness, dtype=real, device=device)
            self.modules += (self.sts.module.name,)
        if method in ("nts", "mixed"):
            self.nts = nts.nts_contacts
            self.modules += (self.nts.module.name,)

    def stiffness_of(self, points: np.ndarray) -> np.ndarray:
        """Stiffness of slave points, N/m."""
        result = np.full(len(points), self.node_stiffness)
        integration = points < self.sts_count
        result[integration] = self.integration_stiffness[points[integration]]
        return result


class NarrowPhase:
    """Recorded launches that evaluate a fixed list of pairs at the current positions.

    Attributes:
        pairs: the pairs.
        sts_pairs: number of them whose slave is an integration point; they come first.
        thickness: (n,) effective thickness, m.
        sides: (n,) buffer of +1, -1, FREE or UNKNOWN.
        gaps, forces, normals, triangles, weights, distances, heights, outer: buffers, see penalty.Contacts.
    """

    def __init__(
        self,
        pairs: LayerPairs,
        thickness: np.ndarray,
        sides: np.ndarray,
        slaves: wp.array,
        surface: Surface,
        kernels: SlaveKernels,
        reach: float,
        device: str,
    ):
        count = len(pairs.keys)
        self.pairs = pairs
        self.sts_pairs = int(np.searchsorted(pairs.points, kernels.sts_count))
        self.thickness = thickness
        self.sides = Buffer(count, wp.int32, device)
        self.sides.write(sides)
        given = penalty.Pairs()
        given.points = wp.array(pairs.points, dtype=wp.int32, device=device)
        given.starts = wp.array(pairs.starts, dtype=wp.int32, device=device)
        given.candidates = wp.array(pairs.candidates, dtype=wp.int32, device=device)
        given.thickness = wp.array(thickness, dtype=real, device=device)
        given.sides = self.sides.array

        found = penalty.Contacts()
        kinds = {"normals": vec3, "weights": vec3, "triangles": wp.int32, "outer": wp.bool}
        for name in ("gaps", "forces", "normals", "triangles", "weights", "distances", "heights", "outer"):
            buffer = Buffer(count, kinds.get(name, real), device)
            setattr(self, name, buffer)
            setattr(found, name, buffer.array)

        self._launches = []
        for kernel, stiffness, first, dim in (
            (kernels.sts, kernels.sts and kernels.sts_stiffness, 0, self.sts_pairs),
            (kernels.nts, real(kernels.node_stiffness), self.sts_pairs, count - self.sts_pairs),
        ):
            if kernel is not None and dim > 0:
                inputs = [slaves, stiffness, real(reach), first, surface, given]
                self._launches.append(
                    wp.launch(kernel, dim=dim, inputs=inputs, outputs=[found], device=device, record_cmd=True)
                )

    def launch(self) -> None:
        """Evaluates all pairs."""
        for command in self._launches:
            command.launch()
