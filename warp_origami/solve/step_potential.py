"""The incremental potential of one time step and its Newton directions.

    Phi(q) = 1/2 b |q - q_b|_M^2 + 1/2 alpha g |q - q_g|_M^2 + U(q) + U_contact(q) - W(q) + 1/2 beta g |q - q_g|_K0^2

whose gradient is the force balance (57) at the end of the step, with q'' = b (q - q_b) and v = g (q - q_g). The matrix
K_0 of stiffness damping (55) is the tangent at the start of the step. Friction adds D(v) / g, whose gradient is its
resistance; the normal forces and places of contact in D are held, and taken anew between minimizations. Follower
pressure on a free edge has no potential W; then "gradient" means the force balance, and its derivative is not
symmetric.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, vstack

from warp_origami.system import Linearization, System
from warp_origami.terms.contact.friction import Friction
from warp_origami.terms.external import ExternalForce

from .constraint_form import ConstraintForm, NewtonFactor
from .generalized_alpha import StepForm
from .result import Failure

SHIFTS = (0.0, 3.0, 30.0, 300.0)
"""Multiples of the inertia that are added until an indefinite system can be factorized."""


@dataclass
class StepPotential:
    """Phi of one step; q is (3n,) here.

    Attributes:
        system, constraint_form, form: what is solved.
        external: the external force at the end of the step.
        damping_matrix: K_0, (3n, 3n), None without stiffness damping.
        factor: of the last linearization.
        friction: with what it holds; None without.
    """

    system: System
    constraint_form: ConstraintForm
    form: StepForm
    external: ExternalForce
    damping_matrix: csc_matrix | None = None
    factor: NewtonFactor | None = None
    friction: Friction | None = None

    def gradient(self, q: np.ndarray) -> np.ndarray:
        return self._balance(q, self.system.evaluate(q.reshape(-1, 3)).gradient)

    def linearize(self, q: np.ndarray):
        x = q.reshape(-1, 3)
        linearization = self.system.linearize(x, self.external)
        if self.friction is not None:
            linearization = self._with_friction(linearization, x)
        material = self.system.scene.material
        inertia = self.form.b + material.mass_damping * self.form.g
        damping = material.stiffness_damping * self.form.g
        for shift in SHIFTS:
            self.factor = self.constraint_form.factorize(linearization, (1.0 + shift) * inertia, damping)
            if self.factor is not None:
                return self._balance(q, linearization.gradient), self.factor.direction
        return Failure("the Newton matrix is not positive definite", "smaller steps, or more mass_damping")

    def renew_friction(self, q: np.ndarray) -> np.ndarray:
        """Takes normal forces and places of contact anew at q; returns how that moves the minimum, to first order."""
        x = q.reshape(-1, 3)
        v = self.form.g * (x - self.form.q_g)
        held = self.friction.resistance(v)
        self.system.evaluate(x)
        self.friction = self.system.friction_at(x)
        return self.factor.direction(self.friction.resistance(v) - held)

    def _with_friction(self, linearization: Linearization, x: np.ndarray) -> Linearization:
        form = self.form
        rows, weights = self.friction.tangent(form.g * (x - form.q_g))
        return replace(
            linearization,
            contact_rows=csr_matrix(vstack([linearization.contact_rows, rows])),
            contact_weights=np.concatenate([linearization.contact_weights, form.g * weights]),
        )

    def size(self, step: np.ndarray) -> float:
        """Largest displacement that a row of q causes, m."""
        return self.system.displacement(step)

    def filtered(self, error: np.ndarray) -> np.ndarray:
        """J^-1 b M error: the local error without what the stiffness of the sheet would take back at once.

        The undamped in-plane ringing of a taut sheet is in `error` but hardly in this; slow motion passes unchanged.
        """
        inertia = self.form.b + self.system.scene.material.mass_damping * self.form.g
        return self.factor.direction(-inertia * (self.system.mass @ error).ravel()).reshape(error.shape)

    def _balance(self, q: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        form, material = self.form, self.system.scene.material
        x = q.reshape(-1, 3)
        inertia = form.b * (x - form.q_b)
        if material.mass_damping:
            inertia = inertia + material.mass_damping * form.g * (x - form.q_g)
        external = self.system.external_force(x, self.external)
        balance = (self.system.mass @ inertia + gradient - external).ravel()
        if self.damping_matrix is not None:
            balance += material.stiffness_damping * form.g * (self.damping_matrix @ (x - form.q_g).ravel())
        if self.friction is not None:
            balance += self.friction.resistance(form.g * (x - form.q_g))
        return balance
