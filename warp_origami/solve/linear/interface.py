"""What Newton asks of a linear solver.

`factorize` gives a factor to solve with, or None where the matrix is singular or, for a solver of definite matrices,
not positive definite: a value that Newton answers, not an exception.
"""

from typing import Literal, Protocol

import numpy as np
from scipy.sparse import csc_matrix

from warp_origami.terms.symmetric import SymmetricMatrix

Kind = Literal["definite", "indefinite", "general"]
"""Of matrices: symmetric positive definite, symmetric, or any."""


class Factor(Protocol):
    """A factorized matrix; later factorizations leave it as it is."""

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x of A x = right, for one right side (n,) or several (n, k)."""


class LinearSolver(Protocol):
    """A way to factorize matrices of one kind.

    What it found out about a pattern it keeps for the next matrix with the same pattern.

    Attributes:
        name: for summaries.
        kernel_modules: Warp modules compiled for it.
    """

    name: str
    kernel_modules: tuple[str, ...] = ()

    def factorize(self, matrix: SymmetricMatrix | csc_matrix) -> Factor | None:
        """Factor of a symmetric matrix, for solvers of the general kind of a sparse one; None if there is none."""
