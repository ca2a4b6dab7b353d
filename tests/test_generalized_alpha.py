"""Generalized-alpha: order in q, v and multipliers, change of the step, damping of high frequencies.

The pendulum with a rigid link as a multiplier constraint is that of the verification suite.
"""

from dataclasses import replace

import numpy as np
import pytest

from warp_origami.solve.generalized_alpha import GeneralizedAlpha
from warp_origami.study.verification.pendulum import WEIGHT, swing


def orders(errors):
    return np.log2(errors[:-1] / errors[1:])


def test_errors_of_the_pendulum_at_a_four_hundredth():
    np.testing.assert_allclose(swing(0.8, [1 / 400] * 400), [2.35e-5, 1.04e-4, 3.87e-4], rtol=1e-2)


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.8])
def test_second_order_in_position_velocity_and_multiplier(radius):
    errors = np.array([swing(radius, [1.0 / n] * n) for n in (200, 400, 800)])
    print(f"radius {radius}: errors at 1/400 {errors[1]}, orders {orders(errors)[-1]}")
    assert np.abs(orders(errors) - 2.0).max() < 0.05


@pytest.mark.parametrize("change", [0.5, 2.0])
def test_multipliers_are_of_second_order_some_steps_after_a_change_of_the_step(change):
    """In the very next steps they are of first order; the difference dies out like spectral_radius^k."""
    errors = np.array(
        [swing(0.6, [1.0 / n] * (n // 2) + [change / n] * int(n / 2 / change))[2] for n in (100, 200, 400)]
    )
    assert orders(errors)[-1] > 1.95


def test_second_order_in_position_and_velocity_with_a_change_at_every_step(monkeypatch):
    """What the correction of the auxiliary acceleration is for: without it one order is lost."""

    def observed():
        steps = (100, 200, 400)
        return orders(np.array([swing(0.6, ([1.0 / n] + [0.5 / n] * 2) * (n // 2))[:2] for n in steps]))[-1]

    assert observed().min() > 1.95
    monkeypatch.setattr(GeneralizedAlpha, "with_step", lambda self, state, step: replace(state, auxiliary_step=step))
    assert observed().max() < 1.5


@pytest.mark.parametrize(("correct", "order"), [(True, 2.0), (False, 1.0)])
def test_multipliers_are_of_second_order_from_the_first_step_on_with_a_consistent_start(correct, order):
    errors = []
    for n in (200, 400, 800):
        states = []
        swing(0.3, [1.0 / n] * 4, correct, lambda *state, states=states: states.append(state))
        # lambda = v . v + q . WEIGHT in the exact motion, and q and v are of second order
        errors.append(max(abs(multiplier - s.v @ s.v - s.q @ WEIGHT) for s, multiplier in states))
    assert orders(np.array(errors))[-1] == pytest.approx(order, abs=0.1)


def amplification(method, frequency):
    """Matrix of one step of q'' + w^2 q = 0 on (q, h v, h^2 q'', h^2 a), for h = 1."""
    columns = []
    for unit in np.eye(4):
        q, v, acceleration, auxiliary = unit
        state = method.start(0.0, q, v, acceleration, 0.0, 1.0)
        state = replace(state, auxiliary=auxiliary)
        form = method.form(state, 1.0)
        end = method.finish(state, form, form.b * form.q_b / (form.b + frequency**2))
        columns.append([end.q, end.v, end.acceleration, end.auxiliary])
    return np.array(columns).T


def spectral_radius(method, frequency):
    return np.abs(np.linalg.eigvals(amplification(method, frequency))).max()


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.8, 1.0])
def test_spectral_radius_is_that_asked_for_at_high_frequency_and_never_above_one(radius):
    method = GeneralizedAlpha(radius)
    # the limit is a double eigenvalue, which round-off splits by its square root
    assert spectral_radius(method, 1e5) == pytest.approx(radius, abs=2e-3)
    assert max(spectral_radius(method, w) for w in np.geomspace(1e-3, 1e4, 200)) < 1.0 + 1e-7


def test_no_damping_with_spectral_radius_one():
    for frequency in (0.1, 1.0, 10.0):
        sizes = np.abs(np.linalg.eigvals(amplification(GeneralizedAlpha(1.0), frequency)))
        assert np.sort(sizes)[-2:] == pytest.approx([1.0, 1.0], abs=1e-7)


def test_constant_acceleration_is_exact():
    """Free fall at any step and radius."""
    for radius in (0.0, 0.5, 1.0):
        method = GeneralizedAlpha(radius)
        state = method.start(0.0, np.array([1.0]), np.array([2.0]), np.array([-9.81]), np.zeros(1), 0.1)
        for step in (0.1, 0.1, 0.03, 0.2):
            state = method.with_step(state, step)
            form = method.form(state, step)
            state = method.finish(state, form, form.q_b - 9.81 / form.b)
        t = 0.43
        assert state.time == pytest.approx(t)
        assert state.q[0] == pytest.approx(1.0 + 2.0 * t - 0.5 * 9.81 * t**2, rel=1e-13)
        assert state.v[0] == pytest.approx(2.0 - 9.81 * t, rel=1e-13)


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.8, 1.0])
def test_local_error_estimate_is_of_the_size_of_the_error_of_the_step(radius):
    """One step of q'' = -q from exact data: the estimate has the order and sign of the true error and bounds it."""
    method = GeneralizedAlpha(radius)
    ratios = []
    for h in (0.02, 0.01, 0.005):
        t = 0.7
        start = method.start(t, np.cos(t), -np.sin(t), -np.cos(t), np.sin(t), h)
        form = method.form(start, h)
        end = method.finish(start, form, form.b * form.q_b / (form.b + 1.0))
        ratios.append(method.local_error(start, end) / (end.q - np.cos(t + h)))
    print(f"radius {radius}: estimate over error {ratios}")
    assert abs(ratios[-1] - ratios[-2]) < 0.6 * abs(ratios[-2] - ratios[-3])
    assert 0.98 < ratios[-1] < 1.02
