"""Symmetric quadrature rules on the triangle, paper (5).

All points lie inside and all weights are positive. Source of the orbits: D. A. Dunavant, High degree efficient
symmetrical Gaussian quadrature rules for the triangle, Int. J. Numer. Meth. Eng. 21 (1985), refined to 22 digits.
"""

from itertools import permutations

import numpy as np

_CENTROID = 1.0 / 3.0

_ORBITS: dict[int, tuple[tuple[float, float, float], ...]] = {
    1: ((1.0, _CENTROID, _CENTROID),),
    2: ((1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0),),
    4: (
        (0.2233815896780114656950, 0.4459484909159648863183, 0.4459484909159648863183),
        (0.1099517436553218676383, 0.09157621350977074345957, 0.09157621350977074345957),
    ),
    5: (
        (0.225, _CENTROID, _CENTROID),
        (0.1323941527885061807376, 0.4701420641051150897704, 0.4701420641051150897704),
        (0.1259391805448271525957, 0.1012865073234563388010, 0.1012865073234563388010),
    ),
    6: (
        (0.1167862757263793660253, 0.2492867451709104212916, 0.2492867451709104212916),
        (0.05084490637020681692094, 0.06308901449150222834033, 0.06308901449150222834033),
        (0.08285107561837357519355, 0.3103524510337844054166, 0.05314504984481694735325),
    ),
    8: (
        (0.1443156076777871682511, _CENTROID, _CENTROID),
        (0.09509163426728462479390, 0.4592925882927231560288, 0.4592925882927231560288),
        (0.1032173705347182502818, 0.1705693077517602066223, 0.1705693077517602066223),
        (0.03245849762319808031093, 0.05054722831703097545842, 0.05054722831703097545842),
        (0.02723031417443499426484, 0.2631128296346381134218, 0.008394777409957605337214),
    ),
}
"""Per degree the orbits (weight of one point, two of its area coordinates)."""

HIGHEST_DEGREE = max(_ORBITS)


def rule(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Area coordinates (n, 3) and weights (n,) summing to 1 of the smallest rule exact for polynomials of `degree`.

    Points per degree: 1: 1, 2: 3, 3 and 4: 6, 5: 7, 6: 12, 7 and 8: 16.

    Raises:
        ValueError: no rule of that degree is tabulated.
    """
    if not 1 <= degree <= HIGHEST_DEGREE:
        raise ValueError(f"quadrature degree: got {degree}, wants 1 to {HIGHEST_DEGREE}")
    orbits = _ORBITS[min(d for d in _ORBITS if d >= degree)]
    areas, weights = [], []
    for weight, a, b in orbits:
        points = sorted(set(permutations((a, b, 1.0 - a - b)))) if a != _CENTROID else [(a, a, a)]
        areas += points
        weights += [weight] * len(points)
    return np.array(areas), np.array(weights)
