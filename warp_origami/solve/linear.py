"""Direct solvers for the Newton systems behind one interface.

`factorize` gives a factor to solve with, or None where the matrix is singular or, for a solver of definite matrices,
not positive definite: a value that Newton answers, not an exception.
"""

from typing import Literal, Protocol

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from warp_origami.errors import InputError

Kind = Literal["definite", "indefinite", "general"]

DENSE_DEFINITE, DENSE_INDEFINITE = 500, 200
"""Unknowns up to which dense LAPACK is as fast as SuperLU. Measured, ms on one thread, dense / sparse: definite 0.3 /
0.9 at 285, 1.4 / 1.5 at 495, 3.1 / 2.3 at 672, 10 / 3.6 at 1020; indefinite 0.4 / 0.5 at 187, 4.6 / 2.1 at 597."""


class Factor(Protocol):
    """A factorized matrix."""

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x of A x = right."""


class LinearSolver(Protocol):
    """A way to factorize symmetric matrices."""

    name: str

    def factorize(self, matrix: csc_matrix) -> Factor | None:
        """Factor of `matrix` (both triangles given), None if it cannot be factorized."""


class DenseCholesky:
    """LAPACK potrf: definite matrices of a few hundred unknowns."""

    name = "dense Cholesky (LAPACK)"

    def factorize(self, matrix: csc_matrix) -> Factor | None:
        factor, info = lapack.dpotrf(matrix.toarray(order="F"), lower=1, clean=0, overwrite_a=1)
        return _CholeskyFactor(factor) if info == 0 else None


class _CholeskyFactor:
    def __init__(self, factor: np.ndarray):
        self.factor = factor

    def solve(self, right: np.ndarray) -> np.ndarray:
        return lapack.dpotrs(self.factor, right, lower=1)[0]


class DenseIndefinite:
    """LAPACK sytrf (Bunch-Kaufman): the multiplier form of a few hundred unknowns."""

    name = "dense LDLT (LAPACK)"

    def factorize(self, matrix: csc_matrix) -> Factor | None:
        dense = matrix.toarray(order="F")
        work = 64 * len(dense)
        factor, pivots, info = lapack.dsytrf(dense, lower=1, lwork=work, overwrite_a=1)
        return _IndefiniteFactor(factor, pivots) if info == 0 else None


class _IndefiniteFactor:
    def __init__(self, factor: np.ndarray, pivots: np.ndarray):
        self.factor, self.pivots = factor, pivots

    def solve(self, right: np.ndarray) -> np.ndarray:
        return lapack.dsytrs(self.factor, self.pivots, right, lower=1)[0]


class DenseLU:
    """LAPACK getrf: matrices of a few hundred unknowns that are not symmetric."""

    name = "dense LU (LAPACK)"

    def factorize(self, matrix: csc_matrix) -> Factor | None:
        factor, pivots, info = lapack.dgetrf(matrix.toarray(order="F"), overwrite_a=1)
        return _GeneralFactor(factor, pivots) if info == 0 else None


class _GeneralFactor:
    def __init__(self, factor: np.ndarray, pivots: np.ndarray):
        self.factor, self.pivots = factor, pivots

    def solve(self, right: np.ndarray) -> np.ndarray:
        return lapack.dgetrs(self.factor, self.pivots, right)[0]


class SparseDefinite:
    """SuperLU in symmetric mode without pivoting, whose pivots are then those of an LDL^T: a negative one shows that
    the matrix is not positive definite."""

    name = "sparse LU (SuperLU, symmetric mode)"

    def factorize(self, matrix: csc_matrix) -> SuperLU | None:
        factor = _without_pivoting(matrix)
        definite = (
            factor is not None
            and np.array_equal(factor.perm_r, factor.perm_c)
            and factor.U.diagonal().min(initial=np.inf) > 0.0
        )
        return factor if definite else None


class SparseLU:
    """SuperLU with pivoting: matrices that are indefinite or not symmetric."""

    name = "sparse LU (SuperLU, with pivoting)"

    def factorize(self, matrix: csc_matrix) -> SuperLU | None:
        try:
            return splu(matrix)
        except RuntimeError:
            return None


def _without_pivoting(matrix: csc_matrix) -> SuperLU | None:
    try:
        return splu(matrix, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # SuperLU's only way to say "exactly singular"
        return None


def negative_pivots(matrix: csc_matrix) -> int | None:
    """Number of negative eigenvalues of a symmetric sparse matrix, by the pivots of its LDL^T (Sylvester).

    None where there is no such factor: a pivot vanished, and the matrix is singular or rows were exchanged.
    """
    factor = _without_pivoting(matrix)
    if factor is None or not np.array_equal(factor.perm_r, factor.perm_c):
        return None
    return int(np.sum(factor.U.diagonal() < 0.0))


def choose_solver(name: str, size: int, kind: Kind) -> LinearSolver:
    """The solver that a scene names (`linear_solver`), or what suits `size` unknowns for "auto".

    Args:
        kind: of matrices: symmetric positive definite, symmetric, or any.

    Raises:
        InputError: no such solver in this installation.
    """
    if name not in ("auto", "scipy"):
        raise InputError("integrator.linear_solver", repr(name), 'one of "auto", "scipy"')
    if kind == "definite":
        return DenseCholesky() if size <= DENSE_DEFINITE else SparseDefinite()
    if size > DENSE_INDEFINITE:
        return SparseLU()
    return DenseIndefinite() if kind == "indefinite" else DenseLU()
