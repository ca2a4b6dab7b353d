"""Direct solvers: solutions, None instead of a factor, and what is kept from one factorization to the next."""

import importlib
import os

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_matrix, diags, identity, kron, random_array

from warp_origami.errors import InputError
from warp_origami.solve.linear import choose_solver, cudss, inertia, negative_pivots, pardiso
from warp_origami.solve.linear.banded import Band
from warp_origami.solve.linear.choice import DENSE
from warp_origami.solve.linear.cudss import CuDSS
from warp_origami.solve.linear.dense import DenseIndefinite, DenseLU
from warp_origami.solve.linear.multifrontal import Panels
from warp_origami.solve.linear.pardiso import Pardiso
from warp_origami.solve.linear.sparse_cholesky import SparseCholesky, along_fronts, in_band, quicker
from warp_origami.solve.linear.superlu import SparseLU
from warp_origami.terms.symmetric import SymmetricMatrix, symmetric_part
from warp_origami.terms.threads import use_threads

needs_pardiso = pytest.mark.skipif(not pardiso.is_installed(), reason="pypardiso is not installed")


def multifrontal():
    return SparseCholesky(along_fronts)


def banded():
    return SparseCholesky(in_band)


def solvers(kind):
    """All solvers of one kind of matrices."""
    own = {
        "definite": [multifrontal, banded],
        "indefinite": [DenseIndefinite, SparseLU],
        "general": [DenseLU, SparseLU],
    }[kind]
    return [
        *(pytest.param(kind, make, id=f"{kind}-{make.__name__}") for make in own),
        pytest.param(kind, lambda: Pardiso(kind), id=f"{kind}-Pardiso", marks=needs_pardiso),
        pytest.param(kind, lambda: CuDSS(kind), id=f"{kind}-CuDSS", marks=pytest.mark.cuda),
    ]


EVERY = [*solvers("definite"), *solvers("indefinite"), *solvers("general")]


@pytest.fixture(autouse=True)
def _device(request):
    """Tests marked `cuda` need the package, too."""
    if request.node.get_closest_marker("cuda"):
        pytest.importorskip("nvmath")
        if not importlib.import_module("warp").is_cuda_available():
            pytest.skip("no CUDA device")


def given(kind, matrix):
    """A matrix in the form that solvers of the kind take."""
    return csc_matrix(matrix) if kind == "general" else symmetric_part(csc_matrix(matrix))


def symmetric(eigenvalues, seed=0):
    basis, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(len(eigenvalues),) * 2))
    return basis @ np.diag(eigenvalues) @ basis.T


def grid(n, unknowns=3, seed=0):
    """A definite sparse matrix: springs on n x n nodes with some unknowns each, in random order."""
    line = diags([np.full(n - 1, -1.0), np.full(n, 2.0), np.full(n - 1, -1.0)], [-1, 0, 1])
    springs = kron(line, identity(n)) + kron(identity(n), line) + 0.01 * identity(n * n)
    own = symmetric(np.linspace(1.0, 2.0, unknowns))
    order = np.random.default_rng(seed).permutation(unknowns * n * n)
    return csc_matrix(kron(springs, own))[order][:, order]


def saddle(n, m, seed=0):
    """A definite block bordered by m equations."""
    equations = np.random.default_rng(seed).normal(size=(m, n))
    block = symmetric(np.geomspace(1.0, 1e4, n))
    return np.block([[block, equations.T], [equations, np.zeros((m, m))]])


def matrices(kind):
    skew = np.triu(np.ones((20, 20)), 1)
    more = {
        "definite": [],
        "indefinite": [saddle(30, 8), symmetric([-2.0, -1.0, 1.0, 5.0])],
        "general": [saddle(30, 8), symmetric(np.geomspace(1.0, 1e3, 20)) + skew - skew.T],
    }[kind]
    return [np.array([[2.0]]), symmetric(np.geomspace(1e-2, 1e2, 40)), grid(7), grid(15), *more]


@pytest.mark.parametrize(("kind", "make"), EVERY)
def test_solves(kind, make):
    solver = make()
    for matrix in matrices(kind):
        size = matrix.shape[0]
        wanted = np.random.default_rng(1).normal(size=(size, 3))
        factor = solver.factorize(given(kind, matrix))
        found = factor.solve(matrix @ wanted)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10)
        for one in (0, 2):
            np.testing.assert_allclose(factor.solve(matrix @ wanted[:, one]), wanted[:, one], rtol=0, atol=1e-10)
        assert np.array_equal(found, factor.solve(matrix @ wanted))  # a factor serves many times


@pytest.mark.parametrize(("kind", "make"), EVERY)
def test_a_matrix_without_rows_is_solved(kind, make):
    assert make().factorize(given(kind, np.zeros((0, 0)))).solve(np.zeros(0)).shape == (0,)


@pytest.mark.parametrize(("kind", "make"), EVERY)
def test_factors_outlive_later_ones(kind, make):
    solver = make()
    one, two = grid(6), 3.0 * grid(6)
    pattern = symmetric_part(one).pattern
    factors = [
        solver.factorize(given(kind, m) if kind == "general" else SymmetricMatrix(pattern, symmetric_part(m).values))
        for m in (one, two, one, two)
    ]
    for factor, matrix in zip(factors, (one, two, one, two), strict=True):
        np.testing.assert_allclose(matrix @ factor.solve(np.ones(108)), np.ones(108), atol=1e-11)


@pytest.mark.parametrize(("kind", "make"), EVERY)
def test_a_singular_matrix_gives_none(kind, make):
    solver = make()
    assert solver.factorize(given(kind, np.diag([1.0, 2.0, 0.0, 3.0]))) is None
    assert solver.factorize(given(kind, np.diag([1.0, 2.0, 4.0, 3.0]))) is not None


@pytest.mark.parametrize(("kind", "make"), solvers("definite"))
@pytest.mark.parametrize("lowest", [-1e-6, -10.0])
def test_a_matrix_that_is_not_positive_definite_gives_none(kind, make, lowest):
    """What tells Newton to add inertia."""
    assert make().factorize(given(kind, symmetric([3.0, 2.0, 1.0, lowest]))) is None
    smallest = np.linalg.eigvalsh(grid(12).toarray())[0]
    for beyond, definite in ((1e-9, False), (-1e-9, True)):
        shifted = grid(12) - (smallest + beyond) * identity(432)
        assert (make().factorize(given(kind, shifted)) is not None) == definite


@pytest.mark.parametrize(
    "make",
    [
        multifrontal,
        banded,
        *(
            pytest.param(lambda k=k: Pardiso(k), id=f"Pardiso-{k}", marks=needs_pardiso)
            for k in ("definite", "indefinite")
        ),
    ],
)
def test_a_pattern_is_analysed_once(make):
    solver, matrix = make(), symmetric_part(grid(8))
    for factor in (1.0, 2.0, 3.0):
        last = solver.factorize(SymmetricMatrix(matrix.pattern, factor * matrix.values))
    assert last is not None
    assert solver.analyses == 1
    other = symmetric_part(grid(8) + csc_matrix(([0.1, 0.1], ([0, 150], [150, 0])), shape=(192, 192)))
    for given_matrix in (other, matrix, other, matrix):  # the sheet with and without what touches
        solver.factorize(given_matrix)
    assert solver.analyses == 2


@pytest.mark.parametrize("density", [0.001, 0.02, 0.3])
def test_fronts_hold_any_pattern(density):
    """Unconnected parts, long chains and full matrices."""
    size = 150
    half = random_array((size, size), density=density, rng=np.random.default_rng(3))
    matrix = csc_matrix(half @ half.T + identity(size))
    right = np.random.default_rng(0).normal(size=size)
    found = multifrontal().factorize(symmetric_part(matrix)).solve(right)
    np.testing.assert_allclose(found, np.linalg.solve(matrix.toarray(), right), rtol=0, atol=1e-10)


def test_multifrontal_factors_repeat_bitwise():
    matrix = symmetric_part(grid(20))
    right = np.random.default_rng(0).normal(size=1200)
    assert len({multifrontal().factorize(matrix).solve(right).tobytes() for _ in range(3)}) == 1


def test_narrow_matrices_are_factorized_in_a_band_and_wide_ones_along_fronts():
    line = symmetric_part(diags([np.full(299, -1.0), np.full(300, 3.0), np.full(299, -1.0)], [-1, 0, 1]))
    assert isinstance(quicker(line.pattern, None), Band)
    parts = block_diag([np.ones((30, 30))] * 20 + [[[1.0]]]).tolil()
    parts[600, :] = 1.0  # one unknown is coupled to all
    assert isinstance(quicker(symmetric_part(csc_matrix(parts)).pattern, None), Panels)


def test_unknown_solver_is_refused():
    with pytest.raises(InputError, match=r"integrator\.linear_solver: got 'magic', wants one of \"auto\""):
        choose_solver("magic", 10, "definite")


@pytest.mark.parametrize(("name", "extra", "module"), [("pardiso", "fast", pardiso), ("cudss", "cuda", cudss)])
def test_a_solver_that_is_not_installed_is_refused_with_its_extra(monkeypatch, name, extra, module):
    monkeypatch.setattr(module, "is_installed", lambda: False)
    with pytest.raises(InputError, match=rf'"{name}", which is not installed.*warp-origami\[{extra}\]'):
        choose_solver(name, 10, "definite")


def test_auto_needs_no_extra(monkeypatch):
    monkeypatch.setattr(pardiso, "is_installed", lambda: False)
    names = {kind: choose_solver("auto", 10**6, kind).name for kind in ("definite", "indefinite", "general")}
    assert "multifrontal" in names["definite"]
    assert "SuperLU" in names["indefinite"]
    assert "SuperLU" in names["general"]
    assert "dense" in choose_solver("auto", DENSE, "indefinite").name


@needs_pardiso
def test_auto_takes_pardiso_for_large_matrices():
    for kind in ("definite", "indefinite", "general"):
        assert "PARDISO" in choose_solver("auto", 10**6, kind).name
        assert "PARDISO" not in choose_solver("scipy", 10**6, kind).name


def counts(matrix):
    """By SuperLU and, where installed, PARDISO."""
    yield negative_pivots(matrix)
    if pardiso.is_installed():
        yield pardiso.negative_pivots(symmetric_part(matrix))


def test_negative_pivots_count_negative_eigenvalues_or_nothing():
    """Zeros on the diagonal ask for exchanged rows, whose pivots have other signs: then there is no count."""
    random = np.random.default_rng(0)
    told = 0
    for zeros in 20 * (0, 1, 5, 10):
        matrix = random.normal(size=(30, 30)) * (random.random((30, 30)) < 0.2)
        matrix = matrix + matrix.T + np.diag(random.normal(size=30))
        matrix[np.arange(zeros), np.arange(zeros)] = 0.0
        for count in counts(csc_matrix(matrix)):
            if count is not None:
                assert count == np.sum(np.linalg.eigvalsh(matrix) < 0.0)
                told += 1
    assert told >= 20
    assert negative_pivots(csc_matrix([[0.0, 1.0], [1.0, 0.0]])) is None
    assert all(count is None for count in counts(csc_matrix(np.diag([1.0, 0.0]))))
    assert all(count == 2 for count in counts(csc_matrix(symmetric([-3.0, -1.0, 1e-3, 2.0]))))


@needs_pardiso
def test_large_matrices_are_counted_by_pardiso(monkeypatch):
    monkeypatch.setattr(inertia, "LARGE", 100)
    shifted = grid(12) - identity(432)
    assert negative_pivots(csc_matrix(shifted)) == np.sum(np.linalg.eigvalsh(shifted.toarray()) < 0.0)


@needs_pardiso
def test_pardiso_on_two_threads_solves_and_leaves_this_one_where_it_was():
    matrix = symmetric_part(grid(20))
    before = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    with use_threads(2):
        found = Pardiso("definite").factorize(matrix).solve(np.ones(1200))
    np.testing.assert_allclose(matrix.full() @ found, np.ones(1200), atol=1e-10)
    if before is not None:
        assert os.sched_getaffinity(0) == before
