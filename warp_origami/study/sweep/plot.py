"""sweep.png: what a study has found against each of its parameters."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from warp_origami.output.files import replacing

from .document import SUMMARY_COLUMNS, Parameter, Study
from .outcome import DONE
from .table import Row, shown

matplotlib.use("agg")
import matplotlib.pyplot as plt  # after the choice of a backend that needs no display

MOST_PARAMETERS = 6
"""Columns of panels."""

SERIES = 6
"""Values of a second parameter up to which it has lines of its own."""

RATIO = 50.0
"""Of the largest to the smallest given value, from which on the axis is logarithmic."""


def draw(path: Path, study: Study, rows: Sequence[Row]) -> None:
    """Writes the figure as PNG."""
    drawn = figure(study, rows)
    with replacing(path) as temporary:
        drawn.savefig(temporary, dpi=130)
    plt.close(drawn)


def figure(study: Study, rows: Sequence[Row]) -> Figure:
    """A row of panels for each quantity; runs that are not done are marked at the lower edge."""
    names = list(study.plot.of or [result.name for result in study.result][:6] or _interesting(rows))
    parameters = study.parameter[:MOST_PARAMETERS]
    drawn, panels = plt.subplots(
        len(names), len(parameters), squeeze=False, figsize=(1.0 + 3.6 * len(parameters), 0.9 + 2.8 * len(names))
    )
    for line, name in zip(panels, names, strict=True):
        for k, axes in enumerate(line):
            _panel(axes, study, rows, name, k)
    done = sum(row.outcome.status == DONE for row in rows)
    drawn.suptitle(f"{study.name}: {done} of {len(rows)} runs done", fontsize=10)
    drawn.tight_layout()
    return drawn


def _interesting(rows: Sequence[Row]) -> list[str]:
    """What is drawn where the study names nothing: the lowest frequency, else what the runs have cost and lost."""
    if any("frequencies.0" in row.numbers for row in rows):
        return ["frequencies.0"]
    return [name for name in SUMMARY_COLUMNS if name in ("newton_iterations", "energy_loss")]


def _panel(axes, study: Study, rows: Sequence[Row], name: str, k: int) -> None:
    parameter = study.parameter[k]
    place = _places(parameter, [row.run.values[k] for row in rows])
    for label, members in _series(study, rows, k).items():
        points = [(place(row.run.values[k]), row.numbers.get(name)) for row in members]
        points = sorted((x, y) for x, y in points if y is not None)
        if not points:
            continue
        style = "o-" if study.sampling.kind != "latin_hypercube" and _is_line(study, points) else "o"
        axes.plot([x for x, _ in points], [y for _, y in points], style, ms=4, lw=1, label=label)
    lost = [place(row.run.values[k]) for row in rows if row.outcome.status != DONE]
    if lost:
        edge = axes.get_xaxis_transform()
        axes.plot(lost, np.full(len(lost), 0.02), "x", color="tab:red", ms=6, transform=edge, label="not done")
    _axis(axes, parameter, [row.run.values[k] for row in rows])
    if study.plot.log and any((row.numbers.get(name) or 0.0) > 0.0 for row in rows):
        axes.set_yscale("log")
    axes.set_xlabel(parameter.key, fontsize=9)
    axes.set_ylabel(name, fontsize=9)
    axes.tick_params(labelsize=8)
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_offset_text().set_fontsize(8)
    axes.grid(alpha=0.3)
    if lost or (axes.get_legend_handles_labels()[1] and len(axes.lines) > 1):
        axes.legend(fontsize=7)


def _is_line(study: Study, points: Sequence[tuple[float, float]]) -> bool:
    """Whether points are to be joined: each place has one value."""
    return len(study.parameter) <= 2 and len({x for x, _ in points}) == len(points)


def _series(study: Study, rows: Sequence[Row], k: int) -> dict[str | None, list[Row]]:
    """Rows by the value of the other parameter, where there is one other with few values; else all together."""
    others = [j for j in range(len(study.parameter)) if j != k]
    if study.sampling.kind == "grid" and len(others) == 1:
        key, found = study.parameter[others[0]].key.rpartition(".")[2], {}
        for row in rows:
            value = row.run.values[others[0]]
            text = f"{value:.4g}" if isinstance(value, float) else shown(value)
            found.setdefault(f"{key} = {text}", []).append(row)
        if len(found) <= SERIES:
            return found
    return {None: list(rows)}


def _is_numeric(values: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)


def _places(parameter: Parameter, values: Sequence[Any]):
    """Where a value lies on the axis: numbers where they are, others in their order."""
    if _is_numeric(values):
        return float
    order = list(dict.fromkeys(map(shown, values)))
    return lambda value: float(order.index(shown(value)))


def _axis(axes, parameter: Parameter, values: Sequence[Any]) -> None:
    if not _is_numeric(values):
        order = list(dict.fromkeys(map(shown, values)))
        axes.set_xticks(range(len(order)), [text if len(text) <= 20 else text[:17] + "..." for text in order])
        axes.set_xlim(-0.5, len(order) - 0.5)
        return
    low, high = min(values), max(values)
    wide = parameter.values is not None and low > 0.0 and high > RATIO * low
    if parameter.scale == "log" or wide:
        axes.set_xscale("log")
        return
    whole = all(isinstance(value, int) for value in values)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10], integer=whole))
    # a power of ten at the end of the axis in place of zeros in every label
    axes.ticklabel_format(axis="x", style="sci", scilimits=(-2, 4), useMathText=True)
