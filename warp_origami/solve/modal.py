"""Modal analysis: small free vibrations about an equilibrium, on the constrained system.

    T^T K T y = omega^2 T^T M T y,   f = omega / (2 pi),   q = q_0 + T y

with K the tangent at the equilibrium (strain, contact, pressure). Small systems are solved densely, large ones by
block Lanczos with a shift just below the lowest eigenvalue, so that K - shift M is positive definite.

Eigenvalues are known to the round-off of the largest one, which belongs to stretching the smallest element: those that
it hides (rigid motions, sheets without stress) are reported as zero.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_matrix, csr_matrix

from warp_origami.system import System
from warp_origami.terms.external import ExternalForce
from warp_origami.terms.symmetric import symmetric_part

from .block_lanczos import lowest_pairs
from .linear import Factor, choose_solver
from .reduced_tangent import ReducedTangent
from .result import Failure

DENSE = 500
"""Unknowns up to which all eigenvalues are found at once."""

RESOLUTION = 100.0 * np.finfo(float).eps
"""Round-off of the eigenvalues over the largest one."""

SMALLEST_SHIFT = 1e-10
"""Over the largest eigenvalue: where a tangent that may be singular is shifted to, well above its round-off."""

SHIFTS = 11
"""How many shifts, each ten times the last, are tried before the lowest eigenvalue is found."""

AMPLITUDE = 0.1
"""Largest displacement of a drawn mode over the size of the sheet."""

FRAMES = 16
"""Drawn frames of a period."""

SKEW = (
    "the follower pressure or sunlight acts on a free edge, where it has no potential: the skew part of its tangent, "
    "by which such a sheet can gain or lose energy as it vibrates, is left out of the frequencies"
)

COUPLED = 1e-3
"""Skew stiffness between two modes over the root of the product of their eigenvalues, from which on it matters: it
changes these by the square."""

UNSTABLE = "the equilibrium is unstable: negative frequencies stand for motion that grows"


@dataclass(frozen=True)
class ModeShapes:
    """The lowest modes.

    Attributes:
        frequencies: (k,) Hz, increasing; minus the root of minus the eigenvalue over 2 pi where that is negative: the
            equilibrium is unstable. Zero where round-off hides the eigenvalue.
        shapes: (k, n, 3) with unit modal mass, 1 / sqrt(kg).
        remark: what the user should know of them, None if there is nothing.
    """

    frequencies: np.ndarray
    shapes: np.ndarray
    remark: str | None = None

    def motion(self, q: np.ndarray, system: System) -> Iterator[tuple[float, np.ndarray]]:
        """Times (s) and states (n, 3) of an animation in which mode k goes through one period from k s to k + 1 s."""
        # exactly as many different numbers as there are different frames, which the file then stores once
        quarter = np.sin(0.5 * np.pi * np.arange(FRAMES // 4 + 1) / (FRAMES // 4))
        half = np.concatenate([quarter, quarter[-2:0:-1]])
        period = np.concatenate([half, -half])
        for k, shape in enumerate(self.shapes):
            largest = system.displacement(shape)
            scaled = AMPLITUDE * system.mesh.size / largest * shape
            for frame, part in enumerate(period):
                yield k + frame / FRAMES, q + part * scaled
        yield float(len(self.shapes)), q


class Modes:
    """Finds the modes of one system; constraints are eliminated whatever form Newton uses."""

    def __init__(self, system: System):
        self.system = system
        self.count = system.scene.analysis.count
        with system.clock.phase("setup"):
            self.null_space = system.constraints.null_space
            self.tangent = ReducedTangent(system, self.null_space, system.mass)
            self.mass = self.tangent.sparsity.matrix(self.tangent.metric_values)
        self.solver = choose_solver(system.scene.integrator.linear_solver, self.null_space.shape[1], "definite")

    def find(self, q: np.ndarray, external: ExternalForce) -> ModeShapes | Failure:
        """The lowest modes about the equilibrium q (n, 3); fewer than asked for where there are fewer unknowns.

        The skew part of the tangent of follower pressure on a free edge is left out, with a remark where it matters.
        """
        clock = self.system.clock
        linearization = self.system.linearize(q, external)
        with clock.phase("assembly"):
            stiffness = self.tangent.symmetric(linearization, 0.0, 0.0).full()
        size = stiffness.shape[0]
        count = min(self.count, size)
        if count == 0:
            return ModeShapes(np.empty(0), np.empty((0, *q.shape)), "everything is held")
        resolution = RESOLUTION * float(np.max(np.abs(stiffness.diagonal()) / self.mass.diagonal()))
        with clock.phase("solve"):
            if size <= max(DENSE, 4 * count):
                pairs = eigh(stiffness.toarray(), self.mass.toarray(), subset_by_index=(0, count - 1))
            else:
                pairs = self._lanczos(stiffness, count, resolution)
        if isinstance(pairs, Failure):
            return pairs
        values, vectors = pairs
        values = np.where(np.abs(values) <= resolution, 0.0, values)
        shapes = (self.null_space @ vectors).T.reshape(count, -1, 3)
        frequencies = np.sign(values) * np.sqrt(np.abs(values)) / (2.0 * np.pi)
        coupled = _coupling(linearization.skew, shapes.reshape(count, -1), values) > COUPLED
        remarks = ([SKEW] if coupled else []) + ([UNSTABLE] if np.any(values < 0.0) else [])
        return ModeShapes(frequencies, shapes, "; ".join(remarks) or None)

    def _lanczos(self, stiffness: csc_matrix, count: int, resolution: float) -> tuple[np.ndarray, np.ndarray] | Failure:
        factor = self._factorize(stiffness, resolution / RESOLUTION)
        if factor is None:
            return Failure("the tangent cannot be factorized", "supports, or loads that stretch the sheet")
        pairs = lowest_pairs(stiffness, self.mass, factor, count, resolution)
        return Failure("the frequencies cannot be told apart", "another analysis.count") if pairs is None else pairs

    def _factorize(self, stiffness: csc_matrix, largest: float) -> Factor | None:
        """Factor of K - shift M, the shift below the lowest eigenvalue."""
        for power in range(SHIFTS):
            shift = -SMALLEST_SHIFT * largest * 10.0**power
            factor = self.solver.factorize(symmetric_part(stiffness - shift * self.mass))
            if factor is not None:
                return factor
        return None


def _coupling(skew: csr_matrix | None, shapes: np.ndarray, values: np.ndarray) -> float:
    """Largest skew stiffness between two of the modes (k, 3n), relative to their eigenvalues."""
    if skew is None:
        return 0.0
    stiffness = np.abs(shapes @ (skew @ shapes.T))
    scale = np.sqrt(np.abs(np.outer(values, values)))
    return float(np.max(stiffness / np.where(scale > 0.0, scale, np.inf), initial=0.0))
