"""Which columns of the tables of a run are plotted together, and under which names."""

from dataclasses import asdict, dataclass, replace

import numpy as np

from .run_files import RunFiles, Table

MOST_ROWS = 20_000
"""Rows of a table in the page."""


@dataclass(frozen=True)
class Curve:
    """A column of a table.

    Attributes:
        label: in the legend.
        column: number of the column.
    """

    label: str
    column: int


@dataclass(frozen=True)
class Chart:
    """Curves over time in one diagram.

    Attributes:
        table: the table of their columns.
        section: where in the page: run, probes or reactions.
        group: name of the probe, support or driver; "" in section run.
        title, unit: what is plotted; the unit takes SI prefixes. "%" for shares, "" for numbers.
        curves: at least one.
        logarithmic: vertical axis.
        stairs: values hold over the step that ends there.
        note: what is left out.
    """

    table: str
    section: str
    group: str
    title: str
    unit: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False
    stairs: bool = False
    note: str = ""


@dataclass(frozen=True)
class _Plan:
    title: str
    unit: str
    columns: dict[str, str]
    logarithmic: bool = False
    stairs: bool = False


RUN = (
    _Plan(
        "Energies",
        "J",
        {
            "kinetic_energy": "kinetic",
            "strain_energy": "strain",
            "contact_energy": "contact",
            "dissipated": "dissipated",
            "external_work": "external work",
        },
    ),
    _Plan("Energy balance: created (+) or lost (−)", "J", {"energy_error": "energy error"}),
    _Plan("Step", "s", {"step": "step"}, logarithmic=True, stairs=True),
    _Plan("Newton iterations per step", "", {"newton_iterations": "iterations"}, stairs=True),
    _Plan("Largest penetration", "m", {"max_penetration": "penetration"}),
    _Plan(
        "Contacts",
        "",
        {"contacts_sts": "surface to surface", "contacts_nts": "node to surface", "contacts_edge": "edge to edge"},
    ),
    _Plan("Share of the area", "%", {"taut": "taut", "wrinkled": "wrinkled", "slack": "slack"}),
)
SPIN = (
    _Plan("Rate of spin", "rad/s", {"rate": "rate"}),
    _Plan("Moment of inertia about the axis", "kg m²", {"moment_of_inertia": "moment of inertia"}),
    _Plan(
        "Angular momentum",
        "N m s",
        {"angular_momentum.x": "x", "angular_momentum.y": "y", "angular_momentum.z": "z"},
    ),
)
PROBE = (
    _Plan("Position", "m", {"x": "x", "y": "y", "z": "z"}),
    _Plan("Velocity", "m/s", {"vx": "x", "vy": "y", "vz": "z"}),
    _Plan("Stress", "Pa", {"von_mises": "von Mises", "s1": "S1", "s2": "S2"}),
)
REACTION = (
    _Plan("Force on the sheet", "N", {"fx": "x", "fy": "y", "fz": "z"}),
    _Plan("Moment about the origin", "N m", {"mx": "x", "my": "y", "mz": "z"}),
)


def charts(files: RunFiles) -> list[Chart]:
    """All diagrams of a run; columns that this module does not know get one each, further energies join the others."""
    found = []
    history = files.tables.get("history")
    if history is not None and len(history):
        for plan in _plans(history):
            found += _chart(plan, history, "history", "run", "")
    spin = files.tables.get("spin")
    if spin is not None and len(spin):
        for plan in SPIN:
            found += _chart(plan, spin, "spin", "run", "")
    for name, plans in (("probes", PROBE), ("reactions", REACTION)):
        table = files.tables.get(name)
        for group in groups(table) if table is not None and len(table) else ():
            for plan in plans:
                found += _chart(plan, table, name, name, group)
    return [_named(chart, files.kind) for chart in found]


def _plans(history: Table) -> list[_Plan]:
    known = {"time"}.union(*(plan.columns for plan in RUN))
    new = [name for name in history.columns if name not in known]
    energies, *others = RUN
    more = {name: name.removesuffix("_energy") for name in new if name.endswith("_energy")}
    single = [_Plan(name.replace("_", " "), "", {name: name}) for name in new if name not in more]
    return [replace(energies, columns=energies.columns | more), *others, *single]


def groups(table: Table) -> list[str]:
    """Names before the dot in the headings, in their order."""
    return list(dict.fromkeys(column.rpartition(".")[0] for column in table.columns[1:]))


def _chart(plan: _Plan, table: Table, name: str, section: str, group: str) -> list[Chart]:
    """The chart of a plan, or none if the table has nothing of it but zeros where that says nothing."""
    prefix = f"{group}." if group else ""
    numbers = {column: k for k, column in enumerate(table.columns)}
    there = [(label, numbers[prefix + column]) for column, label in plan.columns.items() if prefix + column in numbers]
    moving = [Curve(label, k) for label, k in there if np.any(table.values[:, k] != 0.0)]
    zero = [label for label, k in there if not np.any(table.values[:, k] != 0.0)]
    if not there or (not moving and section == "run"):
        return []
    note = f"zero throughout: {', '.join(zero)}" if moving and zero else ""
    curves = tuple(moving) or tuple(Curve(label, k) for label, k in there)
    return [Chart(name, section, group, plan.title, plan.unit, curves, plan.logarithmic, plan.stairs, note)]


def _named(chart: Chart, kind: str) -> Chart:
    """In statics the step is one of the load factor, without a unit."""
    if kind == "dynamic" or chart.title != "Step":
        return chart
    return replace(chart, title="Step of the load factor", unit="")


def as_dictionaries(found: list[Chart]) -> list[dict]:
    """For the page."""
    return [asdict(chart) for chart in found]


def thinned(table: Table, most: int = MOST_ROWS) -> Table:
    """At most `most` rows, so that no peak is lost: of each run of rows every column keeps its least and largest."""
    if len(table) <= most:
        return table
    bounds = np.linspace(0, len(table), most // 2 + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(table.values, bounds), np.maximum.reduceat(table.values, bounds)
    falling = table.values[bounds] > table.values[np.append(bounds[1:], len(table)) - 1]
    first, second = np.where(falling, high, low), np.where(falling, low, high)
    return Table(table.columns, np.stack([first, second], axis=1).reshape(-1, len(table.columns)))
