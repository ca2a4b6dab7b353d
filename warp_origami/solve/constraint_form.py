"""The two ways to hold C q = d(t) in a Newton step: eliminate exactly, or keep the multipliers of (58).

Elimination solves T^T J T y = -T^T g. The multiplier form solves, with the scaling of C. L. Bottasso, D. Dopico and
L. Trainelli (Multibody System Dynamics 19 (2008) 3-20: dynamics by beta h^2, multipliers by h^2),

    [ s J   C^T ] [ d        ]   [ -s g ]
    [ C     0   ] [ s lambda ] = [  0   ],    s = 1 / (b m)

where 1 / b is beta h^2 up to a constant of the method and m is the mean diagonal of M, so that both blocks are of order
one whatever h. Every iterate satisfies C q = d(t), the equations being linear. Both give the same step.
"""

from typing import Protocol

import numpy as np
from scipy.sparse import bmat, csc_matrix, csr_matrix, diags, identity

from warp_origami.clock import PhaseClock
from warp_origami.system import Linearization, System
from warp_origami.terms.sparsity import ReducedSparsity

from .linear import Factor, LinearSolver, choose_solver


class ConstraintForm(Protocol):
    """Newton directions that stay within the constraints."""

    name: str
    solver: LinearSolver

    def factorize(self, linearization: Linearization, mass_factor: float, damping: float) -> "NewtonFactor | None":
        """Factor of J = mass_factor M + K + damping K_0, None if it cannot be factorized."""

    def hold_damping(self, linearization: Linearization) -> None:
        """Keeps K_0 of the linearization as the matrix of stiffness damping."""


class NewtonFactor(Protocol):
    """A factorized J."""

    def direction(self, gradient: np.ndarray) -> np.ndarray:
        """(3n,) d that minimizes gradient . d + d . J d / 2 over C d = 0."""


class ReducedTangent:
    """T^T J T of fixed sparsity plus what contact adds."""

    def __init__(self, system: System, null_space: csr_matrix):
        self.null_space = null_space
        coordinates = system.coordinates
        self.sparsity = ReducedSparsity(coordinates.elements, coordinates.count, null_space, system.device)
        mass = (null_space.T @ system.full_mass @ null_space).tocsc()
        self.mass_values = self.sparsity.values_of(mass)
        self.damping_values = np.zeros_like(self.mass_values)

    def hold_damping(self, linearization: Linearization) -> None:
        self.damping_values = self.sparsity.values(linearization.blocks).copy()

    def matrix(self, linearization: Linearization, mass_factor: float, damping: float) -> csc_matrix:
        values = self.sparsity.values(linearization.blocks) + mass_factor * self.mass_values
        if damping:
            values = values + damping * self.damping_values
        matrix = self.sparsity.matrix(values)
        if linearization.contact_rows is None or linearization.contact_rows.shape[0] == 0:
            return matrix
        rows = linearization.contact_rows @ self.null_space
        return (matrix + rows.T @ diags(linearization.contact_weights) @ rows).tocsc()


class Eliminated:
    """Constraints eliminated through the null space: y = slopes along creases and free coordinates."""

    name = "eliminate"

    def __init__(self, system: System, linear_solver: str):
        self.clock: PhaseClock = system.clock
        self.null_space = system.constraints.null_space
        self.transposed = self.null_space.T.tocsr()
        self.tangent = ReducedTangent(system, self.null_space)
        self.solver = choose_solver(linear_solver, self.null_space.shape[1], definite=True)

    def hold_damping(self, linearization: Linearization) -> None:
        self.tangent.hold_damping(linearization)

    def factorize(self, linearization: Linearization, mass_factor: float, damping: float) -> "NewtonFactor | None":
        with self.clock.phase("assembly"):
            matrix = self.tangent.matrix(linearization, mass_factor, damping)
        with self.clock.phase("factorization"):
            factor = self.solver.factorize(matrix)
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

    def __init__(self, system: System, linear_solver: str):
        self.clock: PhaseClock = system.clock
        size = 3 * system.coordinates.count
        self.equations = system.constraints.equations
        self.tangent = ReducedTangent(system, identity(size, format="csr"))
        self.mean_mass = float(np.mean(system.mass.diagonal()))
        self.solver = choose_solver(linear_solver, size + self.equations.shape[0], definite=False)

    def hold_damping(self, linearization: Linearization) -> None:
        self.tangent.hold_damping(linearization)

    def factorize(self, linearization: Linearization, mass_factor: float, damping: float) -> "NewtonFactor | None":
        scale = 1.0 / (mass_factor * self.mean_mass)
        with self.clock.phase("assembly"):
            matrix = self.tangent.matrix(linearization, mass_factor, damping)
            system = bmat([[scale * matrix, self.equations.T], [self.equations, None]], format="csc")
        with self.clock.phase("factorization"):
            factor = self.solver.factorize(system)
        return None if factor is None else _MultiplierFactor(self, factor, scale)


class _MultiplierFactor:
    def __init__(self, form: Multipliers, factor: Factor, scale: float):
        self.form, self.factor, self.scale = form, factor, scale

    def direction(self, gradient: np.ndarray) -> np.ndarray:
        right = np.concatenate([-self.scale * gradient, np.zeros(self.form.equations.shape[0])])
        with self.form.clock.phase("solve"):
            return self.factor.solve(right)[: len(gradient)]


def make_constraint_form(system: System) -> ConstraintForm:
    """The form that the scene asks for."""
    settings = system.scene.integrator
    kind = Multipliers if settings.constraints == "multipliers" else Eliminated
    return kind(system, settings.linear_solver)
