"""Cholesky factorization of sparse matrices of any size: along fronts or in a band, whichever is faster."""

from collections.abc import Callable

from warp_origami.terms.front_assembly import KERNEL_MODULE
from warp_origami.terms.symmetric import SymmetricMatrix, SymmetricPattern

from .analyses import Analyses
from .banded import Band, BandOrder
from .dense import EmptyFactor
from .fronts import Fronts, find_fronts
from .interface import Factor
from .multifrontal import Panels, Plan

LARGEST_BAND = 10_000
"""Unknowns from which on fronts always win."""

UNDERESTIMATE = 1.3
"""What fronts take over what their sizes promise."""


def along_fronts(pattern: SymmetricPattern, other: Panels | None, fronts: Fronts | None = None) -> Panels:
    """Memory of a multifrontal factor; `other` is of the same pattern, as are `fronts`, if known."""
    return Panels(pattern, Plan(pattern, fronts or find_fronts(pattern)) if other is None else other.plan)


def in_band(pattern: SymmetricPattern, other: Band | None) -> Band:
    """Memory of a banded factor."""
    return Band(pattern, BandOrder(pattern) if other is None else other.order)


def quicker(pattern: SymmetricPattern, other: Panels | Band | None) -> Panels | Band:
    """Memory of the kind of factor that takes less time."""
    if other is not None:
        return along_fronts(pattern, other) if isinstance(other, Panels) else in_band(pattern, other)
    fronts = find_fronts(pattern)
    if pattern.size <= LARGEST_BAND:
        order = BandOrder(pattern)
        if order.seconds < UNDERESTIMATE * fronts.seconds:
            return Band(pattern, order)
    return along_fronts(pattern, None, fronts)


class SparseCholesky:
    """Definite matrices.

    Args:
        analyse: gives the memory of a factor of a pattern, and may borrow from another one.

    Attributes:
        name: for summaries.
    """

    name = "sparse Cholesky (multifrontal or banded)"
    kernel_modules = (KERNEL_MODULE,)

    def __init__(self, analyse: Callable = quicker) -> None:
        self._analyses: Analyses[Panels | Band] = Analyses(analyse)

    @property
    def analyses(self) -> int:
        """How many patterns were analysed."""
        return self._analyses.count

    def factorize(self, matrix: SymmetricMatrix) -> Factor | None:
        if matrix.pattern.size == 0:
            return EmptyFactor()
        memory = self._analyses.take(matrix.pattern)
        if not memory.factorize(matrix.values):
            return None
        factor = _Factor(memory)
        self._analyses.give(memory, factor)
        return factor


class _Factor:
    def __init__(self, memory: Panels | Band):
        self.memory = memory
        self.solve = memory.solve
