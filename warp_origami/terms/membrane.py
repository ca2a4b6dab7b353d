"""Elastic forces of the sheet: strain energy, gradient, tangent and stress, paper (16)-(21)."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import warp as wp

from warp_origami.errors import InputError
from warp_origami.kernels import linear, srm
from warp_origami.kernels.membrane import NODES, PAIRS, membrane_kernels
from warp_origami.kernels.precision import mat33, real, vec2, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

from . import row_sums
from .buffers import Buffer
from .launches import Launch
from .quadrature import rule
from .row_sums import RowSums
from .shapes import ShapeTable, tabulate

LAWS = {law.NAME: law for law in (srm, linear)}
SLACK, WRINKLED, TAUT = srm.SLACK, srm.WRINKLED, srm.TAUT

TANGENT_GRAIN, GRADIENT_GRAIN, GATHER_GRAIN = 40, 150, 8000
"""Elements, and rows of q, that are worth a thread: 3 to 7, 1 and 0.02 us each."""


class Material(Protocol):
    """What the membrane needs to know: Young's modulus (Pa), Poisson's ratio, thickness (m), law, stiffness ratios."""

    youngs_modulus: float
    poisson_ratio: float
    thickness: float
    model: str
    s1: float
    s2: float


@dataclass(frozen=True)
class StressSample:
    """Stress at n points.

    Attributes:
        s1: (n,) larger principal second Piola-Kirchhoff stress, Pa.
        s2: (n,) smaller one, Pa.
        von_mises: (n,) equivalent stress (59), Pa.
        state: (n,) int32, 0 slack, 1 wrinkled, 2 taut (the linear law: always 2).
    """

    s1: np.ndarray
    s2: np.ndarray
    von_mises: np.ndarray
    state: np.ndarray


class Membrane:
    """Strain energy of the sheet as a function of the generalized coordinates q (n, 3).

    All sums run in a fixed order: equal q gives bitwise equal results.

    Args:
        mesh: flat sheet.
        coordinates: numbering of q.
        material: law and constants.
        degree: of the quadrature rule (6: 12 points).
        device: of Warp, "cpu" or "cuda:0".
        room: blocks of the tangents of other terms, which follow those of the elements in memory.

    Attributes:
        name: for summaries, e.g. "membrane (srm)".
        kernel_modules: names of the Warp modules that are compiled for it.
        blocks: (ne, 45) Warp array of mat33, the element tangents of the last `linearize` on the device.
        storage: Buffer of mat33, (45 ne + room,): these and what follows them.

    Raises:
        InputError: unknown material model.
    """

    def __init__(
        self,
        mesh: Mesh,
        coordinates: Coordinates,
        material: Material,
        degree: int = 6,
        device: str = "cpu",
        room: int = 0,
    ) -> None:
        if material.model not in LAWS:
            raise InputError("material.model", material.model, " or ".join(LAWS))
        law = LAWS[material.model]
        self._kernels = membrane_kernels(law)
        self._device = device
        self._law, self._material = law, material
        self._parameters = self._parameters_of(material.s1, material.s2)
        self.name = f"membrane ({law.NAME}, linear elements)" if mesh.linear else f"membrane ({law.NAME})"
        self.kernel_modules = (self._kernels.module, row_sums.KERNEL_MODULE)

        count = len(mesh.triangles)
        areas, weights = rule(degree)
        table = tabulate(mesh, np.repeat(np.arange(count), len(areas)), np.tile(areas, (count, 1)))
        volumes = material.thickness * mesh.areas[:, None] * weights
        self._fractions = np.outer(mesh.areas / mesh.areas.sum(), weights).ravel()
        self._q = Buffer(coordinates.count, vec3, device)
        self._elements = wp.array(coordinates.elements, dtype=wp.int32, device=device)
        self._quadrature = self._prepare(table)
        shapes = self._quadrature.shapes.reshape((count, len(areas), NODES))
        inputs = [self._q.array, self._elements, shapes, wp.array(volumes, device=device), self._parameters]

        self._energy = Buffer(count, real, device)
        element_gradient = wp.zeros((count, NODES), dtype=vec3, device=device)
        self.storage = Buffer(count * PAIRS + room, mat33, device)
        self.blocks = self.storage.array[: count * PAIRS].reshape((count, PAIRS))
        outputs = [self._energy.array, element_gradient]
        self._launch_gradient = Launch(self._kernels.gradient, count, inputs, outputs, device, GRADIENT_GRAIN)
        self._strains = wp.zeros((count, len(areas)), dtype=vec3, device=device)
        self._launch_tangent = Launch(
            self._kernels.tangent,
            count,
            [*inputs, self._strains, False, True],
            [*outputs, self.blocks],
            device,
            TANGENT_GRAIN,
        )
        self._step = Buffer(coordinates.count, vec3, device)
        along = [self._q.array, self._step.array, self._elements, shapes, self._parameters, real(1.0), False]
        self._launch_strains = Launch(self._kernels.strains, count, along, [self._strains], device, GRADIENT_GRAIN)

        elements = coordinates.elements
        self._gathered = RowSums(elements, coordinates.count, element_gradient, device, GATHER_GRAIN)

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Strain energy (J) and its gradient (n, 3): minus the elastic forces (21)."""
        self._q.write(q)
        self._launch_gradient.launch()
        return self._sums()

    def linearize(self, q: np.ndarray, mixed: bool = False, geometric: bool = True) -> tuple[float, np.ndarray]:
        """Like `gradient`, and leaves the element tangents in `blocks` on the device.

        Args:
            mixed: the law is that at the strains of `take_strains` and `advance_strains`, continued linearly to those
                of q; the geometric part of the tangents has the stress at these strains themselves.
            geometric: the tangents have their geometric part.
        """
        self._q.write(q)
        self._launch_tangent.set_param("mixed", mixed)
        self._launch_tangent.set_param("geometric", geometric)
        self._launch_tangent.launch()
        return self._sums()

    def take_strains(self, q: np.ndarray) -> None:
        """The strains of the mixed iteration are those of q (n, 3) from now on."""
        self._q.write(q)
        self._launch_strains.set_param("afresh", True)
        self._launch_strains.launch()

    def advance_strains(self, q: np.ndarray, step: np.ndarray, length: float) -> None:
        """Takes the strains of the mixed iteration a part `length` of the way to those linearized at q (n, 3) along
        `step` (n, 3), or to what the law has instead of them."""
        self._q.write(q)
        self._step.write(step)
        self._launch_strains.set_param("afresh", False)
        self._launch_strains.set_param("length", real(length))
        self._launch_strains.launch()

    def tangent(self, q: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Strain energy (J), its gradient (n, 3) and the element tangents (ne, 45, 3, 3) of the pairs i <= j.

        On the CPU the tangents are a view that the next call overwrites.
        """
        energy, gradient = self.linearize(q)
        return energy, gradient, self.storage.read()[: self.blocks.size].reshape(*self.blocks.shape, 3, 3)

    def set_stiffness_ratios(self, s1: float, s2: float) -> None:
        """Evaluates forces and tangents with other stiffness ratios than the material's from now on."""
        parameters = self._parameters_of(s1, s2)
        for launch in (self._launch_gradient, self._launch_tangent, self._launch_strains):
            launch.set_param("parameters", parameters)

    def _parameters_of(self, s1: float, s2: float):
        return self._law.parameters(self._material.youngs_modulus, self._material.poisson_ratio, s1, s2)

    def sampler(self, table: ShapeTable) -> "StressSampler":
        """Stress at the points of `table`, for repeated use."""
        return self._prepare(table)

    def stress(self, q: np.ndarray, table: ShapeTable) -> StressSample:
        """Stress at the points of `table`, once."""
        return self.sampler(table)(q)

    def state_fractions(self, q: np.ndarray) -> tuple[float, float, float]:
        """Fractions of the flat area that are taut, wrinkled and slack, from the states at the quadrature points."""
        _, state = self._quadrature.evaluate(q)
        taut, wrinkled, slack = (float(self._fractions @ (state == k)) for k in (TAUT, WRINKLED, SLACK))
        return taut, wrinkled, slack

    def _sums(self) -> tuple[float, np.ndarray]:
        return float(self._energy.read().sum()), self._gathered()

    def _prepare(self, table: ShapeTable) -> "StressSampler":
        count = len(table.elements)
        shapes = wp.array(table.gradients, dtype=vec2, device=self._device)
        stress = Buffer(count, vec2, self._device)
        state = Buffer(count, wp.int32, self._device)
        points = wp.array(table.elements, dtype=wp.int32, device=self._device)
        inputs = [self._q.array, self._elements, points, shapes, self._parameters]
        launch = wp.launch(
            self._kernels.sample,
            dim=count,
            inputs=inputs,
            outputs=[stress.array, state.array],
            device=self._device,
            record_cmd=True,
        )
        return StressSampler(self._q, shapes, launch, stress, state)


@dataclass(frozen=True)
class StressSampler:
    """Stress of a membrane at fixed points: call it with q."""

    q: Buffer
    shapes: wp.array
    launch: wp.Launch
    principal_stress: Buffer
    state: Buffer

    def evaluate(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Principal stresses (n, 2), Pa, and states (n,); on the CPU views that the next call overwrites."""
        self.q.write(q)
        self.launch.launch()
        return self.principal_stress.read(), self.state.read()

    def __call__(self, q: np.ndarray) -> StressSample:
        """Stress at the points for coordinates q (n, 3)."""
        stress, state = self.evaluate(q)
        s1, s2 = stress[:, 0].copy(), stress[:, 1].copy()
        return StressSample(s1, s2, np.sqrt(s1 * s1 - s1 * s2 + s2 * s2), state.copy())
