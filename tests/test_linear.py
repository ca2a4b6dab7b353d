"""Direct solvers: solutions, and None instead of a factor."""

import numpy as np
import pytest
from scipy.sparse import csc_matrix

from warp_origami.errors import InputError
from warp_origami.solve.linear import choose_solver, negative_pivots

SMALL, LARGE = 10, 10**6
"""Sizes for which dense and sparse solvers are chosen."""


def symmetric(eigenvalues, seed=0):
    basis, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(len(eigenvalues),) * 2))
    return csc_matrix(basis @ np.diag(eigenvalues) @ basis.T)


def saddle(n, m, seed=0):
    """A definite block bordered by m equations."""
    equations = np.random.default_rng(seed).normal(size=(m, n))
    block = symmetric(np.geomspace(1.0, 1e4, n)).toarray()
    return csc_matrix(np.block([[block, equations.T], [equations, np.zeros((m, m))]]))


@pytest.mark.parametrize("size", [SMALL, LARGE])
@pytest.mark.parametrize("kind", ["definite", "indefinite", "general"])
def test_solves(size, kind):
    solver = choose_solver("auto", size, kind)
    for matrix in [symmetric(np.geomspace(1e-2, 1e4, 40))] + ([] if kind == "definite" else [saddle(30, 8)]):
        wanted = np.random.default_rng(1).normal(size=matrix.shape[0])
        factor = solver.factorize(matrix)
        np.testing.assert_allclose(factor.solve(matrix @ wanted), wanted, rtol=0, atol=1e-8)
        again = factor.solve(matrix @ wanted)
        assert np.array_equal(again, factor.solve(matrix @ wanted))  # a factor serves many times


def test_factors_outlive_later_ones():
    solver = choose_solver("auto", SMALL, "definite")
    one, two = symmetric(np.linspace(1.0, 2.0, 8)), symmetric(np.linspace(3.0, 9.0, 8), seed=1)
    factor = solver.factorize(one)
    solver.factorize(two)
    np.testing.assert_allclose(one @ factor.solve(np.ones(8)), np.ones(8), atol=1e-12)


@pytest.mark.parametrize("size", [SMALL, LARGE])
@pytest.mark.parametrize("lowest", [-1e-6, -10.0])
def test_a_matrix_that_is_not_positive_definite_gives_none(size, lowest):
    """What tells Newton to add inertia."""
    assert choose_solver("auto", size, "definite").factorize(symmetric([3.0, 2.0, 1.0, lowest])) is None


@pytest.mark.parametrize("size", [SMALL, LARGE])
@pytest.mark.parametrize("kind", ["definite", "indefinite", "general"])
def test_a_singular_matrix_gives_none(size, kind):
    matrix = csc_matrix(np.diag([1.0, 2.0, 0.0, 3.0]))
    assert choose_solver("auto", size, kind).factorize(matrix) is None


def test_unknown_solver_is_refused():
    with pytest.raises(InputError, match=r"integrator\.linear_solver: got 'magic', wants one of \"auto\""):
        choose_solver("magic", SMALL, "definite")


def test_small_systems_are_dense_and_large_ones_sparse():
    for definite in (True, False):
        assert "dense" in choose_solver("auto", SMALL, definite).name
        assert "sparse" in choose_solver("auto", LARGE, definite).name


@pytest.mark.parametrize("size", [SMALL, LARGE])
def test_a_general_solver_takes_matrices_that_are_not_symmetric(size):
    skew = np.triu(np.ones((20, 20)), 1)
    matrix = csc_matrix(symmetric(np.geomspace(1.0, 1e3, 20)) + skew - skew.T)
    wanted = np.random.default_rng(1).normal(size=20)
    np.testing.assert_allclose(choose_solver("auto", size, "general").factorize(matrix).solve(matrix @ wanted), wanted)


def test_negative_pivots_count_negative_eigenvalues_or_nothing():
    """Zeros on the diagonal ask for exchanged rows, whose pivots have other signs: then there is no count."""
    random = np.random.default_rng(0)
    told = 0
    for zeros in 20 * (0, 1, 5, 10):
        matrix = random.normal(size=(30, 30)) * (random.random((30, 30)) < 0.2)
        matrix = matrix + matrix.T + np.diag(random.normal(size=30))
        matrix[np.arange(zeros), np.arange(zeros)] = 0.0
        count = negative_pivots(csc_matrix(matrix))
        if count is not None:
            assert count == np.sum(np.linalg.eigvalsh(matrix) < 0.0)
            told += 1
    assert told >= 20
    assert negative_pivots(csc_matrix([[0.0, 1.0], [1.0, 0.0]])) is None
    assert negative_pivots(csc_matrix(np.diag([1.0, 0.0]))) is None
    assert negative_pivots(symmetric([-3.0, -1.0, 1e-3, 2.0])) == 2
