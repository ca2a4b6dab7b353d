"""Springs along creases: the energy 1/2 k (theta - theta_0)^2 per flat length, theta the fold angle there.

theta is that of the cubic surfaces on both sides along the curved crease, at three Gauss points of each mesh edge. It
is followed beyond half a turn: of the angles that differ by full turns the one nearest to that of the last accepted
state is meant, at the start the one whose sign the letter of the crease has (M negative, V positive).
"""

import numpy as np
import warp as wp

from warp_origami.kernels import crease as kernels
from warp_origami.kernels.precision import real, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

from . import row_sums
from .buffers import Buffer
from .launches import Launch
from .row_sums import RowSums
from .shapes import tabulate
from .sparsity import pairs_of

POINTS = 3
"""Gauss points along a mesh edge: exact where angle and spring are quadratic."""

GRAIN = 100
"""Crease edges, and rows of q, that are worth a thread."""

SIGNS = {"M": -1.0, "V": 1.0, "U": 0.0}


class CreaseSprings:
    """Energy of springs along creases as a function of q (n, 3).

    All sums run in a fixed order: equal q gives bitwise equal results.

    Args:
        mesh: flat sheet.
        coordinates: numbering of q.
        edges: (k,) mesh edges that are creases; one may occur more than once.
        stiffness: (k,) moment per angle and flat length, N m/rad per m.
        rest: (k,) fold angle without moment, rad.
        device: of Warp, "cpu" or "cuda:0".

    Attributes:
        name: for summaries.
        kernel_modules: names of the Warp modules that are compiled for it.
        rows: (k, 18) rows of q that each spring joins.
        block_count: 3x3 blocks of all tangents.
    """

    name = "crease springs"
    kernel_modules = (kernels.crease_gradient.module.name, row_sums.KERNEL_MODULE)

    def __init__(
        self,
        mesh: Mesh,
        coordinates: Coordinates,
        edges: np.ndarray,
        stiffness: np.ndarray,
        rest: np.ndarray,
        device: str = "cpu",
    ) -> None:
        count = len(edges)
        self._device, self._count = device, count
        self.rows = coordinates.elements[mesh.edge_triangles[edges]].reshape(count, kernels.ROWS)
        self.block_count = count * pairs_of(kernels.ROWS)
        nodes, weights = np.polynomial.legendre.leggauss(POINTS)
        lengths = np.linalg.norm(np.diff(mesh.vertices[mesh.edges[edges]], axis=1)[:, 0], axis=1)
        self._q = Buffer(coordinates.count, vec3, device)
        self._reference = Buffer((count, POINTS), real, device)
        starts = np.array([0.5 * np.pi * SIGNS[str(letter)] for letter in mesh.edge_assignments[edges]])
        self._reference.write(np.repeat(starts[:, None], POINTS, axis=1))
        inputs = [
            self._q.array,
            wp.array(self.rows, dtype=wp.int32, device=device),
            wp.array(_derivatives(mesh, edges, 0.5 * (nodes + 1.0)), dtype=vec3, device=device),
            wp.array(np.outer(stiffness * lengths, 0.5 * weights), dtype=real, device=device),
            wp.array(np.asarray(rest, dtype=float), dtype=real, device=device),
            self._reference.array,
        ]
        self._inputs = inputs
        self._energy = Buffer(count, real, device)
        self._angles = Buffer((count, POINTS), real, device)
        edge_gradient = wp.zeros((count, kernels.ROWS), dtype=vec3, device=device)
        outputs = [self._energy.array, edge_gradient, self._angles.array]
        self._launch_gradient = Launch(kernels.crease_gradient, count, inputs, outputs, device, GRAIN)
        self._sums = RowSums(self.rows, coordinates.count, edge_gradient, device, 100 * GRAIN)
        self._launch_tangent: Launch | None = None
        self._bound: tuple[int, int] | None = None

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Energy (J) and its gradient (n, 3)."""
        self._q.write(q)
        self._launch_gradient.launch()
        return float(self._energy.read().sum()), self._sums()

    def add_tangent(self, q: np.ndarray, storage: Buffer, first: int, geometric: bool = True) -> None:
        """Writes the second derivatives of the pairs i <= j of `rows`, spring by spring.

        Args:
            q: (n, 3).
            storage: of mat33 on this device, changed from place `first` on.
            geometric: with the part of the moment; without it the tangent is positive.
        """
        self._q.write(q)
        if self._bound != (storage.array.ptr, first):
            inputs = [*self._inputs, geometric, first]
            self._launch_tangent = Launch(
                kernels.crease_tangent, self._count, inputs, [storage.array], self._device, max(GRAIN // 4, 1)
            )
            self._bound = (storage.array.ptr, first)
        self._launch_tangent.set_param("geometric", geometric)
        self._launch_tangent.launch()

    def angles(self, q: np.ndarray) -> np.ndarray:
        """(k, 3) fold angles at the Gauss points, rad."""
        self.gradient(q)
        return self._angles.read().copy()

    def accept(self, q: np.ndarray) -> None:
        """Angles are followed from those of q (n, 3) from now on."""
        self._reference.write(self.angles(q))

    def state(self) -> dict[str, np.ndarray]:
        """What it remembers, for a checkpoint."""
        return {"reference": self._reference.read().copy()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Takes what it remembers from `state`."""
        self._reference.write(state["reference"])


def _derivatives(mesh: Mesh, edges: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(k, points, 18, 3) shares of the rows of both elements in t, b_L and b_R at places 0 .. 1 along each edge."""
    ends = mesh.vertices[mesh.edges[edges]]
    tangents = (ends[:, 1] - ends[:, 0]) / np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[:, None]
    normals = np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
    shares = np.zeros((len(edges), len(places), 2, 9, 3))
    for side in (0, 1):
        elements = mesh.edge_triangles[edges, side]
        corners = [np.argmax(mesh.triangles[elements] == mesh.edges[edges, k][:, None], axis=1) for k in (0, 1)]
        areas = np.zeros((len(edges), len(places), 3))
        np.put_along_axis(areas, corners[0][:, None, None], (1.0 - places)[None, :, None], axis=2)
        np.put_along_axis(areas, corners[1][:, None, None], places[None, :, None], axis=2)
        table = tabulate(mesh, np.repeat(elements, len(places)), areas.reshape(-1, 3))
        gradients = table.gradients.reshape(len(edges), len(places), 9, 2)
        if side == 0:
            shares[:, :, 0, :, 0] = np.einsum("epid,ed->epi", gradients, tangents)
        shares[:, :, side, :, 1 + side] = np.einsum("epid,ed->epi", gradients, normals)
    return shares.reshape(len(edges), len(places), kernels.ROWS, 3)
