"""A pendulum with a rigid link, its length held by a Lagrange multiplier, integrated by generalized-alpha.

    q'' = w - lambda q,   (q . q - 1) / 2 = 0,   L = m = 1, w = (0, -9.81)

released 60 degrees from the vertical with 1 rad/s. No sheet: it shows the order of the method where constraints are
nonlinear and multipliers are unknowns.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from warp_origami.solve.generalized_alpha import GeneralizedAlpha, Kinematics

WEIGHT = np.array([0.0, -9.81])
REFERENCE = (np.array([-0.80245933, -0.59670682]), np.array([-1.01569735, 1.3659234]), np.array([8.75108176]))
"""q, v, lambda at 1 s, to 1e-8, by a Runge-Kutta solution of the equation of the angle."""


def consistent_start(method: GeneralizedAlpha, step: float, correct: bool = True) -> tuple[Kinematics, float]:
    """State at t = 0 and the multiplier; without `correct`, a_0 = q'' and v_0 = v as a naive start has them."""
    angle = np.radians(60.0)
    q = np.array([np.sin(angle), -np.cos(angle)])
    v = np.array([np.cos(angle), np.sin(angle)])
    multiplier = v @ v + q @ WEIGHT  # from q . q'' + v . v = 0 and q'' = WEIGHT - multiplier q
    a = WEIGHT - multiplier * q
    jerk = -multiplier * v - q * (2.0 * v @ a + v @ WEIGHT)
    if not correct:
        return replace(method.start(0.0, q, v, a, jerk, step), auxiliary=a), multiplier
    shift = method.constraint_velocity_shift(step) * q * (q @ jerk)
    return method.start(0.0, q, v + shift, a, jerk, step), multiplier


def advance(method: GeneralizedAlpha, state: Kinematics, step: float, multiplier: float) -> tuple[Kinematics, float]:
    """One step by Newton's method to round-off."""
    form = method.form(state, step)
    q = form.predictor
    for _ in range(20):
        residual = np.append(form.b * (q - form.q_b) - WEIGHT + multiplier * q, 0.5 * (q @ q - 1.0))
        matrix = np.block([[(form.b + multiplier) * np.eye(2), q[:, None]], [q[None], np.zeros((1, 1))]])
        change = np.linalg.solve(matrix, -residual)
        q, multiplier = q + change[:2], multiplier + change[2]
        if np.abs(change[:2]).max() < 1e-15:
            break
    return method.finish(state, form, q), multiplier


def swing(
    radius: float,
    steps: Iterable[float],
    correct: bool = True,
    watch: Callable[[Kinematics, float], None] = lambda state, multiplier: None,
) -> np.ndarray:
    """(3,) errors of q, v and lambda after the given steps (s, of 1 s in all), at the spectral radius `radius`.

    `watch` is told state and multiplier after every step.
    """
    steps = list(steps)
    method = GeneralizedAlpha(radius)
    state, multiplier = consistent_start(method, steps[0], correct)
    for step in steps:
        state = method.with_step(state, step)
        state, multiplier = advance(method, state, step, multiplier)
        watch(state, multiplier)
    values = (state.q, state.v, np.array([multiplier]))
    return np.array([np.linalg.norm(a - b) for a, b in zip(values, REFERENCE, strict=True)])
