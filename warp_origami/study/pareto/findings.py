"""What the runs of a study cost and how far each is from the reference."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warp_origami.scene import Scene

from ..measured.measurement import Measurement
from .errors import Statistics, end_error, length_scale, motion_error, pareto_front, values_error
from .measured_study import MeasuredStudy
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
        wall, processor: s, over what is compared with the reference.
        memory: peak, bytes.
        error: against the reference.
        wall_on_mesh, processor_on_mesh, error_on_mesh: of a motion on the scene's own mesh, against the finest run on
            that: the share of the steps in the error.
        seconds, seconds_on_mesh: wall or processor, whichever counts.
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
    wall_on_mesh: float = NAN
    processor_on_mesh: float = NAN
    error_on_mesh: float = NAN
    seconds: float = NAN
    seconds_on_mesh: float = NAN
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
        measure_on_mesh, known_on_mesh: the same for these.
        statistics_of: run that statistics are held against, empty without.
    """

    reference: str
    measure: str
    known: float
    reference_on_mesh: str = ""
    measure_on_mesh: str = ""
    known_on_mesh: float = NAN
    statistics_of: str = ""


@dataclass(frozen=True)
class Findings:
    """All rows, and what they are held against.

    Attributes:
        scene: that was run.
        rows: by their labels.
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
        on_mesh = f"{clock}_on_mesh"
        rows = sorted(rows, key=lambda row: row.setting.label)  # whichever ended first: ties are settled alike
        rows = [replace(row, seconds=getattr(row, clock), seconds_on_mesh=getattr(row, on_mesh)) for row in rows]
        rows = _with_fronts(rows, against)
        same = [row.seconds for row in rows if row.setting.varied == OWN.varied and np.isfinite(row.seconds)]
        repeated = abs(same[1] - same[0]) / min(same) if len(same) == 2 else NAN
        return cls(scene, tuple(rows), conditions, against, clock, busy, repeated)

    def shown_error(self, row: Row) -> float:
        """The error, as far as the reference can tell it."""
        return _resolved(row.error, self.against.known)

    def shown_error_on_mesh(self, row: Row) -> float:
        """The same on the scene's own mesh."""
        return _resolved(row.error_on_mesh, self.against.known_on_mesh)

    def cheapest(self, target: float) -> Row | None:
        """The cheapest setting whose error is at most `target`; None without one."""
        good = [row for row in self.rows if self.shown_error(row) <= target]
        return min(good, key=lambda row: row.seconds, default=None)

    def cheapest_on_mesh(self, target: float) -> Row | None:
        """The same on the scene's own mesh."""
        good = [row for row in self.rows if self.shown_error_on_mesh(row) <= target]
        return min(good, key=lambda row: row.seconds_on_mesh, default=None)


def _resolved(error: float, known: float) -> float:
    return float(np.maximum(error, max(RESOLVED, np.nan_to_num(known))))


def _with_fronts(rows: Sequence[Row], against: Against) -> list[Row]:
    errors = [_resolved(row.error, against.known) for row in rows]
    on_mesh = [_resolved(row.error_on_mesh, against.known_on_mesh) for row in rows]
    fronts = (
        pareto_front([(row.seconds, error) for row, error in zip(rows, errors, strict=True)]),
        pareto_front([(row.seconds_on_mesh, error) for row, error in zip(rows, on_mesh, strict=True)]),
        pareto_front([(row.memory, error) for row, error in zip(rows, errors, strict=True)]),
    )
    return [
        replace(row, front=a, front_on_mesh=b, front_of_memory=c) for row, a, b, c in zip(rows, *fronts, strict=True)
    ]


def findings_of_motion(study: MeasuredStudy, reference: Setting, window: int, window_on_mesh: int) -> Findings:
    """Of runs compared with that of `reference` over the first `window` frames, and with the finest run on the scene's
    own mesh over the first `window_on_mesh`."""
    runs, size = study.runs, study.mesh.size
    frames = runs[reference].times if reference in runs else []
    scale = length_scale(runs[reference], size) if len(frames) else size
    finest = {mesh: _finest(runs, mesh, window) for mesh in {setting.mesh for setting in runs}}
    on_mesh = _finest(runs, (), window_on_mesh)

    def error(setting: Setting | None, known: Setting | None, among: int) -> float:
        if setting in (None, known) or known is None:
            return NAN
        return motion_error(runs[setting], runs[known], among, scale)

    rows = []
    for setting, run in runs.items():
        own = window_on_mesh if not setting.mesh else 0
        cost = [_at(one, window) for one in (run.seconds, run.processor, run.memory)]
        cost_on_mesh = [_at(one, own) for one in (run.seconds, run.processor)]
        through = run.status == "timed out" and len(run.times) >= max(window, own) > 0
        errors = error(setting, reference, window), error(setting, on_mesh, own)
        rows.append(Row(setting, run, "done" if through else run.status, *cost, errors[0], *cost_on_mesh, errors[1]))
    rows, statistics_of = _with_statistics(rows, study.end)
    over = "the size of the sheet" if scale == size else f"the largest displacement, {scale:.3g} m"
    neighbours = _neighbours(study, reference, finest, window)
    against = Against(
        f"its own finest run ({reference.label}{'' if reference.mesh else '; no finer mesh was compared'})",
        f"RMS of positions up to {_at(frames, window):.4g} s, over {over}",
        max((error(one, reference, window) for one in neighbours), default=NAN),
        statistics_of=statistics_of,
    )
    if reference.mesh and on_mesh is not None:
        against = replace(
            against,
            reference_on_mesh=on_mesh.label,
            measure_on_mesh=f"up to {_at(runs[on_mesh].times, window_on_mesh):.4g} s",
            known_on_mesh=error(_coarser_steps(runs, on_mesh, window_on_mesh), on_mesh, window_on_mesh),
        )
    return Findings.of(study.scene, rows, study.pool.conditions, against)


def _at(values: Sequence[float], window: int) -> float:
    """At the last frame of a window, NaN where that was not reached."""
    return float(values[window - 1]) if len(values) >= window > 0 else NAN


def _finest(runs: Runs, mesh: tuple[str, ...], window: int) -> Setting | None:
    """The run with the finest steps on a mesh that got through the window; only steps or tolerance are varied in it."""
    return max(_stepped(runs, mesh, window), key=lambda one: one.fineness, default=None)


def _neighbours(study: MeasuredStudy, reference: Setting, finest: dict, window: int) -> list[Setting]:
    """The runs next to the reference: on its mesh with coarser steps, and on the next coarser mesh."""
    coarser = [one for one in finest.values() if one and study.elements(one) < study.elements(reference)]
    found = [_coarser_steps(study.runs, reference, window), max(coarser, key=study.elements, default=None)]
    return [one for one in found if one is not None]


def _coarser_steps(runs: Runs, finest: Setting, window: int) -> Setting | None:
    """The run with the next coarser steps on the same mesh."""
    steps = [one for one in _stepped(runs, finest.mesh, window) if one.fineness < finest.fineness]
    return max(steps, key=lambda one: one.fineness, default=None)


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
            frequencies = [done[one].summary.get("frequencies", ()) for one in (setting, finest)]
            return values_error(*frequencies) if all(frequencies) else NAN
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
