"""What `pareto` says and writes: a table as CSV, lines for the terminal, plain sentences."""

import csv
import io
import math
from pathlib import Path
from statistics import median

from warp_origami.output.files import write_text
from warp_origami.scene import Scene

from .errors import Statistics
from .findings import TARGETS, Findings, Row

STATISTICS = tuple(Statistics.__dataclass_fields__)
KEYS = (
    "integrator.tolerance",
    "integrator.step",
    "integrator.spectral_radius",
    "integrator.quadrature",
    "integrator.constraints",
    "contact.method",
    "analysis.load_steps",
)
"""Settings with a column of their own."""

COLUMNS = (
    "setting",
    "varied",
    "mesh",
    *KEYS,
    "precision",
    "status",
    "elements",
    "dofs",
    "wall_seconds",
    "processor_seconds",
    "peak_memory_bytes",
    "error",
    "wall_seconds_on_mesh",
    "processor_seconds_on_mesh",
    "error_on_mesh",
    "front",
    "front_on_mesh",
    "front_of_memory",
    "whole_seconds",
    "steps_accepted",
    "newton_iterations",
    *STATISTICS,
    *(f"deviation_{name}" for name in STATISTICS),
    "message",
)


def write_table(path: Path, findings: Findings) -> None:
    """Writes all rows, cheapest first; what is not known is left empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(_cells(row, findings.scene) for row in in_order(findings))
    write_text(path, text.getvalue())


def in_order(findings: Findings) -> list[Row]:
    """Rows by their cost, those without one last."""
    return sorted(findings.rows, key=lambda row: row.seconds if math.isfinite(row.seconds) else math.inf)


def _cells(row: Row, scene: Scene) -> dict[str, object]:
    summary = row.run.summary
    changed = dict(change.split("=", 1) for change in row.setting.changes)
    cells = {
        "setting": row.setting.label,
        "varied": row.setting.varied,
        "mesh": " ".join(row.setting.mesh),
        **{key: changed.get(key, _own(scene, key)) for key in KEYS},
        "precision": summary.get("precision"),
        "status": row.status,
        "elements": summary.get("elements"),
        "dofs": summary.get("dofs"),
        "wall_seconds": _number(row.wall, 4),
        "processor_seconds": _number(row.processor, 4),
        "peak_memory_bytes": _number(row.memory, 12),
        "error": _number(row.error, 4),
        "wall_seconds_on_mesh": _number(row.wall_on_mesh, 4),
        "processor_seconds_on_mesh": _number(row.processor_on_mesh, 4),
        "error_on_mesh": _number(row.error_on_mesh, 4),
        "front": int(row.front),
        "front_on_mesh": int(row.front_on_mesh),
        "front_of_memory": int(row.front_of_memory),
        "message": row.run.message,
    }
    if row.statistics is not None or (row.run.status == "done" and len(row.run.values)):
        cells["whole_seconds"] = _number(summary["wall_seconds"], 4)
    for key in ("steps_accepted", "newton_iterations"):
        cells[key] = summary.get(key)
    for name in STATISTICS:
        cells[name] = _number(getattr(row.statistics, name), 6) if row.statistics else None
        cells[f"deviation_{name}"] = _number(row.deviations[name], 4) if row.deviations else None
    return cells


def _own(scene: Scene, key: str) -> object:
    table, name = key.split(".")
    return getattr(getattr(scene, table), name, None)


def _number(value: float, digits: int) -> str | None:
    return f"{value:.{digits}g}" if math.isfinite(value) else None


def lines(findings: Findings) -> list[str]:
    """The table for the terminal, and what follows from it."""
    motion = bool(findings.against.reference_on_mesh)
    width = max(len(row.setting.label) for row in findings.rows)
    found = [
        *headline(findings),
        "",
        f"    {'setting':<{width}} {'seconds':>8} {'MiB':>6} {'error':>8}"
        + (f" {'on mesh: s':>10} {'error':>8}" if motion else ""),
    ]
    for row in in_order(findings):
        marks = ("*" if row.front else " ") + ("+" if motion and row.front_on_mesh else " ")
        cells = (
            f"{marks:<4}{row.setting.label:<{width}} {_cell(row.seconds, '8.1f')} {_cell(row.memory / 2**20, '6.0f')}"
        )
        cells += f" {_error(row.error, findings.shown_error(row)):>8}"
        if motion:
            shown = _error(row.error_on_mesh, findings.shown_error_on_mesh(row))
            cells += f" {_cell(row.seconds_on_mesh, '10.1f')} {shown:>8}"
        found.append(cells + (f"  {row.status}: {row.run.message}" if row.status != "done" else ""))
    found.append("* on the front" + ("; + on the front of the scene's own mesh, errors on mesh" if motion else ""))
    return [*found, *_statistics_lines(findings, width), "", *sentences(findings)]


def _error(error: float, shown: float) -> str:
    if not math.isfinite(shown):
        return "-"
    return f"{shown:.1e}" if shown == error else f"<{shown:.1e}"


def _cell(value: float, form: str) -> str:
    width = int(form.partition(".")[0])
    return format(value, form) if math.isfinite(value) else "-".rjust(width)


def headline(findings: Findings) -> list[str]:
    """Scene, reference, what an error is, machine and versions."""
    told = dict(findings.conditions)
    machine = f"{told.pop('processor')}, {told.pop('cores')} cores, {told.pop('system')}"
    side_by_side = told.pop("side_by_side")
    versions = ", ".join(f"{name} {version}" for name, version in told.items())
    against = findings.against
    known = f", which is known to {against.known:.1e}" if against.known > 0.0 else ""
    on_mesh = ""
    if against.reference_on_mesh:
        on_mesh = f"; on mesh: {against.measure_on_mesh} against {against.reference_on_mesh}"
        on_mesh += f", known to {against.known_on_mesh:.1e}" if against.known_on_mesh > 0.0 else ""
    repeated = f"; the same twice: {findings.repeated:.0%} apart" if math.isfinite(findings.repeated) else ""
    imports = [row.run.imports for row in findings.rows if math.isfinite(row.run.imports)]
    started = f"; start of Python and imports, {median(imports):.1f} s, not counted" if imports else ""
    return [
        f"{findings.scene.name}: error = {against.measure}",
        f"against {against.reference}{known}{on_mesh}",
        f"{findings.clock} time; the runs had the processor for {findings.busy:.0%} of their wall time{started}",
        f"{machine}; {side_by_side} runs side by side, one thread each{repeated}",
        versions,
    ]


def _statistics_lines(findings: Findings, width: int) -> list[str]:
    rows = [row for row in in_order(findings) if row.statistics is not None]
    if not rows:
        return []
    found = [
        "",
        f"Whole runs; energies: deviation from {findings.against.statistics_of}",
        f"    {'setting':<{width}} {'seconds':>8} {'kinetic: mean':>13} {'max':>7} {'strain: mean':>12} {'max':>7} "
        f"{'gain':>8} {'loss':>8} {'contact ends':>12} {'penetration':>11}",
    ]
    for row in rows:
        off, own = row.deviations, row.statistics
        found.append(
            f"    {row.setting.label:<{width}} {row.run.summary['wall_seconds']:8.1f} {off['mean_kinetic']:+13.1%} "
            f"{off['max_kinetic']:+7.1%} {off['mean_strain']:+12.1%} {off['max_strain']:+7.1%} {own.energy_gain:8.1e} "
            f"{own.energy_loss:8.1e} {own.last_contact:10.4g} s {own.max_penetration:9.2e} m"
        )
    return found


def sentences(findings: Findings) -> list[str]:
    """The cheapest setting for errors of 1e-2, 1e-3, 1e-4."""
    found = []
    for target in TARGETS:
        row = findings.cheapest(target)
        found.append(_sentence(target, "", row, row and row.seconds, row and findings.shown_error(row)))
    if findings.against.reference_on_mesh:
        for target in TARGETS:
            row = findings.cheapest_on_mesh(target)
            numbers = row and row.seconds_on_mesh, row and findings.shown_error_on_mesh(row)
            found.append(_sentence(target, " on the scene's own mesh", row, *numbers))
    return found


def _sentence(target: float, where: str, row: Row | None, seconds: float | None, error: float | None) -> str:
    if row is None:
        return f"Errors below {target:.0e}{where}: no setting reached that."
    return (
        f"Errors below {target:.0e}{where}: {row.setting.label} is the cheapest, {seconds:.3g} s (error {error:.1e})."
    )
