"""PARDISO of Intel's MKL (package pypardiso, extra `fast`): analysis, factorization and solution by its own interface.

Matrix types: 2 symmetric positive definite (Cholesky); -2 symmetric (Bunch-Kaufman within supernodes) and 11 any (LU),
both scaled and matched, small pivots being perturbed and solutions refined. The analysis is kept as long as the pattern
stays; the scaling is then that of the first matrix. MKL has as many threads as launch kernels: the last digits of
results depend on their number.
O. Schenk and K. Gartner, Solving unsymmetric sparse systems of linear equations with PARDISO, Future Generation
Computer Systems 20 (2004) 475-487.
"""

import ctypes
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np

from warp_origami.terms.symmetric import SymmetricMatrix
from warp_origami.terms.threads import team

from .analyses import Pattern
from .interface import Factor, Kind
from .perturbing import PerturbingSolver

TYPES: dict[Kind, int] = {"definite": 2, "indefinite": -2, "general": 11}

ANALYSIS, FACTORIZATION, SOLUTION, RELEASE = 11, 22, 33, -1

# places in the array of options (its first one has number 0 here)
OWN, ORDERING, REFINEMENT, PERTURBATION, SCALING, MATCHING, PERTURBED = 0, 1, 7, 9, 10, 12, 13
COUNT, PIVOTING, NEGATIVE, THREADS, FROM_ZERO = 17, 20, 22, 33, 34

METIS, BUNCH_KAUFMAN = 2, 1

REFINEMENTS = 4
"""Steps of iterative refinement, at the most, where pivots were perturbed."""

SAME_SUMS = 2
"""MKL's branch that gives the same sums in every run with as many threads."""

_CORES = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
"""That this process may use; the thread that runs a scene is kept on one of them."""


def is_installed() -> bool:
    """Whether the extra is there."""
    return importlib.util.find_spec("pypardiso") is not None


@cache
def _library() -> tuple[ctypes.CDLL, Callable]:
    from pypardiso import PyPardisoSolver  # not always there, and slow to import

    library = PyPardisoSolver().libmkl
    library.MKL_CBWR_Set(SAME_SUMS)
    return library, library["pardiso"]  # by key: without the argument types that pypardiso wants


class Pardiso(PerturbingSolver):
    """Matrices of one kind."""

    def __init__(self, kind: Kind):
        super().__init__(kind, f"PARDISO ({kind})", lambda pattern: _Memory(TYPES[kind], pattern))


def negative_pivots(matrix: SymmetricMatrix) -> int | None:
    """Number of negative pivots; None where one vanished or was perturbed."""
    memory = _Memory(TYPES["indefinite"], matrix.pattern)
    if not memory.factorize(matrix.values) or memory.perturbed:
        return None
    return int(memory.options[NEGATIVE])


class _Memory:
    """PARDISO's memory of one pattern and of one factor."""

    def __init__(self, kind: int, pattern: Pattern):
        self.kind, self.pattern = kind, pattern
        self._analysed = False
        self._handle = np.zeros(64, dtype=np.int64)
        self.options = np.zeros(64, dtype=np.int32)
        self.options[[OWN, ORDERING, COUNT, FROM_ZERO]] = 1, METIS, -1, 1
        if kind != TYPES["definite"]:
            smallest = 8 if kind == TYPES["indefinite"] else 13  # pivot, over the largest entry: 10 to minus this
            self.options[[PERTURBATION, SCALING, MATCHING, PIVOTING]] = smallest, 1, 1, BUNCH_KAUFMAN

    def factorize(self, values: np.ndarray) -> bool:
        """Whether there is a factor."""
        if not self._analysed:  # which looks at values, to match them
            self._analysed = self._call(ANALYSIS, values) == 0
            if not self._analysed:
                return False
        self.options[REFINEMENT] = 0
        if self._call(FACTORIZATION, values) != 0:
            return False
        self.options[REFINEMENT] = REFINEMENTS if self.perturbed else 0
        return True

    @property
    def perturbed(self) -> int:
        """Pivots of the last factor that were perturbed."""
        return int(self.options[PERTURBED])

    def factor(self, values: np.ndarray) -> Factor:
        """The factor of these values, which has just been made."""
        # refinement looks at the matrix again, whose values may have changed by then
        return _Factor(self, values.copy() if self.perturbed else values)

    def solve(self, values: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Solutions (n, k), in the order of Fortran as `right`."""
        solution = np.zeros_like(right)
        self._call(SOLUTION, values, right, solution)
        return solution

    def _call(self, phase: int, values: np.ndarray, *vectors: np.ndarray) -> int:
        """Runs a phase; returns PARDISO's number of the error, 0 if there is none."""
        library, pardiso = _library()
        threads = team().size
        library.MKL_Set_Num_Threads(threads)
        self.options[THREADS] = threads
        error = ctypes.c_int(0)
        numbers = [ctypes.c_int(number) for number in (1, 1, self.kind, phase, len(self.pattern.indptr) - 1)]
        right, solution = vectors or (np.zeros((1, 1)),) * 2
        with _all_cores(threads):
            pardiso(
                self._handle.ctypes,
                *(ctypes.byref(number) for number in numbers),
                values.ctypes,
                self.pattern.indptr.ctypes,
                self.pattern.indices.ctypes,
                None,
                ctypes.byref(ctypes.c_int(right.shape[1])),
                self.options.ctypes,
                ctypes.byref(ctypes.c_int(0)),
                right.ctypes,
                solution.ctypes,
                ctypes.byref(error),
            )
        return error.value

    def __del__(self) -> None:
        if self._handle.any() and not sys.is_finalizing():
            self._call(RELEASE, np.zeros(1))


@contextmanager
def _all_cores(threads: int) -> Iterator[None]:
    """Lets MKL start its threads on all cores, though this one is kept on one."""
    if threads == 1 or not _CORES or (before := os.sched_getaffinity(0)) == _CORES:
        yield
        return
    os.sched_setaffinity(0, _CORES)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


class _Factor:
    def __init__(self, memory: _Memory, values: np.ndarray):
        self.memory, self.values = memory, values

    def solve(self, right: np.ndarray) -> np.ndarray:
        columns = np.array(right, dtype=float, order="F").reshape(len(right), -1, order="F")
        return self.memory.solve(self.values, columns).reshape(right.shape, order="F")
