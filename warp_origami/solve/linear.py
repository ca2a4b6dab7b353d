"""Direct solvers for the Newton systems behind one interface.

`factorize` gives a factor to solve with, or None where the matrix is singular or, for a solver of definite matrices,
not positive definite: a value that Newton answers, not an exception.
"""

from typing import Protocol

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from warp_origami.errors import InputError

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


class SparseLU:
    """SuperLU as SciPy brings it: symmetric mode for definite matrices, with pivoting otherwise."""

    def __init__(self, definite: bool):
        self.definite = definite
        self.name = "sparse LU (SuperLU, " + ("symmetric mode)" if definite else "with pivoting)")

    def factorize(self, matrix: csc_matrix) -> SuperLU | None:
        try:
            if self.definite:
                return splu(matrix, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
            return splu(matrix)
        except RuntimeError:  # SuperLU's only way to say "exactly singular"
            return None


def choose_solver(name: str, size: int, definite: bool) -> LinearSolver:
    """The solver that a scene names (`linear_solver`), or what suits `size` unknowns for "auto".

    Raises:
        InputError: no such solver in this installation.
    """
    if name not in ("auto", "scipy"):
        raise InputError("integrator.linear_solver", repr(name), 'one of "auto", "scipy"')
    if size <= (DENSE_DEFINITE if definite else DENSE_INDEFINITE):
        return DenseCholesky() if definite else DenseIndefinite()
    return SparseLU(definite)
