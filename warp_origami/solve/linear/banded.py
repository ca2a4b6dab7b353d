"""Banded Cholesky factorization (LAPACK's pbtrf) in the order of reverse Cuthill and McKee."""

import numpy as np
from scipy.linalg import lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee

from warp_origami.terms.symmetric import SymmetricPattern

RATE, NARROW = 3.5e10, 3.8e-9
"""Multiplications a second in pbtrf of wide bands, and the seconds that each takes more, times the width. Measured, ms
(unknowns, width): 0.008 (60, 29), 0.042 (192, 47), 0.23 (525, 74), 0.46 (837, 92), 0.64 (495, 215), 7.9 (4221, 200), 28
(9021, 290)."""


class BandOrder:
    """Order of the unknowns and the band that they then have.

    Attributes:
        width: subdiagonals.
        seconds: that a factorization takes, roughly.
    """

    def __init__(self, pattern: SymmetricPattern):
        full = pattern.full(np.ones(len(pattern.indices), dtype=np.int8))
        self.order = reverse_cuthill_mckee(full.tocsr(), symmetric_mode=True)
        place = np.argsort(self.order)
        self.places = place[pattern.indices], place[pattern.columns]
        self.width = int(np.abs(self.places[0] - self.places[1]).max())
        below = np.minimum(self.width, np.arange(pattern.size, dtype=float))
        self.seconds = float(below @ below) * (1.0 / RATE + NARROW / max(self.width, 1))


class Band:
    """Memory of one factor.

    Attributes:
        pattern: of the matrices.
    """

    def __init__(self, pattern: SymmetricPattern, order: BandOrder):
        self.pattern, self.order = pattern, order
        a, b = order.places
        self._places = np.minimum(a, b).astype(np.int64) * (order.width + 1) + np.abs(a - b)
        self._numbers = np.zeros((order.width + 1) * pattern.size)
        self._band = self._numbers.reshape(order.width + 1, pattern.size, order="F")

    def factorize(self, values: np.ndarray) -> bool:
        """Whether the matrix is positive definite."""
        self._numbers.fill(0.0)
        self._numbers[self._places] = values
        return lapack.dpbtrf(self._band, lower=1, overwrite_ab=1)[1] == 0

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x of A x = right (n,) or (n, k)."""
        found = lapack.dpbtrs(self._band, right[self.order.order], lower=1)[0]
        result = np.empty_like(found)
        result[self.order.order] = found
        return result
