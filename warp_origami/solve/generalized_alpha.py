"""Generalized-alpha for the index-3 equations, with the force balance at the end of the step.

    (1 - am) a_{n+1} + am a_n = (1 - af) q''_{n+1} + af q''_n
    q_{n+1} = q_n + h v_n + h^2 (1/2 - beta) a_n + h^2 beta a_{n+1}
    v_{n+1} = v_n + h (1 - gamma) a_n + h gamma a_{n+1}

so that for the unknown q = q_{n+1}

    q'' = b (q - q_b),   v = g (q - q_g),   b = (1 - am) / (h^2 beta (1 - af)),   g = gamma / (h beta).

Second order in q, v and the multipliers when the auxiliary acceleration starts as a_0 = q''_0 + (am - af) h q'''_0 and
is scaled at a change of h, a_n - q''_n being proportional to h.
Source: M. Arnold and O. Bruls, Convergence of the generalized-alpha scheme for constrained mechanical systems,
Multibody System Dynamics 18 (2007) 185-202; spectral radius after J. Chung and G. M. Hulbert (1993).
"""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Kinematics:
    """State of motion at one time; arrays of one shape.

    Attributes:
        time: s.
        q, v: generalized coordinates and velocities.
        acceleration: q''.
        auxiliary: a, the acceleration-like variable of the method.
        auxiliary_step: s, the step size that `auxiliary` belongs to.
    """

    time: float
    q: np.ndarray
    v: np.ndarray
    acceleration: np.ndarray
    auxiliary: np.ndarray
    auxiliary_step: float


@dataclass(frozen=True)
class StepForm:
    """q'' and v as affine functions of the unknown q at the end of a step.

    Attributes:
        time: s, end of the step.
        step: h, s.
        b: 1/s^2, q'' = b (q - q_b).
        g: 1/s, v = g (q - q_g).
        q_b, q_g: see above.
        predictor: q_n + h v_n + h^2 / 2 q''_n.
    """

    time: float
    step: float
    b: float
    g: float
    q_b: np.ndarray
    q_g: np.ndarray
    predictor: np.ndarray


@dataclass(frozen=True)
class GeneralizedAlpha:
    """The method with a given spectral radius at infinite frequency, from 0 (most damping) to 1 (none)."""

    spectral_radius: float

    @property
    def am(self) -> float:
        return (2.0 * self.spectral_radius - 1.0) / (self.spectral_radius + 1.0)

    @property
    def af(self) -> float:
        return self.spectral_radius / (self.spectral_radius + 1.0)

    @property
    def gamma(self) -> float:
        return 0.5 + self.af - self.am

    @property
    def beta(self) -> float:
        return 0.25 * (self.gamma + 0.5) ** 2

    def start(
        self, time: float, q: np.ndarray, v: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray, step: float
    ) -> Kinematics:
        """Consistent start from q, v, q'' and q''' with the first step size."""
        auxiliary = acceleration + (self.am - self.af) * step * jerk
        return Kinematics(time, q, v, acceleration, auxiliary, step)

    @property
    def error_factor(self) -> float:
        """Local error of q over h^3 q''': beta + (am - af) / 2 - 1/6, a_n being q'' at t_n + (am - af) h."""
        return self.beta + 0.5 * (self.am - self.af) - 1.0 / 6.0

    def constraint_velocity_shift(self, step: float) -> float:
        """Cq h^2, s^2: times q''' along the constraint normals, what v_0 lacks for multipliers of second order from the
        first step on."""
        return -self.error_factor * step**2

    def with_step(self, state: Kinematics, step: float) -> Kinematics:
        """The same state with its auxiliary acceleration made for another step size."""
        if step == state.auxiliary_step:
            return state
        ratio = step / state.auxiliary_step
        auxiliary = state.acceleration + ratio * (state.auxiliary - state.acceleration)
        return replace(state, auxiliary=auxiliary, auxiliary_step=step)

    def form(self, state: Kinematics, step: float) -> StepForm:
        """The step from `state`, whose auxiliary acceleration must be made for `step`."""
        h = step
        b = (1.0 - self.am) / (h**2 * self.beta * (1.0 - self.af))
        g = self.gamma / (h * self.beta)
        drift = state.q + h * state.v + h**2 * (0.5 - self.beta) * state.auxiliary
        known = (self.am * state.auxiliary - self.af * state.acceleration) / (1.0 - self.af)
        known_velocity = state.v + h * (1.0 - self.gamma) * state.auxiliary
        return StepForm(
            time=state.time + h,
            step=h,
            b=b,
            g=g,
            q_b=drift - known / b,
            q_g=drift - known_velocity / g,
            predictor=state.q + h * state.v + 0.5 * h**2 * state.acceleration,
        )

    def finish(self, state: Kinematics, form: StepForm, q: np.ndarray) -> Kinematics:
        """The state at the end of the step, once q is known."""
        acceleration = form.b * (q - form.q_b)
        auxiliary = ((1.0 - self.af) * acceleration + self.af * state.acceleration - self.am * state.auxiliary) / (
            1.0 - self.am
        )
        return Kinematics(form.time, q, form.g * (q - form.q_g), acceleration, auxiliary, form.step)

    def local_error(self, before: Kinematics, after: Kinematics) -> np.ndarray:
        """Leading term of the error of q made in the step: the error factor times h^2 (a_{n+1} - a_n)."""
        return self.error_factor * after.auxiliary_step**2 * (after.auxiliary - before.auxiliary)
