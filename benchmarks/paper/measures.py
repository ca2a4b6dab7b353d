"""Numbers read off the runs of the three models that statements of the paper's section 5 are held against."""

import numpy as np

from .places import into_eighth
from .runs import Result
from .watch import Watched

FIRST, SECOND = (0.5, 1.35), (1.5, 2.4)
"""s: where the two peaks of the strain energy are looked for."""


def peak(result: Result, values: np.ndarray, span: tuple[float, float]) -> tuple[float, float]:
    """Time (s) and value of the largest value in a span of time."""
    inside = np.flatnonzero((result.times >= span[0]) & (result.times <= span[1]))
    best = inside[np.argmax(values[inside])]
    return float(result.times[best]), float(values[best])


def valley(result: Result, values: np.ndarray, span: tuple[float, float]) -> tuple[float, float]:
    """Time (s) and value of the least value in a span of time."""
    time, value = peak(result, -values, span)
    return time, -value


def oscillation(result: Result, values: np.ndarray, span: tuple[float, float], window: float = 0.1) -> float:
    """Root mean square of what is left of the values when their moving mean over `window` (s) is taken away."""
    step = 1e-3
    time = np.arange(span[0] - window, span[1] + window, step)
    even = np.interp(time, result.times, values)
    width = round(window / step)
    smooth = np.convolve(even, np.full(width, 1.0 / width), mode="same")
    inside = (time >= span[0]) & (time <= span[1])
    return float(np.sqrt(np.mean((even - smooth)[inside] ** 2)))


def turns_per_second(result: Result, values: np.ndarray, span: tuple[float, float]) -> float:
    """Maxima of the values per second."""
    inside = values[(result.times >= span[0]) & (result.times <= span[1])]
    rising = np.diff(inside) > 0.0
    return float(np.count_nonzero(rising[:-1] & ~rising[1:]) / (span[1] - span[0]))


def state_shares(result: Result, time: float) -> tuple[float, float, float]:
    """Shares of the area that are taut, wrinkled and slack."""
    n = result.at(time)
    return tuple(float(result.history[name][n]) for name in ("taut", "wrinkled", "slack"))


def stress(result: Result, time: float) -> np.ndarray:
    """(np,) von Mises stress at the points of the drawn sub-mesh, Pa."""
    n = result.at(time)
    return result.surface.frame(result.times[n], result.q[n]).fields["von_mises"]


def most_stressed(result: Result, time: float, share: float = 0.02) -> np.ndarray:
    """(k, 2) places in one eighth of the flat sheet: the given share of the drawn points, with the largest stress."""
    values = stress(result, time)
    return into_eighth(result.surface.submesh.flat[values >= np.quantile(values, 1.0 - share)])


def touched(watched: Watched, place: tuple[float, float], within: float = 0.025) -> np.ndarray:
    """(n,) bool: in these states a contact force acts closer than `within` (m) to a place or one of its images."""
    near = [np.linalg.norm(into_eighth(touch.flat.reshape(-1, 2)) - place, axis=1) for touch in watched.touches]
    return np.array([bool(len(distances)) and distances.min() < within for distances in near])


def flatness(result: Result, time: float) -> float:
    """Largest height of the sheet above the plane of its corners, m."""
    n = result.at(time)
    return float(np.abs(result.surface.frame(result.times[n], result.q[n]).points[:, 2]).max())
