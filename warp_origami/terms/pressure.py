"""Follower pressure: it stays normal to the sheet and acts on the area that was flat times the present stretch.

    F_i = int S_i (r_x x r_y) dA

Its tangent is symmetric up to an integral over the rim of the pressed region: with a held rim the pressure has a
potential, the enclosed volume. Source: K. Schweizerhof, E. Ramm, Displacement dependent pressure loads in nonlinear
finite element analyses, Computers & Structures 18 (1984) 1099-1114.
"""

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import pressure as kernels
from warp_origami.kernels.membrane import NODES
from warp_origami.kernels.precision import real, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

from . import row_sums
from .buffers import Buffer
from .launches import Launch
from .pressure_rim import PressureRim
from .row_sums import RowSums
from .shapes import tabulate

GAUSS = 6
"""Gauss points a side of the collapsed square: the constants have degree 4 + 3 + 3, and collapsing adds 1."""

GRAIN = 200
"""Elements, and rows of q, that are worth a thread."""

CHUNK = 2048
"""Elements whose constants are integrated at once: bounds the memory of the tabulated shape functions."""


class FollowerPressure:
    """Force of a unit pressure on a part of the sheet, positive along r_x x r_y, as a function of q (n, 3).

    All sums run in a fixed order: equal q gives bitwise equal results.

    Args:
        mesh: flat sheet.
        coordinates: numbering of q.
        elements: elements that are pressed, each once.
        device: of Warp, "cpu" or "cuda:0".

    Attributes:
        name: for summaries.
        kernel_modules: names of the Warp modules that are compiled for it.
    """

    name = "follower pressure"
    kernel_modules = (kernels.pressure_force.module.name, row_sums.KERNEL_MODULE)

    def __init__(self, mesh: Mesh, coordinates: Coordinates, elements: np.ndarray, device: str = "cpu") -> None:
        elements = np.unique(elements)
        self._device = device
        self._count = len(elements)
        self._q = Buffer(coordinates.count, vec3, device)
        constants, differences = (wp.array(c, dtype=real, device=device) for c in _constants(mesh, elements))
        inputs = [
            self._q.array,
            wp.array(coordinates.elements, dtype=wp.int32, device=device),
            wp.array(elements, dtype=wp.int32, device=device),
        ]
        self._stiffness_inputs = [*inputs, differences]
        element_force = wp.zeros((self._count, NODES), dtype=vec3, device=device)
        self._launch_force = self._record(kernels.pressure_force, self._count, [*inputs, constants], [element_force])
        self._sums = RowSums(coordinates.elements[elements], coordinates.count, element_force, device, GRAIN)
        self._launch_stiffness: Launch | None = None
        self._bound: int | None = None
        self._rim = PressureRim(mesh, coordinates, elements)

    def force(self, q: np.ndarray) -> np.ndarray:
        """(n, 3) nodal forces of a pressure of 1 Pa: m^2 in rows of positions, m^3 in rows of gradients."""
        self._q.write(q)
        self._launch_force.launch()
        return self._sums()

    def volume(self, q: np.ndarray) -> float:
        """1/3 int r . (r_x x r_y) dA, m^3: while the rim is held, the potential of the force."""
        return float(np.sum(q * self.force(q))) / 3.0

    def add_stiffness(self, q: np.ndarray, pressure: float, blocks: wp.array) -> None:
        """Adds the symmetric part of -pressure dF/dq to element tangents.

        Args:
            q: (n, 3).
            pressure: Pa.
            blocks: (ne, 45) Warp array of mat33 on this device, as `Membrane.blocks`; changed in place.
        """
        self._q.write(q)
        if self._bound != blocks.ptr:
            inputs = [*self._stiffness_inputs, float(pressure)]
            self._launch_stiffness = self._record(kernels.pressure_stiffness, self._count, inputs, [blocks])
            self._bound = blocks.ptr
        self._launch_stiffness.set_param("pressure", float(pressure))
        self._launch_stiffness.launch()

    def skew(self, q: np.ndarray) -> csr_matrix:
        """Antisymmetric part of dF/dq, (3n, 3n) of fixed structure, for motions that satisfy the fold condition."""
        return self._rim.skew(q)

    def _record(self, kernel: wp.Kernel, dim: int, inputs: list, outputs: list) -> Launch:
        return Launch(kernel, dim, inputs, outputs, self._device, GRAIN)


def _constants(mesh: Mesh, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(ne, 9, 36) e_ijk of the pairs j < k and (ne, 36, 9) e_ijk - e_jik of the pairs i < j, m^2 between positions."""
    areas, weights = _collapsed_rule(GAUSS)
    low, high = np.triu_indices(NODES, k=1)
    constants = np.empty((len(elements), NODES, len(low)))
    differences = np.empty((len(elements), len(low), NODES))
    for start in range(0, len(elements), CHUNK):
        chunk = elements[start : start + CHUNK]
        table = tabulate(mesh, np.repeat(chunk, len(areas)), np.tile(areas, (len(chunk), 1)))
        values = table.values.reshape(len(chunk), len(areas), NODES)
        x, y = table.gradients.reshape(len(chunk), len(areas), NODES, 2).transpose(3, 0, 1, 2)
        jacobians = x[:, :, low] * y[:, :, high] - x[:, :, high] * y[:, :, low]
        weighted = values * (mesh.areas[chunk, None] * weights)[:, :, None]
        found = weighted.transpose(0, 2, 1) @ jacobians
        full = np.zeros((len(chunk), NODES, NODES, NODES))
        full[:, :, low, high], full[:, :, high, low] = found, -found
        constants[start : start + CHUNK] = found
        differences[start : start + CHUNK] = full[:, low, high] - full[:, high, low]
    return constants, differences


def _collapsed_rule(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Area coordinates and weights (sum 1) of the Gauss rule on the square, one side collapsed; degree 2 points - 2."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    u, v = np.meshgrid(nodes, nodes, indexing="ij")
    first, second = u.ravel(), (v * (1.0 - u)).ravel()
    areas = np.stack([first, second, 1.0 - first - second], axis=1)
    return areas, (2.0 * np.outer(weights * (1.0 - nodes), weights)).ravel()
