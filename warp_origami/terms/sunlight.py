"""Solar radiation pressure on a film: it follows the present normal and lights whichever side faces the sun.

The law of a flat plate (kernels/sunlight.py) holds at every point of the sheet. Nothing shades anything: a layer behind
another one is lit as well, and light that is reflected from one part does not reach another. The tangent is exact; its
skew part is kept apart, for the force has no potential.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import sunlight as kernels
from warp_origami.kernels.membrane import NODES
from warp_origami.kernels.precision import mat33, real, vec2, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

from . import row_sums
from .buffers import Buffer
from .launches import Launch
from .quadrature import rule
from .row_sums import RowSums
from .shapes import tabulate

DEGREE = 8
"""Of the quadrature rule: exact for the shape functions times an area vector of degree 4."""

GRAIN = 150
"""Elements, and rows of q, that are worth a thread."""


@dataclass(frozen=True)
class Side:
    """Optical constants of one side of the sheet, all from 0 to 1.

    Attributes:
        reflectivity: share of the light that is reflected.
        specular: share of that which is reflected as by a mirror; the rest is diffuse.
        emissivity: of heat radiation.
        lambertian: non-Lambertian coefficient B of diffuse and heat radiation; 2/3 is Lambertian.
    """

    reflectivity: float = 1.0
    specular: float = 1.0
    emissivity: float = 0.0
    lambertian: float = 2.0 / 3.0


def coefficients(lit: Side, other: Side) -> tuple[float, float, float]:
    """1 - rho_s, 2 rho_s and e of a lit side."""
    mirrored = lit.reflectivity * lit.specular
    diffuse, absorbed = lit.reflectivity - mirrored, 1.0 - lit.reflectivity
    emitted = lit.emissivity + other.emissivity
    surplus = lit.emissivity * lit.lambertian - other.emissivity * other.lambertian
    heat = absorbed * surplus / emitted if emitted > 0.0 else 0.0
    return 1.0 - mirrored, 2.0 * mirrored, lit.lambertian * diffuse + heat


class Sunlight:
    """Force of light of 1 Pa on a part of the sheet, as a function of q (n, 3); as FollowerPressure otherwise.

    Args:
        mesh: flat sheet.
        coordinates: numbering of q.
        elements: elements that may be lit, each once.
        direction: (3,) where the light goes.
        front, back: the side from which the flat sheet is seen counter-clockwise, and the other one.
        device: of Warp, "cpu" or "cuda:0".

    Attributes:
        name: for summaries.
        kernel_modules: names of the Warp modules that are compiled for it.
    """

    name = "solar radiation pressure"
    kernel_modules = (kernels.sunlight_force.module.name, row_sums.KERNEL_MODULE)

    def __init__(
        self,
        mesh: Mesh,
        coordinates: Coordinates,
        elements: np.ndarray,
        direction: np.ndarray,
        front: Side,
        back: Side,
        device: str = "cpu",
    ) -> None:
        elements = np.unique(elements)
        count = len(elements)
        self._device, self._count, self._size = device, count, 3 * coordinates.count
        areas, weights = rule(DEGREE)
        table = tabulate(mesh, np.repeat(elements, len(areas)), np.tile(areas, (count, 1)))
        light = kernels.Light()
        light.direction = vec3(*(np.asarray(direction, dtype=float) / np.linalg.norm(direction)))
        light.front, light.back = vec3(*coefficients(front, back)), vec3(*coefficients(back, front))
        self._q = Buffer(coordinates.count, vec3, device)
        self._lit = wp.array(elements, dtype=wp.int32, device=device)
        inputs = [
            self._q.array,
            wp.array(coordinates.elements, dtype=wp.int32, device=device),
            self._lit,
            wp.array(table.values.reshape(count, len(areas), NODES), dtype=real, device=device),
            wp.array(table.gradients.reshape(count, len(areas), NODES, 2), dtype=vec2, device=device),
            wp.array(np.outer(mesh.areas[elements], weights), dtype=real, device=device),
            light,
        ]
        element_force = wp.zeros((count, NODES), dtype=vec3, device=device)
        self._tangents = Buffer((count, NODES, NODES), mat33, device)
        self._launch_force = Launch(kernels.sunlight_force, count, inputs, [element_force], device, GRAIN)
        self._launch_tangent = Launch(kernels.sunlight_tangent, count, inputs, [self._tangents.array], device, GRAIN)
        self._rows = coordinates.elements[elements].astype(np.int64)
        self._sums = RowSums(self._rows, coordinates.count, element_force, device, 50 * GRAIN)
        self._launch_add: Launch | None = None
        self._bound: int | None = None

    def force(self, q: np.ndarray) -> np.ndarray:
        """(n, 3) nodal forces of light of 1 Pa: m^2 in rows of positions, m^3 in rows of gradients."""
        self._q.write(q)
        self._launch_force.launch()
        return self._sums()

    def add_stiffness(self, q: np.ndarray, pressure: float, blocks: wp.array) -> None:
        """Adds the symmetric part of -pressure dF/dq to element tangents, as FollowerPressure does."""
        self._q.write(q)
        self._launch_tangent.launch()
        if self._bound != blocks.ptr:
            inputs = [self._tangents.array, self._lit, float(pressure)]
            self._launch_add = Launch(kernels.add_symmetric_part, self._count, inputs, [blocks], self._device, GRAIN)
            self._bound = blocks.ptr
        self._launch_add.set_param("pressure", float(pressure))
        self._launch_add.launch()

    def skew(self, q: np.ndarray) -> csr_matrix:
        """(3n, 3n) antisymmetric part of dF/dq."""
        self._q.write(q)
        self._launch_tangent.launch()
        full = self._tangents.read().transpose(0, 1, 3, 2, 4).reshape(self._count, 3 * NODES, 3 * NODES)
        entries = (3 * self._rows[:, :, None] + np.arange(3)).reshape(self._count, 3 * NODES)
        row, column = np.repeat(entries, 3 * NODES, axis=1), np.tile(entries, (1, 3 * NODES))
        values = 0.5 * (full - full.transpose(0, 2, 1))
        return csr_matrix((values.ravel(), (row.ravel(), column.ravel())), shape=(self._size, self._size))
