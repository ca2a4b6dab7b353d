"""Figures 11 to 16 of the paper from the runs of the three models, and their penetration over time."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.patches import Rectangle

from warp_origami.model.submesh import Submesh

from .crossing import CrossingOracle
from .places import face_name
from .render import COLOUR_MAP, View, picture
from .runs import Result
from .watch import Watched

COLOURS = {"model1": "#d62728", "model2": "#e6a100", "model3": "#1f77b4"}
DASHES = {"model1": (0, (3, 1)), "model2": (0, (5, 1, 1, 1)), "model3": "solid"}
SHOWN = 1.0
"""s: when Fig. 11 is compared, for at the paper's 0.5 s nothing has met yet."""


def draw_all(results: Sequence[Result], watched: Sequence[Watched], folder: Path) -> None:
    """Writes paper_fig11.png to paper_fig16.png and paper_penetration.png."""
    folder.mkdir(exist_ok=True)
    figures = {
        "fig11": penetration_at(results, watched, SHOWN),
        "fig12": configurations(results, (0.0, 1.0, 1.5, 2.0, 3.0, 4.0)),
        "fig13": stress_maps(results, watched, (1.0, 4.0)),
        "fig14": energies(results),
        "fig15": stresses(results),
        "fig16": vibrations(results),
        "penetration": penetration(results, watched),
    }
    for name, figure in figures.items():
        figure.savefig(folder / f"paper_{name}.png", dpi=100)
        plt.close(figure)


def penetration_at(results: Sequence[Result], watched: Sequence[Watched], time: float) -> plt.Figure:
    """Fig. 11: the sheet at 0.5 s; the place where Model 1 is deepest at `time`, in space and cut across the arm."""
    first, at = results[0], [result.at(time) for result in results]
    submesh, interpolation = first.submesh(8)
    deepest = watched[0].crossings[at[0]][0]
    representative = np.argmin(np.linalg.norm(submesh.flat - deepest.flat, axis=1))
    place = (interpolation @ first.q[at[0]])[representative]
    diagonal = np.sign(place[:2]) / np.sqrt(2.0)
    azimuth = np.degrees(np.arctan2(diagonal[1], diagonal[0]))

    figure, axes = plt.subplots(2, 4, figsize=(14, 6.6), width_ratios=(1.15, 1, 1, 1), layout="constrained")
    drawn, to_drawn = first.submesh(4)
    whole = View(azimuth - 55.0, 35.0, np.array([0.0, 0.0, -0.02]), 0.68, (360, 280))
    close = View(azimuth + 60.0, 12.0, place, 0.2, (300, 230))
    last = results[-1]
    frame = last.surface.frame(0.5, last.q[last.at(0.5)])
    stress = frame.fields["von_mises"]
    axes[0, 0].imshow(picture(drawn, frame.points, stress, (0.0, np.quantile(stress, 0.99)), whole))
    axes[0, 0].set_title(f"(a) 0.5 s, {last.case.label}")
    x, y = whole.project(place[None])[0, :2] / 2.0
    half = 0.5 * close.width / whole.width * whole.pixels[0]
    axes[0, 0].add_patch(Rectangle((x - half, whole.pixels[1] - y - half), 2 * half, 2 * half, fill=False, color="k"))
    top = max(_stress(result, n).max() for result, n in zip(results, at, strict=True))
    for k, (result, watch, n) in enumerate(zip(results, watched, at, strict=True)):
        points, values = to_drawn @ result.q[n], _stress(result, n)
        crossed = CrossingOracle(drawn, points).crossed_triangles(points)
        axes[0, k + 1].imshow(picture(drawn, points, values, (0.0, 0.15 * top), close, crossed))
        axes[0, k + 1].set_title(f"({'bcd'[k]}) {result.times[n]:.2f} s, {result.case.label}", fontsize=10)
        _section(axes[1, k + 1], result, submesh, interpolation @ result.q[n], diagonal, place)
        depth = watch.depths[n]
        axes[1, k + 1].set_title(f"crosses, {1e3 * depth:.1f} mm deep" if watch.crosses[n] else "no crossing")
    for axis in axes[0]:
        axis.set_axis_off()
    axes[1, 1].set_ylabel("z, mm")
    _flat_section(axes[1, 0], first, submesh, interpolation @ first.q[at[0]], diagonal, place)
    handles, labels = axes[1, 1].get_legend_handles_labels()
    axes[1, 0].legend(handles, labels, fontsize=8, loc="lower left", title="faces", title_fontsize=8)
    return figure


def _stress(result: Result, n: int) -> np.ndarray:
    return result.surface.frame(result.times[n], result.q[n]).fields["von_mises"]


def cut(submesh: Submesh, points: np.ndarray, diagonal: np.ndarray, place: np.ndarray):
    """Segments (k, 2, 3) in which the plane across the arm through `place` cuts the sub-triangles, and their faces."""
    height = (points[:, :2] - place[:2]) @ diagonal
    corners, heights = points[submesh.triangles], height[submesh.triangles]
    above = heights > 0.0
    cut = above.any(axis=1) & ~above.all(axis=1)
    corners, heights, above = corners[cut], heights[cut], above[cut]
    lone = np.argmax(above == (above.sum(axis=1, keepdims=True) == 1), axis=1)
    row = np.arange(len(lone))
    ends = []
    for k in (1, 2):
        other = (lone + k) % 3
        share = heights[row, lone] / (heights[row, lone] - heights[row, other])
        ends.append(corners[row, lone] + share[:, None] * (corners[row, other] - corners[row, lone]))
    return np.stack(ends, axis=1), submesh.triangle_faces[cut]


def _section(axis, result: Result, submesh: Submesh, points, diagonal, place) -> None:
    """The layers of one arm, cut across."""
    segments, faces = cut(submesh, points, diagonal, place)
    across = np.array([-diagonal[1], diagonal[0], 0.0])
    lines = 1e3 * np.stack([segments @ across, segments[:, :, 2]], axis=-1)
    names = np.array([face_name(result.system.mesh, face) for face in range(faces.max() + 1)])[faces]
    for k, name in enumerate(sorted(set(names))):
        axis.add_collection(LineCollection(lines[names == name], colors=f"C{k}", linewidths=1.3, label=name))
    width = 12.0
    middle = float(place @ across) * 1e3
    axis.set(xlim=(middle - width, middle + width), ylim=(1e3 * place[2] - 45.0, 1e3 * place[2] + 45.0))
    axis.set_xlabel("across the arm, mm")
    axis.grid(alpha=0.3)


def _flat_section(axis, result: Result, submesh: Submesh, points, diagonal, place) -> None:
    """The whole of the section of the first model, in true proportion, with the part that is enlarged."""
    segments, _ = cut(submesh, points, diagonal, place)
    across = np.array([-diagonal[1], diagonal[0], 0.0])
    near = np.abs(segments @ across).max(axis=1) < 0.1
    lines = 1e3 * np.stack([segments[near] @ across, segments[near][:, :, 2]], axis=-1)
    axis.add_collection(LineCollection(lines, colors="0.3", linewidths=0.8))
    middle = float(place @ across) * 1e3
    axis.add_patch(Rectangle((middle - 12.0, 1e3 * place[2] - 45.0), 24.0, 90.0, fill=False, color="k"))
    axis.autoscale_view()
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel="across the arm, mm", ylabel="z, mm")
    axis.set_title(f"cut {1e3 * float(place[:2] @ diagonal):.0f} mm from the axis, {result.case.label}", fontsize=10)


def configurations(results: Sequence[Result], times: Sequence[float]) -> plt.Figure:
    """Fig. 12: shapes and von Mises stress; one scale of colours per time."""
    figure, axes = plt.subplots(len(results), len(times), figsize=(13.5, 5.0), layout="constrained")
    view = View(-62.0, 32.0, np.array([0.0, 0.0, -0.01]), 0.86, (280, 182))
    for column, time in enumerate(times):
        frames = [result.surface.frame(time, result.q[result.at(time)]) for result in results]
        top = max(np.quantile(frame.fields["von_mises"], 0.98) for frame in frames)
        for row, (result, frame) in enumerate(zip(results, frames, strict=True)):
            image = picture(result.surface.submesh, frame.points, frame.fields["von_mises"], (0.0, max(top, 1.0)), view)
            axes[row, column].imshow(image)
            axes[row, column].set(xticks=[], yticks=[], frame_on=False)
        scale = f"0 to {1e-6 * top:.2g} MPa" if top > 1.0 else "no stress"
        axes[0, column].set_title(f"{time:g} s\n{scale}", fontsize=10)
    for row, result in enumerate(results):
        axes[row, 0].set_ylabel(result.case.label.replace(": ", "\n"), color=COLOURS[result.case.name], fontsize=9)
    figure.colorbar(
        plt.cm.ScalarMappable(Normalize(0.0, 1.0), COLOUR_MAP),
        ax=axes,
        shrink=0.7,
        label="von Mises / largest of its scale",
    )
    return figure


def stress_maps(results: Sequence[Result], watched: Sequence[Watched], times: Sequence[float]) -> plt.Figure:
    """Fig. 13: von Mises stress on the flat sheet, with the points that touch in the tenth of a second around."""
    figure, axes = plt.subplots(
        len(times), len(results), figsize=(11.5, 7.4), layout="constrained", sharex=True, sharey=True
    )
    for row, time in enumerate(times):
        fields = [_stress(result, result.at(time)) for result in results]
        top = max(np.quantile(field, 0.99) for field in fields)
        for axis, result, watch, field in zip(axes[row], results, watched, fields, strict=True):
            sub = result.surface.submesh
            shown = axis.tricontourf(
                *(1e3 * sub.flat.T),
                sub.triangles,
                1e-6 * field,
                np.linspace(0.0, 1e-6 * top, 21),
                cmap=COLOUR_MAP,
                extend="max",
            )
            mesh = result.system.mesh
            axis.add_collection(LineCollection(1e3 * mesh.vertices[mesh.edges], colors="w", linewidths=0.4, alpha=0.6))
            around = np.flatnonzero(np.abs(watch.times - time) <= 0.05)
            flat = [watch.touches[n].flat.reshape(-1, 2) for n in around if len(watch.touches[n].forces)]
            if flat:
                points = 1e3 * np.concatenate(flat)
                axis.plot(*points.T, "o", markersize=5, markerfacecolor="none", markeredgecolor="w")
            axis.set_aspect("equal")
            axis.set_title(f"{result.case.label}, {time:g} s", color=COLOURS[result.case.name], fontsize=11)
        figure.colorbar(shown, ax=axes[row], label="von Mises, MPa", format="%.2f")
        axes[row, 0].set_ylabel("y of the flat sheet, mm")
    for axis in axes[-1]:
        axis.set_xlabel("x of the flat sheet, mm")
    return figure


def energies(results: Sequence[Result]) -> plt.Figure:
    """Fig. 14: strain and kinetic energy to 2.4 s; the strain energy of the first peak enlarged."""
    figure, axes = plt.subplots(1, 3, figsize=(14, 4.2), layout="constrained")
    panels = (
        ("strain_energy", "strain energy, mJ", (0.0, 2.4)),
        ("strain_energy", "strain energy, mJ", (0.0, 1.5)),
        ("kinetic_energy", "kinetic energy, mJ", (0.0, 2.4)),
    )
    for axis, (column, label, span) in zip(axes, panels, strict=True):
        for result in results:
            time, value = result.history["time"], 1e3 * result.history[column]
            shown = time <= span[1]
            _line(axis, result, time[shown], value[shown])
        axis.set(xlabel="time, s", ylabel=label, xlim=span)
        axis.set_ylim(bottom=0.0)
    axes[1].set_ylim(0.0, 0.08)
    axes[1].set_title("first peak and valley, enlarged", fontsize=10)
    for axis in axes[:2]:
        _events(axis, (1.2, 1.4, 2.0))
    axes[2].legend(fontsize=9, loc="upper left")
    return figure


def stresses(results: Sequence[Result]) -> plt.Figure:
    """Fig. 15: von Mises stress at E and F, on a linear scale and, enlarged, before the fast part."""
    figure, axes = plt.subplots(2, 2, figsize=(13, 7.2), layout="constrained")
    for column, name in enumerate("EF"):
        for row, (until, top) in enumerate(((2.4, None), (1.6, 1.2))):
            axis = axes[row, column]
            for result in results:
                time = result.history["time"]
                shown = time <= until
                _line(axis, result, time[shown], 1e-6 * result.probes[name]["von_mises"][shown])
            axis.set(xlabel="time, s", ylabel=f"von Mises at {name}, MPa", xlim=(0.0, until))
            axis.set_ylim(0.0, top)
        _events(axes[0, column], (1.0, 2.0))
        _events(axes[1, column], (1.0, 1.4))
    axes[0, 0].legend(fontsize=9, loc="upper left")
    return figure


def vibrations(results: Sequence[Result]) -> plt.Figure:
    """Fig. 16: height and vertical velocity of A to D, Model 3; the velocity of A in all models."""
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.4), layout="constrained")
    last = results[-1]
    time = last.history["time"]
    for name, shade in zip("ABCD", ("#08306b", "#2171b5", "#6baed6", "#969696"), strict=True):
        axes[0].plot(time, 1e3 * last.probes[name]["z"], color=shade, label=name)
        axes[1].plot(time, last.probes[name]["vz"], color=shade, label=name, linewidth=1.0)
    for result in results:
        _line(axes[2], result, result.history["time"], result.probes["A"]["vz"], linewidth=1.0)
    axes[0].set(ylabel="z, mm", title=last.case.label)
    axes[1].set(ylabel="vertical velocity, m/s", title=last.case.label)
    axes[2].set(ylabel="vertical velocity of A, m/s", title="centre in all models")
    for axis in axes:
        axis.set(xlabel="time, s", xlim=(0.0, 4.0))
        axis.grid(alpha=0.3)
        axis.legend(fontsize=9, loc="lower right")
    axes[2].set_ylim(bottom=-1.3)  # room for the legend
    for axis in axes[1:]:
        _events(axis, (2.0, 2.7))
    return figure


def penetration(results: Sequence[Result], watched: Sequence[Watched]) -> plt.Figure:
    """Depth below the contact thickness with the eyes of the mixed method, and crossing of mid-surfaces."""
    figure, axis = plt.subplots(figsize=(9, 4.4), layout="constrained")
    for result, watch in zip(results, watched, strict=True):
        time, depth = watch.times, 1e3 * watch.penetration
        _line(axis, result, time, np.where(depth > 1e-6, depth, np.nan), marker=".", markersize=4)
    crossing = watched[0]
    axis.plot(
        crossing.times[crossing.crosses],
        1e3 * np.maximum(crossing.depths[crossing.crosses], 1e-5),
        "x",
        color=COLOURS["model1"],
        markersize=4,
        label="Model 1: mid-surface beyond mid-surface",
    )
    axis.axhline(0.5, color="0.4", linewidth=0.8)
    axis.text(0.02, 0.55, "thickness", color="0.4", fontsize=8)
    axis.set(xlabel="time, s", ylabel="deepest penetration, mm", xlim=(0.0, 2.2), yscale="log", ylim=(1e-6, 50.0))
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8, loc="lower left")
    return figure


def _line(axis, result: Result, time, value, **options) -> None:
    name = result.case.name
    axis.plot(
        time,
        value,
        color=COLOURS[name],
        linestyle=DASHES[name],
        label=result.case.label,
        **{"linewidth": 1.3} | options,
    )
    axis.grid(alpha=0.3)


def _events(axis, times: Sequence[float]) -> None:
    """Marks times that the paper names."""
    for time in times:
        axis.axvline(time, color="0.5", linewidth=0.8, linestyle=":")
