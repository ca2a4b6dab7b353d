"""Errors of one case over its meshes: relative errors, order, extrapolated value, and whether tolerances are kept.

    e(n) = c n^-p,   p = log(e_1 / e_2) / log(n_2 / n_1),   extrapolated: x_2 + (x_2 - x_1) / ((n_2 / n_1)^p - 1)

with the fineness n: the root of the number of elements, or the number of steps where the mesh stays the same.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

ROUND_OFF = 1e-11
"""Errors below it have no order."""

LEAST_RATIO = 2.0
"""Of one change to the next: below it, which is about order one where meshes are halved, nothing is extrapolated."""


@dataclass(frozen=True)
class Claim:
    """A value that is known.

    Attributes:
        name: with its unit if it has one.
        exact: the value.
        tolerances: largest error on each mesh, None where none is stated.
    """

    name: str
    exact: float
    tolerances: tuple[float | None, ...]

    def error(self, obtained: float) -> float:
        """Relative error, absolute where the exact value is 0."""
        return (obtained - self.exact) / (abs(self.exact) or 1.0)


@dataclass(frozen=True)
class Level:
    """What one mesh (or step size) gave.

    Attributes:
        label: what tells it from the others.
        elements: 0 for a case without a sheet.
        steps: accepted load or time steps.
        seconds: wall time, without compilation.
        obtained: a number per claim; NaN where the run failed.
        failure: why the run failed.
        remarks: what the run has no value of.
    """

    label: str
    elements: int
    steps: int
    seconds: float
    obtained: tuple[float, ...]
    failure: str | None = None
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Convergence:
    """A case over its meshes, from coarse to fine.

    Attributes:
        name: of the case.
        source: where the exact values come from.
        claims: what is known.
        levels: what was obtained, on the first meshes of the case or on all.
    """

    name: str
    source: str
    claims: tuple[Claim, ...]
    levels: tuple[Level, ...]

    def fineness(self) -> list[float]:
        """n of every level."""
        if len({level.elements for level in self.levels}) == 1:
            return [float(level.steps) for level in self.levels]
        return [math.sqrt(level.elements) for level in self.levels]

    def errors(self, claim: int) -> list[float]:
        """Signed error on every level."""
        return [self.claims[claim].error(level.obtained[claim]) for level in self.levels]

    def order(self, claim: int) -> float | None:
        """Order of the error between the last two levels; None where there is none."""
        if len(self.levels) < 2:
            return None
        coarse, fine = (abs(error) for error in self.errors(claim)[-2:])
        n = self.fineness()[-2:]
        if not (_increase(n) and ROUND_OFF < coarse < math.inf and ROUND_OFF < fine < math.inf):
            return None
        return math.log(coarse / fine) / math.log(n[1] / n[0])

    def extrapolated(self, claim: int) -> float | None:
        """Richardson extrapolation of the last three levels, with the order that they show; None where they show none.

        The exact value takes no part. Changes that hardly fall are no power of the fineness yet, and what follows from
        them is off by more than the finest mesh is.
        """
        if len(self.levels) < 3:
            return None
        one, two, three = (level.obtained[claim] for level in self.levels[-3:])
        n = self.fineness()[-3:]
        before, after = two - one, three - two
        even = _increase(n) and math.isclose(n[2] / n[1], n[1] / n[0], rel_tol=0.05)
        if not (even and before * after > 0.0 and LEAST_RATIO <= before / after < math.inf):
            return None
        return three + after / (before / after - 1.0)

    def holds(self, claim: int, level: int) -> bool | None:
        """Whether the tolerance is kept on a level; None where none is stated, False where there is no number."""
        tolerance = self.claims[claim].tolerances[level]
        if self.levels[level].failure is not None or not math.isfinite(self.levels[level].obtained[claim]):
            return False
        return None if tolerance is None else abs(self.errors(claim)[level]) <= tolerance

    @property
    def converges(self) -> bool:
        """Whether any error has an order: there are several levels, and more than round-off."""
        return any(self.order(k) is not None for k in range(len(self.claims)))

    @property
    def passed(self) -> bool:
        """Whether every stated tolerance is kept, and every run ended well."""
        checks = [self.holds(k, i) for k in range(len(self.claims)) for i in range(len(self.levels))]
        return False not in checks


def _increase(fineness: list[float]) -> bool:
    """Whether every level is finer than the one before."""
    return all(0.0 < coarse < fine for coarse, fine in pairwise(fineness))
