"""What solvers share that perturb small pivots rather than exchange rows, and keep an analysis per pattern."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.sparse import csc_matrix

from warp_origami.terms.symmetric import SymmetricMatrix

from .analyses import Analyses, Pattern
from .checks import is_accurate, rows_with_diagonal
from .dense import EmptyFactor
from .interface import Factor, Kind


class Session(Protocol):
    """The memory of one pattern, with one factor."""

    pattern: Pattern

    @property
    def perturbed(self) -> int:
        """Pivots of the last factor that were perturbed."""

    def factorize(self, values: np.ndarray) -> bool:
        """Whether there is a factor."""

    def factor(self, values: np.ndarray) -> Factor:
        """The factor of these values, which has just been made."""


class PerturbingSolver:
    """Matrices of one kind.

    Args:
        kind: of matrices.
        name: for summaries.
        open_session: for a pattern.
    """

    kernel_modules = ()

    def __init__(self, kind: Kind, name: str, open_session: Callable[[Pattern], Session]):
        self._kind, self.name = kind, name
        self._analyses: Analyses[Session] = Analyses(lambda pattern, _: open_session(pattern))

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
        factor = session.factor(values)
        self._analyses.give(session, factor)
        if not session.perturbed:
            return factor
        full = matrix.full() if isinstance(matrix, SymmetricMatrix) else pattern
        return factor if self._kind != "definite" and is_accurate(factor, full) else None
