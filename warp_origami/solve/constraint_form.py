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
from scipy.sparse import bmat, csc_matrix, csr_matrix, diags, identity, kron, spmatrix

from warp_origami.clock import PhaseClock
from warp_origami.system import Linearization, System
from warp_origami.terms.sparsity import ReducedSparsity

from .linear import Factor, LinearSolver, choose_solver

SKEW = 1e-13
"""Skew part over the largest entry of the tangent below which it is round-off: pressure on a held rim is symmetric."""


class ConstraintForm(Protocol):
    """Newton directions that stay within the constraints."""

    name: str
    solver: LinearSolver

    def factorize(self, linearization: Linearization, multiple: float, damping: float) -> "NewtonFactor | None":
        """Factor of J = K + multiple G + damping K_0, None if it cannot be factorized."""

    def hold_damping(self, linearization: Linearization) -> None:
        """Keeps K_0 of the linearization as the matrix of stiffness damping."""


class NewtonFactor(Protocol):
    """A factorized J."""

    def direction(self, gradient: np.ndarray) -> np.ndarray:
        """(3n,) d that minimizes gradient . d + d . J d / 2 over C d = 0."""


class ReducedTangent:
    """T^T J T of fixed sparsity plus what contact and pressure on free edges add."""

    def __init__(self, system: System, null_space: csr_matrix, metric: csr_matrix):
        self.null_space = null_space
        if null_space is system.constraints.null_space:
            self.sparsity = system.reduced_sparsity
        else:
            coordinates = system.coordinates
            self.sparsity = ReducedSparsity(coordinates.elements, coordinates.count, null_space, system.device)
        reduced = null_space.T @ kron(metric, identity(3), format="csr") @ null_space
        self.metric_values = self.sparsity.values_of(reduced.tocsc())
        self.damping_values = np.zeros_like(self.metric_values)

    def hold_damping(self, linearization: Linearization) -> None:
        self.damping_values = self.sparsity.values(linearization.blocks).copy()

    def matrix(self, linearization: Linearization, multiple: float, damping: float) -> tuple[csc_matrix, bool]:
        """The matrix, and whether it is symmetric."""
        values = self.sparsity.values(linearization.blocks) + multiple * self.metric_values
        if damping:
            values = values + damping * self.damping_values
        matrix: spmatrix = self.sparsity.matrix(values)
        if linearization.contact_rows is not None and linearization.contact_rows.shape[0] > 0:
            rows = linearization.contact_rows @ self.null_space
            matrix = matrix + rows.T @ diags(linearization.contact_weights) @ rows
        if linearization.skew is None:
            return matrix.tocsc(), True
        skew = self.null_space.T @ linearization.skew @ self.null_space
        if np.abs(skew.data).max(initial=0.0) <= SKEW * np.abs(values).max(initial=0.0):
            return matrix.tocsc(), True
        return (matrix + skew).tocsc(), False


class Eliminated:
    """Constraints eliminated through the null space: y = slopes along creases and free coordinates."""

    name = "eliminate"

    def __init__(self, system: System, linear_solver: str, metric: csr_matrix):
        self.clock: PhaseClock = system.clock
        self.null_space = system.constraints.null_space
        self.transposed = self.null_space.T.tocsr()
        self.tangent = ReducedTangent(system, self.null_space, metric)
        self.solver = choose_solver(linear_solver, self.null_space.shape[1], "definite")
        self.general_solver = choose_solver(linear_solver, self.null_space.shape[1], "general")

    def hold_damping(self, linearization: Linearization) -> None:
        self.tangent.hold_damping(linearization)

    def factorize(self, linearization: Linearization, multiple: float, damping: float) -> "NewtonFactor | None":
        with self.clock.phase("assembly"):
            matrix, symmetric = self.tangent.matrix(linearization, multiple, damping)
        with self.clock.phase("factorization"):
            factor = (self.solver if symmetric else self.general_solver).factorize(matrix)
        return None if factor is None else _EliminatedFactor(self, factor)


class _EliminatedFactor:
    def __init__(self, form: Eliminated, factor: Factor):
        self.form, self.factor = form, factor

    def direction(self, gradient: np.ndarray) -> np.ndarray:
        right = -(self.form.transposed @ gradient)
        if len(right) == 0:  # everything is prescribed, and LAPACK knows no empty systems
            return np.zeros_like(gradient)
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
        self.mean_metric = float(np.mean(metric.diagonal()))
        self.least_multiple = least_multiple
        self.solver = choose_solver(linear_solver, size + self.equations.shape[0], "indefinite")
        self.general_solver = choose_solver(linear_solver, size + self.equations.shape[0], "general")

    def hold_damping(self, linearization: Linearization) -> None:
        self.tangent.hold_damping(linearization)

    def factorize(self, linearization: Linearization, multiple: float, damping: float) -> "NewtonFactor | None":
        scale = 1.0 / (max(multiple, self.least_multiple) * self.mean_metric)
        with self.clock.phase("assembly"):
            matrix, symmetric = self.tangent.matrix(linearization, multiple, damping)
            system = bmat([[scale * matrix, self.equations.T], [self.equations, None]], format="csc")
        with self.clock.phase("factorization"):
            factor = (self.solver if symmetric else self.general_solver).factorize(system)
        return None if factor is None else _MultiplierFactor(self, factor, scale)


class _MultiplierFactor:
    def __init__(self, form: Multipliers, factor: Factor, scale: float):
        self.form, self.factor, self.scale = form, factor, scale

    def direction(self, gradient: np.ndarray) -> np.ndarray:
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
