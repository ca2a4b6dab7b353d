"""Modal analysis: small free vibrations about an equilibrium, by shift-invert Lanczos on the constrained system.

    T^T K T y = omega^2 T^T M T y,   f = omega / (2 pi),   q = q_0 + T y

with K the tangent at the equilibrium (strain, contact, pressure). The shift lies just below the lowest eigenvalue, so
that K - shift M is positive definite, and Lanczos finds the eigenvalues next to it: the lowest. A count of negative
pivots above the highest one tells whether any was missed.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from warp_origami.system import System
from warp_origami.terms.external import ExternalForce

from .constraint_form import ReducedTangent
from .linear import Factor, choose_solver, negative_pivots
from .result import Failure

DENSE = 1000
"""Unknowns up to which all eigenvalues are found at once."""

SMALLEST_SHIFT = 1e-9
"""Over the square of the lowest circular frequency of stretching the sheet: where a singular tangent is shifted to."""

SHIFTS = 13
"""How many shifts, each ten times the last, are tried before the lowest eigenvalue is found."""

BORDER = 1e-4
"""How far above the highest wanted eigenvalue, relative to it, eigenvalues are counted."""

AMPLITUDE = 0.1
"""Largest displacement of a drawn mode over the size of the sheet."""

FRAMES = 16
"""Drawn frames of a period."""


@dataclass(frozen=True)
class ModeShapes:
    """The lowest modes.

    Attributes:
        frequencies: (k,) Hz, increasing; minus the root of minus the eigenvalue over 2 pi where that is negative: the
            equilibrium is unstable.
        shapes: (k, n, 3) with unit modal mass, 1 / sqrt(kg).
    """

    frequencies: np.ndarray
    shapes: np.ndarray

    def motion(self, q: np.ndarray, system: System) -> Iterator[tuple[float, np.ndarray]]:
        """Times (s) and states (n, 3) of an animation in which mode k goes through one period from k s to k + 1 s."""
        for k, shape in enumerate(self.shapes):
            largest = np.max(system.row_lengths * np.linalg.norm(shape, axis=1))
            scaled = AMPLITUDE * system.mesh.size / largest * shape
            for frame in range(FRAMES):
                yield k + frame / FRAMES, q + np.sin(2.0 * np.pi * frame / FRAMES) * scaled


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

        The skew part of the tangent of follower pressure on a free edge, which has no place in free vibrations without
        exchange of energy, is left out.
        """
        clock = self.system.clock
        linearization = self.system.linearize(q, external)
        with clock.phase("assembly"):
            stiffness, _ = self.tangent.matrix(linearization, 0.0, 0.0)
            if linearization.skew is not None:
                stiffness = csc_matrix(0.5 * (stiffness + stiffness.T))
        size = stiffness.shape[0]
        count = min(self.count, size)
        with clock.phase("solve"):
            if size <= max(DENSE, 4 * count):
                limits = (0, count - 1)
                pairs = eigh(stiffness.toarray(), self.mass.toarray(), subset_by_index=limits)
            else:
                pairs = self._lanczos(stiffness, count)
        if isinstance(pairs, Failure):
            return pairs
        values, vectors = pairs
        shapes = (self.null_space @ vectors).T.reshape(count, -1, 3)
        frequencies = np.sign(values) * np.sqrt(np.abs(values)) / (2.0 * np.pi)
        return ModeShapes(frequencies, shapes)

    def _lanczos(self, stiffness: csc_matrix, count: int) -> tuple[np.ndarray, np.ndarray] | Failure:
        shifted = self._shift(stiffness)
        if isinstance(shifted, Failure):
            return shifted
        shift, factor = shifted
        size = stiffness.shape[0]
        inverse = LinearOperator((size, size), matvec=factor.solve, dtype=float)
        start = np.random.default_rng(0).standard_normal(size)
        wanted = count
        while True:
            space = min(size - 1, max(2 * wanted + 20, 60))
            try:
                values, vectors = eigsh(
                    stiffness, wanted, self.mass, sigma=shift, OPinv=inverse, v0=start, ncv=space, tol=1e-12
                )
            except ArpackNoConvergence:
                return Failure("Lanczos did not converge", "a smaller analysis.count")
            order = np.argsort(values)
            values, vectors = values[order], vectors[:, order]
            border = values[count - 1] + BORDER * (abs(values[count - 1]) - shift)
            missed = negative_pivots((stiffness - border * self.mass).tocsc()) - int(np.sum(values < border))
            if missed <= 0:
                return values[:count], vectors[:, :count]
            wanted = min(wanted + missed, size - 2)

    def _shift(self, stiffness: csc_matrix) -> tuple[float, Factor] | Failure:
        """A shift below the lowest eigenvalue, and the factor of K - shift M."""
        material, length = self.system.scene.material, self.system.mesh.size
        stretching = np.pi**2 * material.youngs_modulus / material.density / length**2
        for power in range(SHIFTS):
            shift = -SMALLEST_SHIFT * stretching * 10.0**power
            factor = self.solver.factorize((stiffness - shift * self.mass).tocsc())
            if factor is not None:
                return shift, factor
        return Failure("the tangent cannot be factorized", "supports, or loads that stretch the sheet")
