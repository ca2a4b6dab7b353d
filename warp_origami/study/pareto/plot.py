"""The plot of a study: wall seconds and memory against error, the fronts drawn, settings named."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from warp_origami.output.files import replacing

from .findings import RESOLVED, Findings, Row
from .table import headline

matplotlib.use("agg")
import matplotlib.pyplot as plt

MARKERS = "osD^v<>PXp*hH8d"
PLACES = [(side * 6, height) for height in (4, -10, 14, -20, 24, -30, 34, -40, 44, -50) for side in (1, -1)]
"""Offsets of a name from its point, in points; those to the left are written towards the left."""

WIDE = 3.0
"""Ratio of largest to smallest cost from which on its axis is logarithmic."""


@dataclass(frozen=True)
class Panel:
    """Axes: labels, what of a row is shown, and the error down to which the reference is known."""

    x_label: str
    y_label: str
    cost: Callable[[Row], float]
    error: Callable[[Row], float]
    front: Callable[[Row], bool]
    known: float


def _panels(findings: Findings) -> list[Panel]:
    def mebibytes(row: Row) -> float:
        return row.memory / 2**20

    shown = findings.shown_error
    time = f"{findings.clock} time, s"
    known = findings.against.known
    panels = [Panel(time, "error", lambda row: row.seconds, shown, lambda row: row.front, known)]
    if findings.against.reference_on_mesh:
        label, known_on_mesh = "error against the finest run on the scene's own mesh", findings.against.known_on_mesh
        time += f", {findings.against.measure_on_mesh}"
        on_mesh = findings.shown_error_on_mesh
        panels.append(
            Panel(time, label, lambda row: row.seconds_on_mesh, on_mesh, lambda row: row.front_on_mesh, known_on_mesh)
        )
    panels.append(Panel("peak memory, MiB", "error", mebibytes, shown, lambda row: row.front_of_memory, known))
    return panels


def draw(findings: Findings, path: Path) -> None:
    """Writes the plot as PNG."""
    panels = _panels(findings)
    drawn = [row.setting.varied for panel in panels for row in _drawn(findings.rows, panel)]
    kinds = sorted(set(drawn), key=lambda kind: (" and " in kind, kind))
    figure, axes = plt.subplots(1, len(panels), figsize=(7.0 * len(panels), 7.0), layout="constrained", squeeze=False)
    for one, panel in zip(axes[0], panels, strict=True):
        _show(one, findings.rows, kinds, panel)
        if panel.known > RESOLVED:
            low = one.get_ylim()[0]
            one.axhspan(low, max(low, panel.known), color="0.9", zorder=0, label="reference not known better")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3 * len(panels), fontsize="small")
    figure.suptitle("\n".join(headline(findings)), fontsize="small")
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # names are placed where the points now are
    for one, panel in zip(axes[0], panels, strict=True):
        _name(one, findings.rows, panel)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=100)
    plt.close(figure)


def _drawn(rows: Sequence[Row], panel: Panel) -> list[Row]:
    return [row for row in rows if math.isfinite(panel.cost(row)) and math.isfinite(panel.error(row))]


def _show(axes, rows: Sequence[Row], kinds: Sequence[str], panel: Panel) -> None:
    cost, error, shown = panel.cost, panel.error, _drawn(rows, panel)
    for k, kind in enumerate(kinds):
        ones = [row for row in shown if row.setting.varied == kind]
        label = "the scene's own settings" if kind == "none" else f"{kind} varied"
        places = [cost(row) for row in ones], [error(row) for row in ones]
        size = 10 if kind == "none" else 6
        axes.plot(*places, MARKERS[k % len(MARKERS)], color=f"C{k % 10}", label=label, markersize=size, zorder=3)
    best = sorted((row for row in shown if panel.front(row)), key=cost)
    axes.step([cost(row) for row in best], [error(row) for row in best], "k-", where="post", lw=1, label="front")
    axes.set(yscale="log", xlabel=panel.x_label, ylabel=panel.y_label)
    if shown:
        errors, costs = [error(row) for row in shown], [cost(row) for row in shown]
        axes.set_ylim(0.3 * min(errors), 3.0 * max(errors))
        low, high = min(costs), max(costs)
        if high > WIDE * low:
            axes.set(xscale="log", xlim=(0.7 * low, 1.8 * high))
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        else:
            axes.set_xlim(low - 0.2 * (high - low) - 0.02 * low, high + 0.3 * (high - low) + 0.02 * high)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(alpha=0.3, which="both")


def _name(axes, rows: Sequence[Row], panel: Panel) -> None:
    """Writes the names beside the points where they cover nothing: first, in bold, those on the front."""
    renderer = axes.figure.canvas.get_renderer()
    shown = sorted(_drawn(rows, panel), key=lambda row: not panel.front(row))
    taken = []
    for row in shown:
        x, y = axes.transData.transform((panel.cost(row), panel.error(row)))
        taken.append((x - 5, y - 5, x + 5, y + 5))
    for row in shown:
        for dx, dy in PLACES:
            text = axes.annotate(
                row.setting.label,
                (panel.cost(row), panel.error(row)),
                xytext=(dx, dy),
                textcoords="offset points",
                ha="left" if dx > 0 else "right",
                fontsize=8 if panel.front(row) else 6.5,
                fontweight="bold" if panel.front(row) else "normal",
                color="black" if panel.front(row) else "0.35",
            )
            box = text.get_window_extent(renderer)
            area, frame = (box.x0, box.y0, box.x1, box.y1), axes.bbox
            inside = frame.x0 < box.x0 and box.x1 < frame.x1 and frame.y0 < box.y0 and box.y1 < frame.y1
            if inside and not any(_overlap(area, other) for other in taken):
                taken.append(area)
                break
            text.remove()


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
