"""One time step: predictor, Newton, local error, energy balance. It decides nothing and keeps nothing."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_matrix, identity

from warp_origami.system import System
from warp_origami.terms.symmetric import symmetric_part

from .constraint_form import make_constraint_form
from .energy import EnergyBalance, Forces
from .generalized_alpha import GeneralizedAlpha, Kinematics
from .linear import choose_solver
from .mixed_newton import minimize_mixed
from .newton import NewtonResult, minimize
from .result import Failure
from .step_potential import StepPotential
from .step_size import error_bound

NEWTON_SHARE = 1e-4
"""Newton tolerance over the tolerance of the step; 1e-3 would do for accuracy, but 1e-4 keeps symmetric motion so."""

AFTER_KINK = 1e-12
"""Over the duration: how long after a kink of a profile it is looked at to see what follows."""

FRICTION_PASSES = 5
"""How often friction is taken anew within a step, at the most."""

SETTLED_SHARE = 1e-2
"""Friction has settled when taking it anew moves the sheet by less than this share of Newton's tolerance."""

JERK_SHARE = 1e-3
"""Time over which q''' of the start is found by a difference of q'', over the first step."""


@dataclass(frozen=True)
class StepOutcome:
    """A tried step.

    Attributes:
        failure: None if Newton converged.
        iterations: Newton iterations.
        kinematics, forces, balance: at the end of the step; None after a failure of Newton.
        error: local error over what it is to be kept below.
        created: W, energy the step created over its length.
        solves: linear systems solved.
    """

    failure: Failure | None
    iterations: int
    kinematics: Kinematics | None = None
    forces: Forces | None = None
    balance: EnergyBalance | None = None
    error: float = 0.0
    created: float = 0.0
    solves: int = 0


class Stepper:
    """Tries steps of generalized-alpha for one system.

    Attributes:
        constraint_form: how constraints are held, and the linear solver in use.
    """

    def __init__(self, system: System, method: GeneralizedAlpha):
        self.system, self.method = system, method
        self.constraint_form = make_constraint_form(system, system.mass)
        self.tolerance = system.scene.integrator.tolerance * system.mesh.size
        self.error_bound = error_bound(system.scene.integrator.tolerance) * system.mesh.size
        self.material = system.scene.material
        null = system.constraints.null_space
        mass = symmetric_part(null.T @ system.full_mass @ null)
        linear_solver = system.scene.integrator.linear_solver
        self.reduced_mass = choose_solver(linear_solver, null.shape[1], "definite").factorize(mass)
        self.after_kink = AFTER_KINK * system.scene.analysis.end
        self.full_tangent = None
        if self.material.stiffness_damping > 0.0:
            size = 3 * system.coordinates.count
            self.full_tangent = system.sparsity(identity(size, format="csr"))

    def start(self, step: float) -> tuple[Kinematics, Forces, EnergyBalance]:
        """Consistent initial state for a first step (s)."""
        system = self.system
        kinematics, forces = self._consistent(0.0, system.q0, system.v0, step)
        stored = system.evaluate(system.q0)
        kinetic = system.kinetic_energy(kinematics.v)
        return kinematics, forces, EnergyBalance.start(kinetic, stored.strain_energy, stored.contact_energy)

    def restart(
        self, state: Kinematics, balance: EnergyBalance, step: float
    ) -> tuple[Kinematics, Forces, EnergyBalance]:
        """The state after a kink of a driver's profile, where prescribed velocities or accelerations jump.

        The constraints act with an impulse, M dv = -C^T Lambda, C dv = jump of d'; its work is the kinetic energy won.
        """
        c = self.system.constraints
        wanted, _ = c.derivatives(state.time + self.after_kink)
        held = c.right_inverse @ (wanted - c.equations @ state.v.ravel())
        jump = held - self._free_response(self.system.full_mass @ held)
        v = state.v + jump.reshape(state.v.shape)
        kinematics, forces = self._consistent(state.time, state.q, v, step)
        return kinematics, forces, balance.with_impulse(self.system.kinetic_energy(kinematics.v))

    def _consistent(self, time: float, q: np.ndarray, v: np.ndarray, step: float) -> tuple[Kinematics, Forces]:
        """q'' from the equations of motion, q''' by a difference of q'' along the motion."""
        c = self.system.constraints
        start = time + self.after_kink if time > 0.0 else time
        damping_matrix = self._damping_matrix(q)

        def acceleration(time, q, v):
            _, prescribed = c.derivatives(time)
            held = c.right_inverse @ prescribed
            balance = self._balance_without_inertia(time, q, v, damping_matrix) + self.system.full_mass @ held
            return (held - self._free_response(balance)).reshape(q.shape)

        a = acceleration(start, q, v)
        ahead = JERK_SHARE * step
        # along v only: the further term in a is of higher order and would multiply the round-off of stiff motion
        jerk = (acceleration(start + ahead, q + ahead * v, v + ahead * a) - a) / ahead
        if self.system.scene.turns:
            # what turns leaves its circle along v by a strain that is even in `ahead`, and stiff
            back = acceleration(start, q - ahead * v, v - ahead * a) - a
            jerk = 0.5 * (jerk - back / ahead)
        held_jerk = (c.right_inverse @ (c.equations @ jerk.ravel())).reshape(q.shape)
        shifted = v + self.method.constraint_velocity_shift(step) * held_jerk
        kinematics = self.method.start(time, q, shifted, a, jerk, step)
        return kinematics, self._forces(kinematics, self.system.evaluate(q).gradient, damping_matrix)

    def _free_response(self, force: np.ndarray) -> np.ndarray:
        """(3n,) acceleration of the free coordinates under a force (3n,): T (T^T M T)^-1 T^T force."""
        null = self.system.constraints.null_space
        return null @ self.reduced_mass.solve(null.T @ force)

    def try_step(self, before: Kinematics, forces: Forces, balance: EnergyBalance, step: float) -> StepOutcome:
        """A step of size `step` (s) from an accepted state with its forces and energy balance."""
        solved = self.constraint_form.solves
        outcome = self._tried(before, forces, balance, step)
        return replace(outcome, solves=self.constraint_form.solves - solved)

    def _tried(self, before: Kinematics, forces: Forces, balance: EnergyBalance, step: float) -> StepOutcome:
        before = self.method.with_step(before, step)
        form = self.method.form(before, step)
        potential = StepPotential(
            self.system,
            self.constraint_form,
            form,
            self.system.external.at(form.time),
            self._damping_matrix(before.q),
        )
        newton = self._solve(potential, before, balance.contact > 0.0)
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
            potential.size(error.ravel()) / self.error_bound,
            (new_balance.error - balance.error) / step,
        )

    def _solve(self, potential: StepPotential, before: Kinematics, touching: bool) -> NewtonResult:
        """Minimizes the potential; `touching`: whether layers press on each other at the begin of the step."""
        tolerance = NEWTON_SHARE * self.tolerance
        alone = self._without_contact(potential, before, touching, tolerance)
        if alone.failure is None or self.system.contact is None:
            return alone
        newton = self._with_contact(potential, before, tolerance)
        return replace(newton, iterations=alone.iterations + newton.iterations)

    def _without_contact(
        self, potential: StepPotential, before: Kinematics, touching: bool, tolerance: float
    ) -> NewtonResult:
        """The minimum as if layers passed through each other: that of the potential if none touches there.

        Looking at contact costs more than the rest of an iteration, and in most steps nothing touches. A step that
        nothing touches at its begin, nor where it is predicted to end, is tried without.
        """
        start = self._predictor(potential.form)
        touch = Failure("layers touch", "Newton with contact")
        if touching or self.system.touches(start.reshape(before.q.shape)):
            return NewtonResult(start, 0, touch)
        potential.contact = False
        newton = minimize_mixed(potential, start, before.q.ravel(), tolerance)
        potential.contact = True
        if newton.failure is None and self.system.touches(newton.q.reshape(before.q.shape)):
            return replace(newton, failure=touch)
        return newton

    def _with_contact(self, potential: StepPotential, before: Kinematics, tolerance: float) -> NewtonResult:
        """The minimum of the whole potential, found again and again with friction taken anew until that changes
        nothing."""
        if self.system.friction is not None:
            self.system.evaluate(before.q)
            potential.friction = self.system.friction_at(before.q)
        newton = minimize_mixed(potential, self._predictor(potential.form), before.q.ravel(), tolerance)
        if self.system.friction is None:
            return newton
        for _ in range(FRICTION_PASSES):
            if newton.failure is not None:
                break
            correction = potential.renew_friction(newton.q)
            size = potential.size(correction)
            if size < tolerance:  # as close as Newton goes: no factorization
                newton = replace(newton, q=newton.q + correction)
                if size < SETTLED_SHARE * tolerance:
                    break
            else:
                again = minimize(potential, newton.q, tolerance)
                newton = replace(again, iterations=newton.iterations + again.iterations)
        return newton

    def _predictor(self, form) -> np.ndarray:
        c = self.system.constraints
        prescribed = c.right_inverse @ c.values(form.time)
        return c.null_space @ (c.left_inverse @ (form.predictor.ravel() - prescribed)) + prescribed

    def _damping_matrix(self, q: np.ndarray) -> csc_matrix | None:
        """K_0 of stiffness damping at q; the stiffness that keeps a hub rigid is none of a material."""
        if self.full_tangent is None:
            return None
        linearization = self.system.linearize(q, contact=False, hub=False)
        self.constraint_form.hold_damping(linearization)
        return self.full_tangent.matrix(self.full_tangent.values(linearization.blocks).copy())

    def _balance_without_inertia(self, time: float, q: np.ndarray, v: np.ndarray, damping_matrix) -> np.ndarray:
        external = self.system.external_force(q, self.system.external.at(time))
        gradient = self.system.evaluate(q).gradient - external
        return gradient.ravel() + self._damping(q, v, damping_matrix)

    def _damping(self, q: np.ndarray, v: np.ndarray, damping_matrix: csc_matrix | None) -> np.ndarray:
        """(3n,) damping alpha M v + beta K_0 v, and the resistance of friction, at the q that was last evaluated."""
        damping = self.material.mass_damping * (self.system.mass @ v).ravel()
        if damping_matrix is not None:
            damping = damping + self.material.stiffness_damping * (damping_matrix @ v.ravel())
        friction = self.system.friction_at(q)
        return damping if friction is None else damping + friction.resistance(v)

    def _forces(self, state: Kinematics, gradient: np.ndarray, damping_matrix=None) -> Forces:
        external = self.system.external_force(state.q, self.system.external.at(state.time)).ravel()
        damping = self._damping(state.q, state.v, damping_matrix)
        balance = (self.system.mass @ state.acceleration + gradient).ravel() + damping - external
        constraints = self.system.constraints
        return Forces(external, damping, constraints.right_inverse.T @ balance, constraints.values(state.time))
