"""The two ways to hold C q = d(t) in a Newton step: eliminate exactly, or keep the multipliers of (58).

With J = K + m G, G a constant positive definite matrix (mass in dynamics), elimination solves T^T J T y = -T^T g. The
multiplier form solves, with the scaling of C. L. Bottasso, D. Dopico and L. Trainelli (Multibody System Dynamics 19
(2008) 3-20: dynamics by beta h^2, multipliers by h^2),

    [ s J   C^T ] [ d        ]   [ -s g ]
    [ C     0   ] [ s lambda ] = [  0   ],    s = 1 / (m g)

where g is the mean diagonal of G, so that both blocks are of order one; in dynamics 1 / m is beta h^2 up to a constant
of the method. Every iterate satisfies C q = d(t), the equations being linear. Both give the same step.
"""

from typing import Protocol

import numpy as np
from scipy.sparse import bmat, csr_matrix, identity

from warp_origami.clock import PhaseClock
from warp_origami.system import Linearization, System
from warp_origami.terms.padded_pattern import PaddedPattern
from warp_origami.terms.symmetric import SymmetricMatrix

from .bordered import BorderedPattern
from .linear import Factor, LinearSolver, choose_solver
from .reduced_tangent import ReducedTangent


class ConstraintForm(Protocol):
    """Newton directions that stay within the constraints.

    Attributes:
        name: for summaries.
        solver: of symmetric systems.
        solves: systems solved so far.
        padding: memory of what touched, by which the order of elimination depends on what went before; None without
            contact.
    """

    name: str
    solver: LinearSolver
    solves: int
    padding: PaddedPattern | None

    def factorize(self, linearization: Linearization, multiple: float, damping: float) -> "NewtonFactor | None":
        """Factor of J = K + multiple G + damping K_0, None if it cannot be factorized."""

    def hold_damping(self, linearization: Linearization) -> None:
        """Keeps K_0 of the linearization as the matrix of stiffness damping."""


class NewtonFactor(Protocol):
    """A factorized J; it is of use until its form factorizes the next one."""

    def direction(self, gradient: np.ndarray) -> np.ndarray:
        """(3n,) d that minimizes gradient . d + d . J d / 2 over C d = 0."""


class Eliminated:
    """Constraints eliminated through the null space: y = slopes along creases and free coordinates."""

    name = "eliminate"

    def __init__(self, system: System, linear_solver: str, metric: csr_matrix):
        self.clock: PhaseClock = system.clock
        self.null_space = system.constraints.null_space
        self.transposed = self.null_space.T.tocsr()
        self.tangent = ReducedTangent(system, self.null_space, metric)
        self.padding = self.tangent.padded if system.contact is not None else None
        self.solver = choose_solver(linear_solver, self.null_space.shape[1], "definite", system.device)
        self.general_solver = choose_solver(linear_solver, self.null_space.shape[1], "general", system.device)
        self._last: _EliminatedFactor | None = None
        self.solves = 0

    def hold_damping(self, linearization: Linearization) -> None:
        self.tangent.hold_damping(linearization)

    def factorize(self, linearization: Linearization, multiple: float, damping: float) -> "NewtonFactor | None":
        with self.clock.phase("assembly"):
            matrix = self.tangent.symmetric(linearization, multiple, damping)
            skew = self.tangent.skew(linearization, np.abs(matrix.values).max(initial=0.0), multiple)
            given, solver = (matrix, self.solver) if skew is None else (matrix.full() + skew, self.general_solver)
        if self._last is not None:
            self._last.factor = None  # its memory serves the next one
        with self.clock.phase("factorization"):
            factor = solver.factorize(given)
        self._last = None if factor is None else _EliminatedFactor(self, factor)
        return self._last


class _EliminatedFactor:
    def __init__(self, form: Eliminated, factor: Factor):
        self.form = form
        self.factor: Factor | None = factor

    def direction(self, gradient: np.ndarray) -> np.ndarray:
        self.form.solves += 1
        right = -(self.form.transposed @ gradient)
        with self.form.clock.phase("solve"):
            return self.form.null_space @ self.factor.solve(right)


class Multipliers:
    """Constraints kept, with their multipliers as further unknowns."""

    name = "multipliers"

    def __init__(self, system: System, linear_solver: str, metric: csr_matrix, least_multiple: float):
        self.clock: PhaseClock = system.clock
        size = 3 * system.coordinates.count
        self.equations = system.constraints.equations
        self.tangent = ReducedTangent(system, identity(size, format="csr"), metric)
        self.padding = self.tangent.padded if system.contact is not None else None
        self.mean_metric = float(np.mean(metric.diagonal()))
        self.least_multiple = least_multiple
        self.solver = choose_solver(linear_solver, size + self.equations.shape[0], "indefinite", system.device)
        self.general_solver = choose_solver(linear_solver, size + self.equations.shape[0], "general", system.device)
        self.bordered: BorderedPattern | None = None
        self._last: _MultiplierFactor | None = None
        self.solves = 0

    def hold_damping(self, linearization: Linearization) -> None:
        self.tangent.hold_damping(linearization)

    def factorize(self, linearization: Linearization, multiple: float, damping: float) -> "NewtonFactor | None":
        scale = 1.0 / (max(multiple, self.least_multiple) * self.mean_metric)
        with self.clock.phase("assembly"):
            matrix = self.tangent.symmetric(linearization, multiple, damping)
            skew = self.tangent.skew(linearization, np.abs(matrix.values).max(initial=0.0), multiple)
            if skew is None:
                given, solver = self._bordered(matrix, scale), self.solver
            else:
                tangent = scale * (matrix.full() + skew)
                given = bmat([[tangent, self.equations.T], [self.equations, None]], format="csc")
                solver = self.general_solver
        if self._last is not None:
            self._last.factor = None  # its memory serves the next one
        with self.clock.phase("factorization"):
            factor = solver.factorize(given)
        self._last = None if factor is None else _MultiplierFactor(self, factor, scale)
        return self._last

    def _bordered(self, matrix: SymmetricMatrix, scale: float) -> SymmetricMatrix:
        """The matrix of the multiplier form."""
        if self.bordered is None or self.bordered.inner is not matrix.pattern:
            self.bordered = BorderedPattern(matrix.pattern, self.equations)
        return self.bordered.matrix(scale * matrix.values)


class _MultiplierFactor:
    def __init__(self, form: Multipliers, factor: Factor, scale: float):
        self.form, self.scale = form, scale
        self.factor: Factor | None = factor

    def direction(self, gradient: np.ndarray) -> np.ndarray:
        self.form.solves += 1
        right = np.concatenate([-self.scale * gradient, np.zeros(self.form.equations.shape[0])])
        with self.form.clock.phase("solve"):
            return self.factor.solve(right)[: len(gradient)]


def make_constraint_form(system: System, metric: csr_matrix, least_multiple: float = 0.0) -> ConstraintForm:
    """The form that the scene asks for.

    Args:
        metric: G, (n, n), alike in x, y, z.
        least_multiple: m in the scaling of the multiplier form is not taken smaller than this.
    """
    settings = system.scene.integrator
    if settings.constraints == "multipliers":
        return Multipliers(system, settings.linear_solver, metric, least_multiple)
    return Eliminated(system, settings.linear_solver, metric)
