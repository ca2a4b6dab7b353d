"""Newton's method with a line search on the slope: speed, robustness, failures as values."""

from dataclasses import dataclass

import numpy as np
import pytest

from warp_origami.solve import newton
from warp_origami.solve.newton import line_search, minimize
from warp_origami.solve.result import Failure


@dataclass
class Function:
    """A potential given by its gradient and second derivative."""

    gradient: object
    hessian: object

    def __post_init__(self):
        self.visited = []

    def linearize(self, q):
        self.visited.append(q)
        hessian = np.atleast_2d(self.hessian(q))
        return self.gradient(q), lambda gradient: -np.linalg.solve(hessian, gradient)

    def size(self, step):
        return float(np.abs(step).max())


def smooth():
    """sum cosh(q_i) + (sum q)^2 / 2 - q_1."""
    first = np.array([1.0, 0.0, 0.0])
    return Function(
        lambda q: np.sinh(q) + q.sum() - first,
        lambda q: np.diag(np.cosh(q)) + np.ones((3, 3)),
    )


def test_converges_quadratically():
    potential = smooth()
    result = minimize(potential, np.array([1.0, -2.0, 1.5]), 1e-10)
    assert result.failure is None
    assert np.abs(potential.gradient(result.q)).max() < 1e-14
    errors = [np.abs(q - result.q).max() for q in potential.visited]
    ratios = [b / a**2 for a, b in zip(errors[-4:], errors[-3:], strict=False) if b > 1e-13]
    assert len(ratios) >= 2
    assert max(ratios) < 1.0


def test_a_linear_problem_takes_one_step_and_one_check():
    matrix = np.diag([1.0, 10.0, 1e4])
    potential = Function(lambda q: matrix @ q - 1.0, lambda q: matrix)
    result = minimize(potential, np.array([5.0, -3.0, 2.0]), 1e-9)
    assert result.failure is None
    assert result.iterations == 2
    np.testing.assert_allclose(result.q, [1.0, 0.1, 1e-4], rtol=1e-12)


def test_a_stiffness_that_jumps_by_ten_thousand_is_overcome():
    """The unilateral spring of wrinkling: Newton alone would jump to and fro between the two stiffnesses."""

    def stiffness(q):
        return np.where(q > 0.0, 1e4, 1.0)

    shift = np.array([1e-3, -2.0, 1e-5])
    matrix = np.array([[2.0, -1.0, 0.3], [0.0, 1.0, 1.0], [0.5, 0.0, 1.0]])
    potential = Function(
        lambda q: matrix.T @ (stiffness(matrix @ q) * (matrix @ q)) + 1e-3 * q - shift,
        lambda q: matrix.T @ np.diag(stiffness(matrix @ q)) @ matrix + 1e-3 * np.eye(3),
    )
    for seed in range(20):
        result = minimize(potential, np.random.default_rng(seed).normal(size=3), 1e-9)
        assert result.failure is None
        assert result.iterations < 20
        assert np.abs(potential.gradient(result.q)).max() < 1e-8


def test_hopeless_problems_end_with_a_failure_and_advice():
    """e^q has no minimum."""
    result = minimize(Function(np.exp, lambda q: np.diag(np.exp(q))), np.zeros(1), 1e-6)
    assert isinstance(result.failure, Failure)
    assert "did not converge in 100 iterations" in result.failure.reason
    assert result.failure.advice
    assert result.iterations == newton.MAXIMUM_ITERATIONS
    assert np.isfinite(result.q).all()


def test_a_step_that_is_not_a_number_ends_the_iteration():
    result = minimize(Function(lambda q: q * np.nan, lambda q: np.eye(2)), np.zeros(2), 1e-6)
    assert "not a number" in result.failure.reason
    assert np.isfinite(result.q).all()


def test_the_failure_of_a_factorization_is_passed_on():
    failure = Failure("indefinite", "smaller steps")

    class Indefinite(Function):
        def linearize(self, q):
            return failure if len(self.visited) == 1 else super().linearize(q)

    result = minimize(Indefinite(lambda q: q**3, lambda q: np.diag(3 * q**2)), np.ones(2), 1e-9)
    assert result.failure is failure
    assert result.iterations == 2


@pytest.mark.parametrize("root", [0.01, 0.3, 0.9, 1.0, 1.7, 3.9])
@pytest.mark.parametrize("power", [1, 3])
def test_line_search_brings_the_slope_below_a_third(root, power):
    """Slopes (s / root)^power - 1 along a unit step."""
    potential = Function(lambda q: (q / root) ** power - 1.0, None)
    length = line_search(potential, np.zeros(1), np.ones(1), -1.0)
    assert 0.0 < length <= newton.LONGEST_STEP
    assert abs((length / root) ** power - 1.0) <= newton.SLOPE_REDUCTION


def test_line_search_crosses_a_kink_of_ten_thousand():
    """Slope -1 + s up to s = 0.1, then 1e4 times as steep."""
    potential = Function(lambda q: -1.0 + q + 1e4 * np.maximum(q - 0.1, 0.0), None)
    length = line_search(potential, np.zeros(1), np.ones(1), -1.0)
    assert abs(potential.gradient(np.array([length]))[0]) <= newton.SLOPE_REDUCTION


def test_line_search_is_bounded_where_the_slope_stays_negative():
    potential = Function(lambda q: -np.ones(1), None)
    assert line_search(potential, np.zeros(1), np.ones(1), -1.0) == newton.LONGEST_STEP


def test_line_search_avoids_where_the_gradient_is_not_a_number():
    potential = Function(lambda q: np.where(q > 0.5, np.nan, q - 0.4), None)
    length = line_search(potential, np.zeros(1), np.ones(1), -0.4)
    assert abs(length - 0.4) <= 0.12
