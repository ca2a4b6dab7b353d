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
        contact: whether layers press on each other, or are taken to pass through each other.
        touching: whether anything pressed in the state last looked at.
    """

    system: System
    constraint_form: ConstraintForm
    form: StepForm
    external: ExternalForce
    damping_matrix: csc_matrix | None = None
    factor: NewtonFactor | None = None
    friction: Friction | None = None
    contact: bool = True
    touching: bool = False

    def gradient(self, q: np.ndarray) -> np.ndarray:
        evaluation = self.system.evaluate(q.reshape(-1, 3), self.contact)
        self.touching = evaluation.contact_energy > 0.0
        return self._balance(q, evaluation.gradient)

    def linearize(self, q: np.ndarray):
        linearization = self._linearization(q)
        for shift in SHIFTS:
            if self._factorize(linearization, shift):
                return self._balance(q, linearization.gradient), self.factor.direction
        return Failure("the Newton matrix is not positive definite", "smaller steps, or more mass_damping")

    def take_strains(self, q: np.ndarray) -> None:
        """The strains of the mixed iteration are those of q from now on."""
        self.system.take_strains(q.reshape(-1, 3))

    def advance_strains(self, q: np.ndarray, step: np.ndarray, length: float) -> None:
        """Takes the strains of the mixed iteration a part of the way to those linearized at q along a step, or to what
        the law has instead of them."""
        self.system.advance_strains(q.reshape(-1, 3), step.reshape(-1, 3), length)

    def linearize_mixed(self, q: np.ndarray):
        """Like linearize with the law at the strains of the iteration; None where there is no factor.

        Strains of its own may press where those of q do not: then the tangent does without its geometric part.
        """
        for geometric in (True, False):
            linearization = self._linearization(q, mixed=True, geometric=geometric)
            if self._factorize(linearization, 0.0):
                return self._balance(q, linearization.gradient), self.factor.direction
        return None

    def _linearization(self, q: np.ndarray, **options: bool) -> Linearization:
        x = q.reshape(-1, 3)
        linearization = self.system.linearize(x, self.external, contact=self.contact, **options)
        self.touching = linearization.contact_rows is not None and linearization.contact_rows.shape[0] > 0
        return linearization if self.friction is None else self._with_friction(linearization, x)

    def _factorize(self, linearization: Linearization, shift: float) -> bool:
        """Whether there is a factor of the tangent with `shift` more inertia; it is kept."""
        material = self.system.scene.material
        inertia = (1.0 + shift) * (self.form.b + material.mass_damping * self.form.g)
        damping = material.stiffness_damping * self.form.g
        self.factor = self.constraint_form.factorize(linearization, inertia, damping)
        return self.factor is not None

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
        with self.system.clock.phase("assembly"):
            form, material = self.form, self.system.scene.material
            x = q.reshape(-1, 3)
            inertia = form.b * (x - form.q_b)
            if material.mass_damping:
                inertia += material.mass_damping * form.g * (x - form.q_g)
            balance = self.system.mass @ inertia
            balance += gradient
            balance -= self.system.external_force(x, self.external)
            balance = balance.ravel()
            if self.damping_matrix is not None:
                balance += material.stiffness_damping * form.g * (self.damping_matrix @ (x - form.q_g).ravel())
            if self.friction is not None:
                balance += self.friction.resistance(form.g * (x - form.q_g))
        return balance
