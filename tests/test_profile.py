"""Time profiles: ends, derivatives, shapes."""

import numpy as np
import pytest

from warp_origami.model.profile import Profile

RAMPS = ["linear", "smooth", "trapezoid"]


@pytest.mark.parametrize("kind", RAMPS)
def test_ramps_go_from_0_to_1_and_stay(kind):
    profile = Profile(kind, 1.0, 3.0)
    assert [profile(t) for t in (-1.0, 0.999, 1.0)] == [0.0, 0.0, 0.0]
    assert [profile(t) for t in (3.0, 3.001, 9.0)] == [1.0, 1.0, 1.0]
    assert profile(2.0) == pytest.approx(0.5, abs=1e-15)
    assert profile(1.7) + profile(2.3) == pytest.approx(1.0, abs=1e-15)
    assert [profile(t, order) for t in (0.5, 3.5) for order in (1, 2)] == [0.0] * 4


@pytest.mark.parametrize("kind", [*RAMPS, "table", "constant"])
def test_derivatives_agree_with_differences(kind):
    table = np.array([[0.2, 0.0], [0.5, 2.0], [1.1, -1.0], [1.4, 0.5]])
    profile = Profile(kind, 0.3, 1.2, table)
    kinks = [0.3, 1.2, *table[:, 0], 0.525, 0.975]
    h = 1e-5
    for t in np.linspace(0.0, 1.6, 53):
        if np.abs(t - np.array(kinks)).min() > 2 * h:
            slope = (profile(t + h) - profile(t - h)) / (2 * h)
            curvature = (profile(t + h, 1) - profile(t - h, 1)) / (2 * h)
            assert profile(t, 1) == pytest.approx(slope, abs=1e-8)
            assert profile(t, 2) == pytest.approx(curvature, abs=1e-7)


def test_smooth_starts_and_ends_without_velocity_and_acceleration():
    profile = Profile("smooth", 0.0, 2.0)
    for t in (1e-9, 2.0 - 1e-9):
        assert abs(profile(t, 1)) < 1e-15
        assert abs(profile(t, 2)) < 1e-7


def test_trapezoid_is_one_of_velocity_with_ramps_of_a_quarter():
    profile = Profile("trapezoid", 0.0, 4.0)
    top = 1.0 / 3.0  # covers 1 within 4 s with ramps of 1 s
    times = [0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0 - 1e-12]
    assert [profile(t, 1) for t in times] == pytest.approx([0.0, top / 2, top, top, top, top / 2, 0.0], abs=1e-9)


def test_table_is_constant_outside_and_its_slope_is_that_from_the_right():
    profile = Profile("table", table=np.array([[1.0, 0.0], [2.0, 3.0], [4.0, 1.0]]))
    assert [profile(t) for t in (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0)] == [0.0, 0.0, 1.5, 3.0, 2.0, 1.0, 1.0]
    assert [profile(t, 1) for t in (0.0, 1.0, 2.0, 4.0, 9.0)] == [0.0, 3.0, -1.0, 0.0, 0.0]
