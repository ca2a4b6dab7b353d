"""What the runs of a study cost and how far each is from the reference."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warp_origami.scene import Scene

from .compare import Statistics, end_error, length_scale, motion_error, pareto_front, values_error
from .measured_study import MeasuredStudy
from .measurement import Measurement
from .settings import OWN, Setting

NAN = float("nan")
TARGETS = (1e-2, 1e-3, 1e-4)

RESOLVED = 1e-9
"""Errors below count as this: nobody pays for less."""


@dataclass(frozen=True, eq=False)
class Row:
    """A setting with its cost and error; NaN where there is none.

    Attributes:
        setting: what was varied.
        run: what it gave.
        seconds: wall time over what is compared.
        memory: peak, bytes.
        error: against the reference.
        error_on_mesh: of a motion, against the finest run on the same mesh: the share of the steps in the error.
        status: of the run; "done" too where it got through the window and no further.
        front, front_on_mesh, front_of_memory: no other row costs less (seconds, seconds on the scene's own mesh,
            memory) without a larger error.
        statistics: of a motion that went to its end.
        deviations: of these from those of the reference's.
    """

    setting: Setting
    run: Measurement
    seconds: float
    memory: float
    error: float
    error_on_mesh: float
    status: str
    front: bool = False
    front_on_mesh: bool = False
    front_of_memory: bool = False
    statistics: Statistics | None = None
    deviations: dict[str, float] | None = None


@dataclass(frozen=True)
class Findings:
    """All rows, and what they are held against.

    Attributes:
        scene: that was run.
        rows: in the order of their ends.
        conditions: machine, versions, runs side by side.
        reference: what errors are against.
        measure: what an error is.
        known: the error down to which the reference is known: how far the next finer run to it is, in steps and in
            mesh; 0 for exact values, NaN where nothing tells.
        reference_on_mesh: what errors on the scene's own mesh are against, empty if that is the reference.
        statistics_of: run that statistics are held against, empty without.
        repeated: relative difference of the seconds of two runs of the scene's own settings.
    """

    scene: Scene
    rows: tuple[Row, ...]
    conditions: dict
    reference: str
    measure: str
    known: float
    reference_on_mesh: str
    statistics_of: str
    repeated: float

    def shown_error(self, row: Row) -> float:
        """The error, as far as the reference can tell it."""
        return _resolved(row.error, self.known)

    def cheapest(self, target: float, on_mesh: bool = False) -> Row | None:
        """The cheapest setting whose error (on the scene's own mesh) is at most `target`; None without one."""
        errors = [_error_on_own_mesh(row) if on_mesh else self.shown_error(row) for row in self.rows]
        good = [row for row, error in zip(self.rows, errors, strict=True) if error <= target]
        return min(good, key=lambda row: row.seconds, default=None)


def _resolved(error: float, known: float) -> float:
    return float(np.maximum(error, max(RESOLVED, np.nan_to_num(known))))


def _error_on_own_mesh(row: Row) -> float:
    return NAN if row.setting.mesh else _resolved(row.error_on_mesh, NAN)


def findings_of_motion(study: MeasuredStudy, reference: Setting, window: int) -> Findings:
    """Of runs compared over the first `window` frames with the run of `reference`."""
    runs, size = study.runs, study.mesh.size
    scale = length_scale(runs[reference], size) if reference in runs and len(runs[reference].times) else size
    finest = {mesh: _finest(runs, mesh, window) for mesh in {setting.mesh for setting in runs}}
    rows = []
    for setting, run in runs.items():
        there = len(run.times) >= window > 0
        error = motion_error(run, runs[reference], window, scale) if there and setting != reference else NAN
        best = finest[setting.mesh]
        on_mesh = motion_error(run, runs[best], window, scale) if there and best not in (None, setting) else NAN
        cost = (float(run.seconds[window - 1]), float(run.memory[window - 1])) if there else (NAN, NAN)
        status = "done" if there and run.status == "timed out" else run.status
        rows.append(Row(setting, run, *cost, error, on_mesh, status))
    rows, statistics_of = _with_statistics(rows, study.end)
    on_mesh = finest.get(())
    with_mesh = "" if reference.mesh else "; no finer mesh was compared"
    time = runs[reference].times[window - 1] if window else 0.0
    neighbours = _neighbours(study, reference, finest, window)
    known = max((motion_error(runs[one], runs[reference], window, scale) for one in neighbours), default=NAN)
    over = "the size of the sheet" if scale == size else f"the largest displacement, {scale:.3g} m"
    return Findings(
        study.scene,
        tuple(_with_fronts(rows, known)),
        study.pool.conditions,
        f"its own finest run ({reference.label}{with_mesh})",
        f"RMS of positions up to {time:.4g} s, over {over}",
        known,
        on_mesh.label if on_mesh and reference.mesh else "",
        statistics_of,
        _repeated(rows),
    )


def _finest(runs: dict[Setting, Measurement], mesh: tuple[str, ...], window: int) -> Setting | None:
    """The run with the finest steps on a mesh that got through the window; only steps or tolerance are varied in it."""
    sound = _stepped(runs, mesh, window)
    return max(sound, key=lambda one: one.fineness, default=None)


def _neighbours(study: MeasuredStudy, reference: Setting, finest: dict, window: int) -> list[Setting]:
    """The runs next to the reference: on its mesh with coarser steps, and on the next coarser mesh."""
    steps = [one for one in _stepped(study.runs, reference.mesh, window) if one.fineness < reference.fineness]
    found = [max(steps, key=lambda one: one.fineness)] if steps else []
    coarser = [one for one in finest.values() if one and study.elements(one) < study.elements(reference)]
    return found + ([max(coarser, key=study.elements)] if coarser else [])


def _stepped(runs: dict[Setting, Measurement], mesh: tuple[str, ...], window: int) -> list[Setting]:
    return [
        setting
        for setting, run in runs.items()
        if setting.mesh == mesh and setting.only_steps and len(run.times) >= window > 0
    ]


def _with_statistics(rows: Sequence[Row], end: float) -> tuple[list[Row], str]:
    """Rows with statistics of the runs that went to their end, and the label of the reference of these: the finest
    steps on the scene's own mesh."""
    whole = [row for row in rows if row.run.status == "done" and row.run.times[-1] >= end * (1.0 - 1e-6)]
    candidates = [row for row in whole if row.setting.only_steps and not row.setting.mesh]
    if not candidates:
        return list(rows), ""
    best = max(candidates, key=lambda row: row.setting.fineness)
    known = Statistics.of(best.run)
    found = []
    for row in rows:
        if row in whole:
            statistics = Statistics.of(row.run)
            row = replace(row, statistics=statistics, deviations=statistics.deviations(known))
        found.append(row)
    return found, best.setting.label


def findings_at_end(study: MeasuredStudy) -> Findings:
    """Of runs whose ends are compared: with known values, else with the run on the finest mesh."""
    scene, runs = study.scene, study.runs
    done = {setting: run for setting, run in runs.items() if run.status == "done"}
    finest = max((one for one in done if one.only_steps), key=study.weight, default=OWN)
    rows = []
    for setting, run in runs.items():
        error = NAN if setting not in done else _end_error(study, run, done[finest], setting == finest)
        summary = run.summary if setting in done else {}
        cost = (summary.get("wall_seconds", NAN), summary.get("peak_memory_bytes", NAN))
        rows.append(Row(setting, run, *cost, error, NAN, run.status))
    exact = scene.verification
    if exact is not None:
        known = 0.0
        reference = f"exact values ({exact.source})"
        measure = "largest relative error of " + ", ".join(value.name for value in exact.value)
    else:
        others = [one for one in done if one.only_steps and study.elements(one) < study.elements(finest)]
        second = max(others, key=study.elements, default=None)
        known = _end_error(study, done[second], done[finest], False) if second else NAN
        reference = f"its own finest mesh ({finest.label})"
        measure = "largest relative error of the frequencies"
        if scene.analysis.kind != "modal":
            measure = "RMS of positions at the end, over the size of the sheet (the displacement where that is small)"
    return Findings(
        scene,
        tuple(_with_fronts(rows, known)),
        study.pool.conditions,
        reference,
        measure,
        known,
        "",
        "",
        _repeated(rows),
    )


def _end_error(study: MeasuredStudy, run: Measurement, finest: Measurement, is_finest: bool) -> float:
    known = study.scene.verification
    if known is not None:
        return values_error(run.values, [value.exact for value in known.value])
    if is_finest:
        return NAN
    if study.scene.analysis.kind == "modal":
        return values_error(run.summary["frequencies"], finest.summary["frequencies"])
    return end_error(run, finest, length_scale(finest, study.mesh.size))


def _with_fronts(rows: Sequence[Row], known: float) -> list[Row]:
    fronts = (
        pareto_front([(row.seconds, _resolved(row.error, known)) for row in rows]),
        pareto_front([(row.seconds, _error_on_own_mesh(row)) for row in rows]),
        pareto_front([(row.memory, _resolved(row.error, known)) for row in rows]),
    )
    return [
        replace(row, front=a, front_on_mesh=b, front_of_memory=c) for row, a, b, c in zip(rows, *fronts, strict=True)
    ]


def _repeated(rows: Sequence[Row]) -> float:
    """Relative difference of the seconds of the runs of the scene's own settings."""
    seconds = [row.seconds for row in rows if row.setting.varied == OWN.varied and np.isfinite(row.seconds)]
    return abs(seconds[1] - seconds[0]) / min(seconds) if len(seconds) == 2 else NAN
