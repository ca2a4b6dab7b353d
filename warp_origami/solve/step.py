"""One time step: predictor, Newton, local error, energy balance. It decides nothing and keeps nothing."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import identity, kron
from scipy.sparse.linalg import splu

from warp_origami.system import System
from warp_origami.terms.sparsity import ReducedSparsity

from .constraint_form import make_constraint_form
from .energy import EnergyBalance, Forces
from .generalized_alpha import GeneralizedAlpha, Kinematics
from .newton import minimize
from .result import Failure
from .step_potential import StepPotential

NEWTON_SHARE = 1e-4
"""Newton tolerance over the tolerance of the step; 1e-3 would do for accuracy, but 1e-4 keeps symmetric motion so."""


JERK_SHARE = 1e-3
"""Time over which q''' of the start is found by a difference of q'', over the first step."""


@dataclass(frozen=True)
class StepOutcome:
    """A tried step.

    Attributes:
        failure: None if Newton converged.
        iterations: Newton iterations.
        kinematics, forces, balance: at the end of the step; None after a failure of Newton.
        error: local error over the tolerance.
        created: W, energy the step created over its length.
    """

    failure: Failure | None
    iterations: int
    kinematics: Kinematics | None = None
    forces: Forces | None = None
    balance: EnergyBalance | None = None
    error: float = 0.0
    created: float = 0.0


class Stepper:
    """Tries steps of generalized-alpha for one system.

    Attributes:
        constraint_form: how constraints are held, and the linear solver in use.
    """

    def __init__(self, system: System, method: GeneralizedAlpha):
        self.system, self.method = system, method
        self.constraint_form = make_constraint_form(system)
        self.tolerance = system.scene.integrator.tolerance * system.mesh.size
        self.material = system.scene.material
        self.kron_mass = kron(system.mass, identity(3), format="csr")
        self.full_tangent = None
        if self.material.stiffness_damping > 0.0:
            size = 3 * system.coordinates.count
            self.full_tangent = ReducedSparsity(
                system.coordinates.elements, system.coordinates.count, identity(size, format="csr"), system.device
            )

    def start(self, step: float) -> tuple[Kinematics, Forces, EnergyBalance]:
        """Consistent initial state: q'' from the equations of motion, q''' by a difference of q'' along the motion."""
        system, constraints = self.system, self.system.constraints
        q, v = system.q0, system.v0
        null = constraints.null_space
        mass = splu((null.T @ self.kron_mass @ null).tocsc()) if null.shape[1] else None

        def acceleration(time, q, v):
            _, prescribed = constraints.derivatives(time)
            held = constraints.right_inverse @ prescribed
            balance = self._balance_without_inertia(time, q, v) + self.kron_mass @ held
            free = null @ mass.solve(-(null.T @ balance)) if mass is not None else 0.0
            return (held + free).reshape(q.shape)

        a = acceleration(0.0, q, v)
        ahead = JERK_SHARE * step
        # along v only: the further term in a is of higher order and would multiply the round-off of stiff motion
        jerk = (acceleration(ahead, q + ahead * v, v + ahead * a) - a) / ahead
        held_jerk = (constraints.right_inverse @ (constraints.equations @ jerk.ravel())).reshape(q.shape)
        shifted = v + self.method.constraint_velocity_shift(step) * held_jerk
        kinematics = self.method.start(0.0, q, shifted, a, jerk, step)
        evaluation = system.evaluate(q)
        forces = self._forces(kinematics, evaluation.gradient)
        return (
            kinematics,
            forces,
            EnergyBalance.start(system.kinetic_energy(shifted), evaluation.strain_energy, evaluation.contact_energy),
        )

    def try_step(self, before: Kinematics, forces: Forces, balance: EnergyBalance, step: float) -> StepOutcome:
        """A step of size `step` (s) from an accepted state with its forces and energy balance."""
        before = self.method.with_step(before, step)
        form = self.method.form(before, step)
        potential = StepPotential(
            self.system,
            self.constraint_form,
            form,
            self.system.body_force(form.time).ravel(),
            self._damping_matrix(before),
        )
        newton = minimize(potential, self._predictor(form), NEWTON_SHARE * self.tolerance)
        if newton.failure is not None:
            return StepOutcome(newton.failure, newton.iterations)
        after = self.method.finish(before, form, newton.q.reshape(before.q.shape))
        error = potential.filtered(self.method.local_error(before, after))
        evaluation = self.system.evaluate(after.q)
        new_forces = self._forces(after, evaluation.gradient, potential.damping_matrix)
        new_balance = balance.advance(
            self.system.kinetic_energy(after.v),
            evaluation.strain_energy,
            evaluation.contact_energy,
            (after.q - before.q).ravel(),
            forces,
            new_forces,
        )
        if not np.isfinite(new_balance.error):
            return StepOutcome(Failure("the energy is not a number", "smaller steps"), newton.iterations)
        return StepOutcome(
            None,
            newton.iterations,
            after,
            new_forces,
            new_balance,
            potential.size(error.ravel()) / self.tolerance,
            (new_balance.error - balance.error) / step,
        )

    def _predictor(self, form) -> np.ndarray:
        c = self.system.constraints
        prescribed = c.right_inverse @ c.values(form.time)
        return c.null_space @ (c.left_inverse @ (form.predictor.ravel() - prescribed)) + prescribed

    def _damping_matrix(self, before: Kinematics):
        if self.full_tangent is None:
            return None
        linearization = self.system.linearize(before.q)
        self.constraint_form.hold_damping(linearization)
        return self.full_tangent.matrix(self.full_tangent.values(linearization.blocks).copy())

    def _balance_without_inertia(self, time: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        gradient = self.system.evaluate(q).gradient.ravel()
        damping = self.material.mass_damping * (self.kron_mass @ v.ravel())
        return gradient + damping - self.system.body_force(time).ravel()

    def _forces(self, state: Kinematics, gradient: np.ndarray, damping_matrix=None) -> Forces:
        body = self.system.body_force(state.time).ravel()
        damping = self.material.mass_damping * (self.system.mass @ state.v).ravel()
        if damping_matrix is not None:
            damping = damping + self.material.stiffness_damping * (damping_matrix @ state.v.ravel())
        balance = (self.system.mass @ state.acceleration + gradient).ravel() + damping - body
        constraints = self.system.constraints
        return Forces(body, damping, constraints.right_inverse.T @ balance, constraints.values(state.time))
