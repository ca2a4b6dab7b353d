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

BUSY = 0.8
"""Share of the wall time that the runs had the processor for, below which processor time is compared instead."""

RESOLVED = 1e-9
"""Errors below count as this: nobody pays for less."""

Runs = dict[Setting, Measurement]


@dataclass(frozen=True, eq=False)
class Row:
    """A setting with its cost and error; NaN where there is none.

    Attributes:
        setting: what was varied.
        run: what it gave.
        status: of the run; "done" too where it got through the window and no further.
        wall, processor: s, over what is compared.
        memory: peak, bytes.
        error: against the reference.
        error_on_mesh: of a motion, against the finest run on the same mesh: the share of the steps in the error.
        seconds: wall or processor, whichever counts.
        front, front_on_mesh, front_of_memory: no other row costs less (seconds, seconds on the scene's own mesh,
            memory) without a larger error.
        statistics: of a motion that went to its end.
        deviations: of these from those of the finest run.
    """

    setting: Setting
    run: Measurement
    status: str
    wall: float
    processor: float
    memory: float
    error: float
    error_on_mesh: float = NAN
    seconds: float = NAN
    front: bool = False
    front_on_mesh: bool = False
    front_of_memory: bool = False
    statistics: Statistics | None = None
    deviations: dict[str, float] | None = None


@dataclass(frozen=True)
class Against:
    """What the runs are held against.

    Attributes:
        reference: of the errors.
        measure: what an error is.
        known: the error down to which the reference is known: how far the next run to it is, in steps and in mesh; 0
            for exact values, NaN where nothing tells.
        reference_on_mesh: of the errors on the scene's own mesh, empty if that is the reference.
        statistics_of: run that statistics are held against, empty without.
    """

    reference: str
    measure: str
    known: float
    reference_on_mesh: str = ""
    statistics_of: str = ""


@dataclass(frozen=True)
class Findings:
    """All rows, and what they are held against.

    Attributes:
        scene: that was run.
        rows: in the order of their ends.
        conditions: machine, versions, runs side by side.
        against: references.
        clock: "wall", or "processor" where the machine was too busy for wall time to mean much.
        busy: processor time over wall time, median of all runs.
        repeated: relative difference of the seconds of two runs of the scene's own settings.
    """

    scene: Scene
    rows: tuple[Row, ...]
    conditions: dict
    against: Against
    clock: str
    busy: float
    repeated: float

    @classmethod
    def of(cls, scene: Scene, rows: Sequence[Row], conditions: dict, against: Against) -> "Findings":
        """Findings with the clock that means something, and the fronts."""
        shares = [row.processor / row.wall for row in rows if np.isfinite(row.wall)]
        busy = float(np.median(shares)) if shares else NAN
        clock = "processor" if busy < BUSY else "wall"
        rows = _with_fronts([replace(row, seconds=getattr(row, clock)) for row in rows], against.known)
        same = [row.seconds for row in rows if row.setting.varied == OWN.varied and np.isfinite(row.seconds)]
        repeated = abs(same[1] - same[0]) / min(same) if len(same) == 2 else NAN
        return cls(scene, tuple(rows), conditions, against, clock, busy, repeated)

    def shown_error(self, row: Row) -> float:
        """The error, as far as the reference can tell it."""
        return _resolved(row.error, self.against.known)

    def cheapest(self, target: float, on_mesh: bool = False) -> Row | None:
        """The cheapest setting whose error (on the scene's own mesh) is at most `target`; None without one."""
        errors = [_error_on_own_mesh(row) if on_mesh else self.shown_error(row) for row in self.rows]
        good = [row for row, error in zip(self.rows, errors, strict=True) if error <= target]
        return min(good, key=lambda row: row.seconds, default=None)


def _resolved(error: float, known: float) -> float:
    return float(np.maximum(error, max(RESOLVED, np.nan_to_num(known))))


def _error_on_own_mesh(row: Row) -> float:
    return NAN if row.setting.mesh else _resolved(row.error_on_mesh, NAN)


def _with_fronts(rows: Sequence[Row], known: float) -> list[Row]:
    fronts = (
        pareto_front([(row.seconds, _resolved(row.error, known)) for row in rows]),
        pareto_front([(row.seconds, _error_on_own_mesh(row)) for row in rows]),
        pareto_front([(row.memory, _resolved(row.error, known)) for row in rows]),
    )
    return [
        replace(row, front=a, front_on_mesh=b, front_of_memory=c) for row, a, b, c in zip(rows, *fronts, strict=True)
    ]


def findings_of_motion(study: MeasuredStudy, reference: Setting, window: int) -> Findings:
    """Of runs compared over the first `window` frames with the run of `reference`."""
    runs = study.runs
    best = runs.get(reference, Measurement.without("not run", ""))
    size = study.mesh.size
    scale = length_scale(best, size) if len(best.times) else size
    finest = {mesh: _finest(runs, mesh, window) for mesh in {setting.mesh for setting in runs}}

    def error(setting: Setting, known: Setting | None) -> float:
        return motion_error(runs[setting], runs[known], window, scale) if known not in (None, setting) else NAN

    rows = []
    for setting, run in runs.items():
        there = len(run.times) >= window > 0
        costs = [float(one[window - 1]) if there else NAN for one in (run.seconds, run.processor, run.memory)]
        errors = [error(setting, known if there else None) for known in (reference, finest[setting.mesh])]
        rows.append(Row(setting, run, "done" if there and run.status == "timed out" else run.status, *costs, *errors))
    rows, statistics_of = _with_statistics(rows, study.end)
    neighbours = _neighbours(study, reference, finest, window)
    on_mesh = finest.get(()) if reference.mesh else None
    over = "the size of the sheet" if scale == size else f"the largest displacement, {scale:.3g} m"
    against = Against(
        f"its own finest run ({reference.label}{'' if reference.mesh else '; no finer mesh was compared'})",
        f"RMS of positions up to {best.times[window - 1] if window else 0.0:.4g} s, over {over}",
        max((error(one, reference) for one in neighbours), default=NAN),
        on_mesh.label if on_mesh else "",
        statistics_of,
    )
    return Findings.of(study.scene, rows, study.pool.conditions, against)


def _finest(runs: Runs, mesh: tuple[str, ...], window: int) -> Setting | None:
    """The run with the finest steps on a mesh that got through the window; only steps or tolerance are varied in it."""
    return max(_stepped(runs, mesh, window), key=lambda one: one.fineness, default=None)


def _neighbours(study: MeasuredStudy, reference: Setting, finest: dict, window: int) -> list[Setting]:
    """The runs next to the reference: on its mesh with coarser steps, and on the next coarser mesh."""
    steps = [one for one in _stepped(study.runs, reference.mesh, window) if one.fineness < reference.fineness]
    found = [max(steps, key=lambda one: one.fineness)] if steps else []
    coarser = [one for one in finest.values() if one and study.elements(one) < study.elements(reference)]
    return found + ([max(coarser, key=study.elements)] if coarser else [])


def _stepped(runs: Runs, mesh: tuple[str, ...], window: int) -> list[Setting]:
    through = [setting for setting, run in runs.items() if len(run.times) >= window > 0]
    return [setting for setting in through if setting.mesh == mesh and setting.only_steps]


def _with_statistics(rows: Sequence[Row], end: float) -> tuple[list[Row], str]:
    """Rows with statistics of the runs that went to their end, and the label of what these are held against: the run
    with the finest steps on the scene's own mesh."""
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
    scene, done = study.scene, {setting: run for setting, run in study.runs.items() if run.status == "done"}
    finest = max((one for one in done if one.only_steps), key=study.elements, default=OWN)

    def error(setting: Setting) -> float:
        if scene.verification is not None:
            return values_error(done[setting].values, [value.exact for value in scene.verification.value])
        if setting == finest:
            return NAN
        if scene.analysis.kind == "modal":
            return values_error(done[setting].summary["frequencies"], done[finest].summary["frequencies"])
        return end_error(done[setting], done[finest], length_scale(done[finest], study.mesh.size))

    if scene.verification is not None:
        names = ", ".join(value.name for value in scene.verification.value)
        against = Against(f"exact values ({scene.verification.source})", f"largest relative error of {names}", 0.0)
    else:
        coarser = [one for one in done if one.only_steps and study.elements(one) < study.elements(finest)]
        second = max(coarser, key=study.elements, default=None)
        measure = "RMS of positions at the end, over the size of the sheet, or the displacement where that is small"
        if scene.analysis.kind == "modal":
            measure = "largest relative error of the frequencies"
        against = Against(f"its own finest mesh ({finest.label})", measure, error(second) if second else NAN)
    rows = []
    for setting, run in study.runs.items():
        costs = run.summary.get("wall_seconds", NAN), run.processor_seconds, run.summary.get("peak_memory_bytes", NAN)
        known = setting in done
        rows.append(Row(setting, run, run.status, *(costs if known else 3 * [NAN]), error(setting) if known else NAN))
    return Findings.of(scene, rows, study.pool.conditions, against)
