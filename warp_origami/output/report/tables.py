"""The tables of the page as HTML: settings, results, machine. They can be read without any script."""

import html
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from .run_files import RunFiles, Table

MOST_VALUES = 100
"""Of a list, in the table of settings; scene.toml has them all."""


@dataclass(frozen=True)
class Setting:
    """A value of the scene.

    Attributes:
        table: its table in the scene file, "" at the top.
        key: its name there.
        value: as it stands in the file.
        meaning: what it is, with the unit; "" if not known.
        default: whether it is what stands there unless given.
    """

    table: str
    key: str
    value: str
    meaning: str
    default: bool


def settings(files: RunFiles) -> list[Setting]:
    """Every value of the scene, defaults filled in."""
    if files.scene is not None:
        return list(_of_model("", files.scene))
    return list(_of_tables("", files.settings))


def _of_model(place: str, model: BaseModel) -> Iterable[Setting]:
    inner = []
    for key, field in type(model).model_fields.items():
        value = getattr(model, key)
        path = f"{place}.{key}" if place else key
        if isinstance(value, BaseModel):
            inner.append((path, value))
        elif isinstance(value, tuple) and value and isinstance(value[0], BaseModel):
            inner += [(f"{path}.{i}", item) for i, item in enumerate(value)]
        elif value is not None and value != ():
            default = field.get_default(call_default_factory=True)
            same = default is not PydanticUndefined and value == default
            yield Setting(place, key, _text(value), field.description or "", same)
    for path, value in inner:
        yield from _of_model(path, value)


def _of_tables(place: str, table: Mapping) -> Iterable[Setting]:
    inner = []
    for key, value in table.items():
        path = f"{place}.{key}" if place else key
        if isinstance(value, Mapping):
            inner.append((path, value))
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            inner += [(f"{path}.{i}", item) for i, item in enumerate(value)]
        else:
            yield Setting(place, key, _text(value), "", False)
    for path, value in inner:
        yield from _of_tables(path, value)


def _text(value: object) -> str:
    if isinstance(value, float):
        plain = value == 0.0 or 1e-3 <= abs(value) < 1e5
        return f"{value:.10g}" if plain else np.format_float_scientific(value, trim="-", exp_digits=1).replace("+", "")
    if isinstance(value, list | tuple):
        shown = ", ".join(map(_text, value[:MOST_VALUES]))
        return f"[{shown}]" if len(value) <= MOST_VALUES else f"[{shown}, … {len(value)} in all]"
    return value if isinstance(value, str) else json.dumps(value, default=str)


def settings_html(rows: Iterable[Setting]) -> str:
    """Table of the settings, a heading for every table of the scene file."""
    parts, place = [], None
    for row in rows:
        if row.table != place:
            place = row.table
            name = f"[{place}]" if place else "scene"
            parts.append(f'<tr class="group"><th colspan="3" scope="rowgroup">{html.escape(name)}</th></tr>')
        kind = ' class="default"' if row.default else ""
        cells = f'<th scope="row">{html.escape(row.key)}</th><td class="value">{html.escape(row.value)}</td>'
        parts.append(f"<tr{kind}>{cells}<td>{html.escape(row.meaning)}</td></tr>")
    head = '<thead><tr><th scope="col">key</th><th scope="col">value</th><th scope="col">meaning</th></tr></thead>'
    return f'<table class="settings">{head}<tbody>{"".join(parts)}</tbody></table>'


RESULTS = {
    "elements": ("Elements", ""),
    "dofs": ("Degrees of freedom", ""),
    "steps_accepted": ("Steps", ""),
    "steps_rejected": ("Rejected steps", ""),
    "newton_iterations": ("Newton iterations", ""),
    "linear_solves": ("Linear solves", ""),
    "max_penetration": ("Largest penetration", "m"),
    "energy_gain": ("Energy created", "%"),
    "energy_loss": ("Energy lost", "%"),
    "mass": ("Mass", "kg"),
    "angular_momentum_initial": ("Angular momentum (x, y, z), start", "N m s"),
    "angular_momentum": ("Angular momentum (x, y, z), end", "N m s"),
    "angular_momentum_change": ("Its change about the axis", "% of initial"),
    "wall_seconds": ("Wall time", "s"),
    "peak_memory_bytes": ("Peak memory", "bytes"),
}
MODEL = {
    "terms": ("Modelled", ""),
    "constraints": ("Constraint equations", ""),
    "constraint_form": ("Constraints", ""),
    "linear_solver": ("Linear solver", ""),
    "sts_stiffness": ("Contact stiffness, surface to surface", "N/m³"),
    "nts_stiffness": ("Contact stiffness, node to surface", "N/m"),
    "expected_speed": ("Speed the contact is made for", "m/s"),
    "device": ("Device", ""),
    "precision": ("Precision", ""),
}
ELSEWHERE = {"status", "scene", "message", "advice", "phases", "frequencies", "kernel_modules"}


SHARES = {"%": "largest energy at one time", "% of initial": "first value"}
"""What shares are of."""


@dataclass(frozen=True)
class EnergyPutIn:
    """Energies of a run, J.

    Attributes:
        supplied: stored at the start, and the largest net work of loads and drivers since.
        lost: largest fall of the energy balance below zero.
    """

    supplied: float
    lost: float


def energy_put_in(history: Table | None) -> EnergyPutIn | None:
    """What was put into the sheet and lost, from history.csv; None if its columns do not tell.

    Stored and dissipated energy are not negative, so `lost` is at most `supplied`.
    """
    needed = ("kinetic_energy", "strain_energy", "contact_energy", "external_work", "energy_error")
    if history is None or not len(history) or not set(needed) <= set(history.columns):
        return None
    *stored, work, error = (history.values[:, history.columns.index(name)] for name in needed)
    return EnergyPutIn(float(sum(stored)[0] + max(work.max(), 0.0)), float(max(-error.min(), 0.0)))


def result_rows(summary: Mapping, energy: EnergyPutIn | None = None) -> list[tuple[str, str]]:
    """Label and value of the numbers of a run; those that are not known here under their own names."""
    others = summary.keys() - RESULTS.keys() - MODEL.keys() - ELSEWHERE
    rows = _rows(summary, RESULTS | {key: (key, "") for key in summary if key in others})
    if energy is None or not energy.supplied > 0.0:
        return rows
    share = f"{100.0 * energy.lost / energy.supplied:.3g} % of the energy put in"
    return [(label, f"{text}, {share}" if label == RESULTS["energy_loss"][0] else text) for label, text in rows]


def model_rows(summary: Mapping) -> list[tuple[str, str]]:
    """Label and value of what was modelled and how it was solved."""
    return _rows(summary, MODEL)


def _rows(summary: Mapping, labels: Mapping[str, tuple[str, str]]) -> list[tuple[str, str]]:
    rows = [(label, _quantity(summary[key], unit)) for key, (label, unit) in labels.items() if key in summary]
    return [row for row in rows if row[1]]


def _quantity(value: object, unit: str) -> str:
    if isinstance(value, list) and value and all(isinstance(entry, float) for entry in value):
        noise = 1e-12 * max(map(abs, value))  # beside the largest component
        return f"({', '.join(f'{entry if abs(entry) > noise else 0.0:.4g}' for entry in value)}) {unit}".rstrip()
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ", ".join(map(str, value)) if isinstance(value, list) else "" if value is None else str(value)
    if unit == "bytes":
        return f"{value / 1e6:.0f} MB"
    if unit in SHARES:
        return f"{100.0 * value:.3g} % of the {SHARES[unit]}"
    if isinstance(value, int):
        return f"{value:,} {unit}".replace(",", " ").rstrip()
    if unit == "m" and 0.0 < value < 0.1:
        value, unit = (1e3 * value, "mm") if value >= 1e-3 else (1e6 * value, "µm")
    return f"{value:.4g} {unit}".replace("e+0", "e").replace("e+", "e").rstrip()


def pairs_html(rows: Iterable[tuple[str, str]]) -> str:
    """Table of two columns."""
    body = "".join(
        f'<tr><th scope="row">{html.escape(label)}</th><td class="value">{html.escape(text)}</td></tr>'
        for label, text in rows
    )
    return f'<table class="pairs"><tbody>{body}</tbody></table>'


def phases_html(summary: Mapping) -> str:
    """Wall time by phase as a bar, with the numbers below; empty if they are not known."""
    phases = summary.get("phases")
    if not isinstance(phases, Mapping):
        return ""
    spent = {name: value for name, value in phases.items() if isinstance(value, int | float) and value > 0.0}
    total = sum(spent.values())
    if not total:
        return ""
    parts, labels = [], []
    for k, (name, seconds) in enumerate(sorted(spent.items(), key=lambda item: -item[1])):
        share = 100.0 * seconds / total
        parts.append(f'<span class="phase c{k % 8}" style="width:{share:.3f}%"></span>')
        text = f"{html.escape(str(name))} {seconds:.3g} s"
        labels.append(f'<li><i class="c{k % 8}"></i>{text}</li>')
    heading = "<h3>Wall time by phase</h3>"
    return (
        f'{heading}<div class="phases" aria-hidden="true">{"".join(parts)}</div><ul class="keys">{"".join(labels)}</ul>'
    )


MACHINE = {
    "processor": "Processor",
    "cores": "Cores",
    "system": "System",
    "python": "Python",
    "sources": "Digest of the sources",
}


def machine_rows(files: RunFiles) -> list[tuple[str, str]]:
    """What the run ran on, as its animation says."""
    told = files.animation.machine if files.animation is not None else {}
    order = [key for key in MACHINE if key in told] + [key for key in told if key not in MACHINE]
    return [(MACHINE.get(key, key), str(told[key])) for key in order]
