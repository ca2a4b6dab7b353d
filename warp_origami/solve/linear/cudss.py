"""cuDSS on a CUDA device (package nvmath-python, extra `cuda`): matrices and vectors go there and back.

Sparse matrices are LDL^T or LU factorized with perturbed pivots, definite ones Cholesky. The analysis is kept as long
as the pattern stays.
"""

import importlib.util

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix

from warp_origami.terms.symmetric import SymmetricMatrix

from .analyses import Analyses, Pattern
from .checks import is_accurate, rows_with_diagonal
from .dense import EmptyFactor
from .interface import Factor, Kind


def is_installed() -> bool:
    """Whether the extra is there."""
    return importlib.util.find_spec("nvmath") is not None


class CuDSS:
    """Matrices of one kind.

    Attributes:
        name: for summaries.
    """

    kernel_modules = ()

    def __init__(self, kind: Kind):
        self._kind = kind
        self.name = f"cuDSS ({kind})"
        self._analyses: Analyses[_Session] = Analyses(lambda pattern, _: _Session(kind, pattern))

    @property
    def analyses(self) -> int:
        """How many patterns were analysed."""
        return self._analyses.count

    def factorize(self, matrix: SymmetricMatrix | csc_matrix) -> Factor | None:
        if isinstance(matrix, SymmetricMatrix):
            pattern, values = matrix.pattern, matrix.values
        else:
            pattern = rows_with_diagonal(matrix)
            values = pattern.data
        if len(values) == 0:
            return EmptyFactor()
        session = self._analyses.take(pattern)
        if not session.factorize(values):
            return None
        factor = _Factor(session)
        self._analyses.give(session, factor)
        if session.perturbed == 0:
            return factor
        full = matrix.full() if isinstance(matrix, SymmetricMatrix) else pattern
        return factor if self._kind != "definite" and is_accurate(factor, full) else None


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
