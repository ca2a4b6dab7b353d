"""Rows of the comparison, as a table on the screen, as CSV and as a plot of error against seconds."""

import csv
from pathlib import Path

import numpy as np
from sheet import position_error, sag_error

COLUMNS = (
    "scene", "program", "version", "settings", "status", "steps", "setup_seconds", "loop_seconds", "cpu_seconds",
    "total_seconds", "position_error_mm", "sag_error_mm", "energy_drift_percent", "peak_strain",
)  # fmt: skip


def row(case, answer: dict, reference: np.ndarray) -> dict:
    """COLUMNS of one run."""
    done = answer["status"] == "done"
    values = {key: answer.get(key) for key in COLUMNS}
    values.update(scene=case.job["scene"], program=case.program, settings=case.settings)
    if done and case.job["scene"] == "swinging":
        values["position_error_mm"] = 1e3 * position_error(answer["positions"], reference)
    if done and case.job["scene"] == "sagging":
        values["sag_error_mm"] = 1e3 * sag_error(answer["sags"])
    if done:
        values["energy_drift_percent"] = 1e2 * answer["energy_drift"]
        values["total_seconds"] = answer.get("total_seconds", answer["setup_seconds"] + answer["loop_seconds"])
    return values


def line(values: dict) -> str:
    """One row for the screen."""
    start = f"{values['scene']:9} {values['program']:13} {values['settings']:34}"
    if values["status"] != "done":
        return f"{start} {values['status']}"
    error = values["position_error_mm"] if values["scene"] == "swinging" else values["sag_error_mm"]
    return (
        f"{start} loop {values['loop_seconds']:8.2f} s  cpu {values['cpu_seconds']:8.2f} s  error {error:8.3f} mm  "
        f"drift {values['energy_drift_percent']:9.4f} %  peak strain {values['peak_strain']:.2e}"
    )


def write(rows: list[dict], path: Path) -> None:
    """Writes the rows as CSV."""
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for values in rows:
            writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in values.items()})


def plot(rows: list[dict], path: Path) -> None:
    """Error against seconds of the loop, one panel a scene; squares are n x n cells, triangles strips n x 1."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    labels = {"swinging": "position error at 0.4 s (mm)", "sagging": "error of mean sag (mm)"}
    scenes = [scene for scene in labels if any(r["scene"] == scene and r["status"] == "done" for r in rows)]
    if not scenes:
        return
    figure, panels = plt.subplots(1, len(scenes), figsize=(5.5 * len(scenes), 4.8), layout="constrained", squeeze=False)
    for panel, scene in zip(panels[0], scenes, strict=True):
        for colour, program in enumerate(("MuJoCo", "Exudyn", "Newton", "warp_origami")):
            panel.plot([], [], "o", color=f"C{colour}", label=program)
            for r in rows:
                if (r["scene"], r["program"], r["status"]) != (scene, program, "done"):
                    continue
                error = r["position_error_mm"] if scene == "swinging" else r["sag_error_mm"]
                marker = "^" if " x 1," in r["settings"] else "s"
                keeps = abs(r["energy_drift_percent"]) <= 0.01
                face = f"C{colour}" if keeps else "none"
                panel.plot(r["loop_seconds"], error, marker, color=f"C{colour}", markerfacecolor=face)
        panel.set(
            xscale="log", yscale="log", xlabel="wall seconds of the loop", ylabel=labels[scene], title=f"{scene} sheet"
        )
        panel.grid(True, which="both", alpha=0.2)
        panel.legend()
    figure.supxlabel(
        "filled: energy drift of at most 0.01 %; squares: n x n cells; triangles: strips of n x 1", fontsize=9
    )
    figure.savefig(path, dpi=110)
