"""What is known of pairs, by their names."""

import numpy as np


def look_up(names: np.ndarray, known: np.ndarray, values: np.ndarray, otherwise: float) -> np.ndarray:
    """Values (n,) of pairs `names` (n,), `otherwise` where a pair is not known.

    Args:
        known: (k,) names, increasing.
        values: (k,) of these.
    """
    result = np.full(len(names), otherwise, dtype=values.dtype)
    if len(known):
        place = np.minimum(np.searchsorted(known, names), len(known) - 1)
        there = known[place] == names
        result[there] = values[place[there]]
    return result
