"""Errors of measured runs: of motions, of their energies over the whole run, of known values; the Pareto front."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..measured.measurement import Measurement

AGREEMENT = 1e-3
"""Over the length scale: two runs whose vertices differ by less, in the root mean square, agree."""

SMALL_MOTION = 0.1
"""Over the size of the sheet: where no vertex goes farther, errors are held against how far they go."""

GAIN = 0.9
"""A dearer setting is worth it if it errs less than this times what a cheaper one does."""


def length_scale(reference: Measurement, size: float) -> float:
    """What errors of positions are divided by, m: the size of the sheet, or the largest displacement where that is
    small."""
    moved = np.linalg.norm(reference.positions - reference.positions[:1], axis=-1)
    largest = float(np.nanmax(moved, initial=0.0))
    return largest if 0.0 < largest < SMALL_MOTION * size else size


def differences(a: Measurement, b: Measurement) -> np.ndarray:
    """(n,) m, root mean square over the compared vertices of the distance, at each frame that both have."""
    n = min(len(a.times), len(b.times))
    squares = np.sum((a.positions[:n] - b.positions[:n]) ** 2, axis=-1)
    known = ~np.isnan(squares)
    count = known.sum(axis=-1)
    total = np.where(known, squares, 0.0).sum(axis=-1)
    return np.sqrt(np.divide(total, count, out=np.full(n, np.nan), where=count > 0))


def agreement(a: Measurement, b: Measurement, scale: float) -> int:
    """Number of frames, from the first, up to which two runs agree, for a length scale in m."""
    apart = differences(a, b) > AGREEMENT * scale
    return int(np.argmax(apart)) if apart.any() else len(apart)


def motion_error(run: Measurement, reference: Measurement, frames: int, scale: float) -> float:
    """Root mean square over vertices and the first `frames` frames of the distance, over a length scale (m); NaN if
    either run has fewer frames."""
    if not min(len(run.times), len(reference.times)) >= frames > 0:
        return float("nan")
    return float(np.sqrt(np.mean(differences(run, reference)[:frames] ** 2)) / scale)


def end_error(run: Measurement, reference: Measurement, scale: float) -> float:
    """Root mean square over vertices of the distance in the last frame, over a length scale (m)."""
    if not len(run.times) or not len(reference.times):
        return float("nan")
    squares = np.sum((run.positions[-1] - reference.positions[-1]) ** 2, axis=-1)
    known = squares[~np.isnan(squares)]
    return float(np.sqrt(known.mean()) / scale) if len(known) else float("nan")


def values_error(values: Sequence[float], exact: Sequence[float]) -> float:
    """Largest relative error of several values, absolute where 0 is exact; NaN if there is none."""
    errors = [abs(value - known) / (abs(known) or 1.0) for value, known in zip(values, exact, strict=False)]
    return float(np.max(errors)) if len(errors) == len(exact) > 0 else float("nan")


@dataclass(frozen=True)
class Statistics:
    """What a chaotic motion is compared by over the whole run.

    Attributes:
        mean_kinetic, max_kinetic, mean_strain, max_strain: means over time and largest values of energies, J.
        energy_gain, energy_loss: as in summary.json.
        last_contact: time of the last row with contact, s; 0 without any.
        max_penetration: m.
    """

    mean_kinetic: float
    max_kinetic: float
    mean_strain: float
    max_strain: float
    energy_gain: float
    energy_loss: float
    last_contact: float
    max_penetration: float

    @classmethod
    def of(cls, run: Measurement) -> "Statistics":
        """Of a run that went to its end."""
        time, kinetic, strain = (run.history[name] for name in ("time", "kinetic_energy", "strain_energy"))
        touching = (run.history["contacts_sts"] + run.history["contacts_nts"]) > 0
        return cls(
            float(np.trapezoid(kinetic, time) / time[-1]),
            float(kinetic.max()),
            float(np.trapezoid(strain, time) / time[-1]),
            float(strain.max()),
            run.summary["energy_gain"],
            run.summary["energy_loss"],
            float(time[touching].max(initial=0.0)),
            run.summary["max_penetration"],
        )

    def deviations(self, reference: "Statistics") -> dict[str, float]:
        """Deviation from the reference: energies relative to it, the others as differences."""
        found = {}
        for name, value in vars(self).items():
            known = getattr(reference, name)
            energy = name.endswith(("kinetic", "strain"))
            found[name] = (value - known) / known if energy and known else value - known
        return found


def pareto_front(points: Sequence[tuple[float, float]]) -> list[bool]:
    """Which points (cost, error) are worth their cost: from the cheapest on, what costs more must err less than
    GAIN times the best so far. Points with NaN never are."""
    best, chosen = np.inf, set()
    finite = [k for k, point in enumerate(points) if np.isfinite(point).all()]
    for k in sorted(finite, key=lambda k: points[k]):
        if points[k][1] < GAIN * best:
            best = points[k][1]
            chosen.add(k)
    return [k in chosen for k in range(len(points))]
