"""Ladders of easier problems that end in the one to be solved, for where Newton alone finds no equilibrium.

Loads: an unstressed sheet under small loads is all but inextensible, and a Newton step, straight where the motion is
curved, stretches it by far more than the loads ever will. So the loads are first taken large enough to stretch it by a
percent (as if it were softer) and let fall in decades.

Stiffness ratios: wrinkled, slack and taut parts differ in stiffness by up to 1 / s, which is too much while the states
are still unknown. So s1, s2 fall from 1e-1 to the material's in decades; states settle while they matter little to each
other.
"""

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from warp_origami.scene.sheet import Material
from warp_origami.terms.external import ExternalForce

LARGEST_RATIO = 0.1
LARGE_LOAD = 1e-2
"""Sum of the nodal forces over E h L at which loads count as large: p L / (E h) under pressure."""
LARGEST_MULTIPLE = 1e6


@dataclass(frozen=True)
class Rung:
    """One of the easier problems.

    Attributes:
        load: factor on all loads.
        s1, s2: stiffness ratios.
    """

    load: float
    s1: float
    s2: float


def ratio_ladder(material: Material) -> list[Rung]:
    """Decades of stiffness ratios from the largest down to the material's, without these."""
    smallest = min(material.s1, material.s2)
    if material.model == "linear" or smallest >= LARGEST_RATIO:
        return []
    falling = LARGEST_RATIO * 10.0 ** -np.arange(_decades(LARGEST_RATIO / smallest))
    return [Rung(1.0, max(s, material.s1), max(s, material.s2)) for s in falling.tolist()]


def load_ladder(material: Material, share: float) -> list[Rung]:
    """Decades of loads down to the true ones, without these.

    Args:
        share: sum of the nodal forces over E h L.
    """
    if not 0.0 < share < LARGE_LOAD:
        return []
    decades = _decades(min(LARGE_LOAD / share, LARGEST_MULTIPLE))
    return [Rung(10.0**k, material.s1, material.s2) for k in range(decades, 0, -1)]


def together(loads: list[Rung], ratios: list[Rung]) -> list[Rung]:
    """Both ladders at once, the shorter one ending first."""
    if not ratios:
        return []
    true_load, true_ratios = Rung(1.0, 0.0, 0.0), Rung(1.0, loads[0].s1, loads[0].s2)
    pairs = zip_longest(loads, ratios, fillvalue=None)
    return [Rung((a or true_load).load, (b or true_ratios).s1, (b or true_ratios).s2) for a, b in pairs]


def scaled(external: ExternalForce, factor: float) -> ExternalForce:
    """All loads times a factor."""
    pressures = tuple((term, factor * pressure) for term, pressure in external.pressures)
    return ExternalForce(factor * external.dead, pressures)


def _decades(ratio: float) -> int:
    return int(np.ceil(np.log10(ratio) - 1e-9))
