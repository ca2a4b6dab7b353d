"""Quadrature rules are exact to their degree, inside the triangle, symmetric and positive."""

from itertools import permutations
from math import factorial

import numpy as np
import pytest

from warp_origami.terms.quadrature import rule

POINTS = {1: 1, 2: 3, 3: 6, 4: 6, 5: 7, 6: 12, 7: 16, 8: 16}


def worst_error(areas, weights, degree):
    """Largest error over the monomials of `degree`, whose mean over the triangle is 2 i! j! k! / (degree + 2)!."""
    exponents = [(i, j, degree - i - j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    exact = [2 * factorial(i) * factorial(j) * factorial(k) / factorial(degree + 2) for i, j, k in exponents]
    found = [weights @ np.prod(areas ** np.array(e), axis=1) for e in exponents]
    return np.abs(np.subtract(found, exact)).max()


@pytest.mark.parametrize("degree", POINTS)
def test_rule_is_exact_to_its_degree_and_small(degree):
    areas, weights = rule(degree)
    assert len(weights) == POINTS[degree]
    assert max(worst_error(areas, weights, d) for d in range(degree + 1)) < 4e-16


@pytest.mark.parametrize("degree", [1, 2, 4, 5, 6, 8])
def test_rule_is_not_better_than_stated(degree):
    areas, weights = rule(degree)
    assert worst_error(areas, weights, degree + 1) > 1e-6


@pytest.mark.parametrize("degree", POINTS)
def test_points_are_inside_symmetric_and_positive(degree):
    areas, weights = rule(degree)
    assert weights.min() > 0 and areas.min() > 0
    np.testing.assert_allclose(areas.sum(axis=1), 1.0, atol=1e-15)
    points = {(*np.round(a, 12), round(w, 12)) for a, w in zip(areas, weights, strict=True)}
    for turn in permutations(range(3)):
        assert points == {(*np.round(a[list(turn)], 12), round(w, 12)) for a, w in zip(areas, weights, strict=True)}


@pytest.mark.parametrize("degree", [0, 9])
def test_unknown_degree_is_refused(degree):
    with pytest.raises(ValueError, match="wants 1 to 8"):
        rule(degree)
