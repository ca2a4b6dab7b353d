"""Time profiles of drivers and loads: a dimensionless factor and its first two time derivatives."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Profile:
    """Factor that multiplies a prescribed motion or a load.

    Attributes:
        kind: "constant" (1), "linear", "smooth" (10 s^3 - 15 s^4 + 6 s^5), "trapezoid" (trapezoidal velocity, ramps
            of a quarter of the time) or "table" (straight lines between rows, constant outside).
        start, end: s, the factor goes from 0 to 1 between them.
        table: (k, 2) rows of time (s) and factor, for "table".
    """

    kind: str
    start: float = 0.0
    end: float = 1.0
    table: np.ndarray | None = None

    def __call__(self, time: float, derivative: int = 0) -> float:
        """The factor (derivative = 0), or its first (1/s) or second (1/s^2) derivative, from the right at kinks."""
        if self.kind == "constant":
            return 1.0 if derivative == 0 else 0.0
        if self.kind == "table":
            return self._interpolate(time, derivative)
        length = self.end - self.start
        s = (time - self.start) / length
        if s < 0.0:
            return 0.0
        if s >= 1.0:
            return 1.0 if derivative == 0 else 0.0
        return _UNIT_PROFILES[self.kind](s)[derivative] / length**derivative

    @property
    def kinks(self) -> tuple[float, ...]:
        """s, times at which the velocity or acceleration of the factor jumps."""
        if self.kind == "linear":
            return (self.start, self.end)
        if self.kind == "trapezoid":
            return tuple(self.start + share * (self.end - self.start) for share in (0.0, 0.25, 0.75, 1.0))
        return tuple(float(t) for t in self.table[:, 0]) if self.kind == "table" else ()

    def _interpolate(self, time: float, derivative: int) -> float:
        times, factors = self.table.T
        if derivative == 0:
            return float(np.interp(time, times, factors))
        k = int(np.searchsorted(times, time, side="right")) - 1
        if derivative == 2 or k < 0 or k >= len(times) - 1:
            return 0.0
        return float((factors[k + 1] - factors[k]) / (times[k + 1] - times[k]))


def _linear(s: float) -> tuple[float, float, float]:
    return s, 1.0, 0.0


def _smooth(s: float) -> tuple[float, float, float]:
    return (
        s**3 * (10.0 - 15.0 * s + 6.0 * s**2),
        30.0 * s**2 * (1.0 - s) ** 2,
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
    )


def _trapezoid(s: float) -> tuple[float, float, float]:
    top = 4.0 / 3.0  # the velocity that covers 1 with ramps of a quarter
    if s < 0.25:
        return 2.0 * top * s**2, 4.0 * top * s, 4.0 * top
    if s < 0.75:
        return top * (s - 0.125), top, 0.0
    return 1.0 - 2.0 * top * (1.0 - s) ** 2, 4.0 * top * (1.0 - s), -4.0 * top


_UNIT_PROFILES = {"linear": _linear, "smooth": _smooth, "trapezoid": _trapezoid}
