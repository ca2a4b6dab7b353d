"""Step size control: acceptance, order, hysteresis, limits."""

import pytest

from warp_origami.solve.step_size import LONGEST_WAIT, AdaptiveStep, FixedStep, Patience, error_bound

CONTROLLER = AdaptiveStep(first=1e-3, smallest=1e-6, largest=1.0)


def test_a_step_is_accepted_up_to_the_tolerance():
    assert CONTROLLER.judge(0.1, 0.999)[0]
    assert not CONTROLLER.judge(0.1, 1.001)[0]


def test_a_rejected_step_gets_smaller_always():
    for error in (1.0001, 1.5, 10.0, 1e6, float("inf")):
        accepted, step = CONTROLLER.judge(0.1, error)
        assert not accepted
        assert 0.03 * (1 - 1e-12) <= step < 0.1


def test_error_of_third_order_is_driven_below_the_tolerance():
    """error = (h / h0)^3: steps settle just below h0 from both sides, and then stay as they are."""
    for step in (1e-4, 0.9):
        h0, accepted_steps = 0.02, []
        for _ in range(40):
            accepted, proposed = CONTROLLER.judge(step, (step / h0) ** 3)
            if accepted:
                accepted_steps.append(step)
            step = proposed
        assert 0.7 * h0 < accepted_steps[-1] <= h0
        assert accepted_steps[-10:] == [accepted_steps[-1]] * 10


def test_errors_that_vary_a_little_do_not_change_the_step():
    """A change of the step costs accuracy: errors from 0.4 to 0.7 of the tolerance are left alone."""
    for error in (0.4, 0.5, 0.6, 0.7):
        assert CONTROLLER.judge(0.1, error) == (True, 0.1)


def test_growth_is_limited():
    assert CONTROLLER.judge(0.1, 0.0) == (True, 0.2)
    assert CONTROLLER.judge(0.8, 0.0) == (True, 1.0)


def test_failures_halve_the_step_until_the_smallest():
    assert CONTROLLER.after_failure(0.1) == 0.05
    assert CONTROLLER.after_failure(1.9e-6) is None


def test_a_fixed_step_stays_and_gives_up():
    fixed = FixedStep(0.1)
    assert fixed.judge(0.1, 1e9) == (True, 0.1)
    assert fixed.judge(0.03, 1.0) == (True, pytest.approx(0.1))  # the step before was cut to land on the end
    assert fixed.after_failure(0.1) is None


def test_the_local_error_stays_below_the_tolerance_and_falls_so_that_the_global_one_is_proportional():
    """Steps h of a local error c h^3 leave c h^2 a time: h^2 from the bound must be proportional to the tolerance."""
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        assert error_bound(tolerance) <= tolerance
    assert error_bound(1e-5) ** (2.0 / 3.0) == pytest.approx(10.0 * error_bound(1e-6) ** (2.0 / 3.0), rel=1e-12)
    assert error_bound(1e-3) == 1e-3


def test_patience_doubles_while_growing_fails_and_fades_when_it_succeeds():
    patience, waits = Patience(), []
    for _ in range(8):  # each time that steps may grow, the longer one is refused
        patience, wait = patience.after_refusal(), 0
        while patience.left > 0:
            patience, wait = patience.after_step(grown=False), wait + 1
        waits.append(wait)
    assert waits == [0, 1, 3, 7, 7, 7, 7, 7] and LONGEST_WAIT == 7
    for _ in range(3):
        patience = patience.after_step(grown=True)
    assert patience == Patience()
    assert patience.after_step(grown=False) == Patience()
