"""cuDSS on a CUDA device (package nvmath-python, extra `cuda`): matrices and vectors go there and back.

Sparse matrices are LDL^T or LU factorized with perturbed pivots, definite ones Cholesky. The analysis is kept as long
as the pattern stays.
"""

import importlib.util

import numpy as np
from scipy.sparse import csr_matrix

from .analyses import Pattern
from .interface import Factor, Kind
from .perturbing import PerturbingSolver


def is_installed() -> bool:
    """Whether the extra is there."""
    return importlib.util.find_spec("nvmath") is not None


class CuDSS(PerturbingSolver):
    """Matrices of one kind."""

    def __init__(self, kind: Kind):
        super().__init__(kind, f"cuDSS ({kind})", lambda pattern: _Session(kind, pattern))


class _Session:
    """One pattern on the device, and one factor."""

    def __init__(self, kind: Kind, pattern: Pattern):
        self._solver = None
        from nvmath.sparse import advanced  # not always there, and slow to import

        types, views = advanced.DirectSolverMatrixType, advanced.DirectSolverMatrixViewType
        self._types = {"definite": types.SPD, "indefinite": types.SYMMETRIC, "general": types.GENERAL}
        self.pattern, self.perturbed = pattern, 0
        self._size = len(pattern.indptr) - 1
        self._options = advanced.DirectSolverOptions(
            sparse_system_type=self._types[kind],
            # the lower triangle by columns is the upper one by rows
            sparse_system_view=views.FULL if kind == "general" else views.UPPER,
        )
        self._make = advanced.DirectSolver

    def factorize(self, values: np.ndarray) -> bool:
        """Whether there is a factor."""
        matrix = csr_matrix((values, self.pattern.indices, self.pattern.indptr), shape=2 * (self._size,))
        if self._solver is None:
            self._solver = self._make(matrix, np.zeros(self._size), options=self._options)
            self._solver.plan()
        else:
            self._solver.reset_operands(a=matrix)
        found = self._solver.factorize()
        self.perturbed = found.npivots
        return found.info == 0

    def factor(self, values: np.ndarray) -> Factor:
        """The factor that has just been made."""
        return _Factor(self)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """(n,) solution."""
        self._solver.reset_operands(b=np.ascontiguousarray(right, dtype=float))
        return self._solver.solve()

    def __del__(self) -> None:
        if self._solver is not None:
            self._solver.free()


class _Factor:
    def __init__(self, session: _Session):
        self.session = session

    def solve(self, right: np.ndarray) -> np.ndarray:
        if right.ndim == 1:
            return self.session.solve(right)
        return np.column_stack([self.session.solve(column) for column in right.T])
