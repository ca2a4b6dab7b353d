"""The paper's three models of the leaf-in square side by side: no contact, surface-to-surface only, mixed.

    python benchmarks/three_models.py [--until 2.4] [--scene leaf_in]

Every accepted step of each run is looked at in the same way, whatever the run itself modelled: the deepest penetration
of a slave point of the mixed method into a layer (below the thickness that counts there, over the contact thickness),
with the side of every pair kept from the start, and whether the drawn triangles cross (ipctk). Prints a table over time
and writes results/three_models.csv and .png. Needs the extra `test`.
"""

import argparse
import csv
from itertools import pairwise
from pathlib import Path

import ipctk
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import warp as wp

from warp_origami.clock import PhaseClock
from warp_origami.output.memory import Memory
from warp_origami.output.observers import Observers
from warp_origami.scene import load_scene
from warp_origami.solve.sampling import Surface
from warp_origami.solve.simulate import simulate
from warp_origami.system import System

MODELS = {
    "1 no contact": "none",
    "2 surface-to-surface": 'contact.method="sts"',
    "3 mixed": 'contact.method="mixed"',
}
RESULTS = Path(__file__).parent / "results"


class Watch(Memory):
    """Measures penetration and crossing at every accepted step."""

    def __init__(self, system: System):
        super().__init__()
        self.contact, self.interpolation = system.contact, Surface(system)
        triangles = self.interpolation.submesh.triangles.astype(np.int32)
        rest = self.interpolation.frame(0.0, system.q0).points
        self.oracle = ipctk.CollisionMesh(rest, ipctk.edges(triangles), triangles)
        self.rows: list[tuple[float, float, bool]] = []

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """Called after every accepted step with its state."""
        time, q = float(arrays["kinematics.time"]), arrays["kinematics.q"]
        if self.rows and self.rows[-1][0] == time:
            return
        self.contact.gradient(q)
        depth = self.contact.statistics().max_penetration
        self.contact.accept(q)
        crosses = ipctk.has_intersections(self.oracle, self.interpolation.frame(time, q).points)
        self.rows.append((time, depth, crosses))


def scene_of(name: str, setting: str):
    """The scene with one of the three contact models."""
    scene = load_scene(name, [] if setting == "none" else [setting])
    return scene.model_copy(update={"contact": None}) if setting == "none" else scene


def run(name: str, setting: str, until: float) -> tuple[np.ndarray, dict]:
    """Rows (time s, depth m, crosses) of a run, and its summary."""
    watch = Watch(System(load_scene(name), "cpu", PhaseClock()))
    summary = simulate(scene_of(name, setting), Observers([watch]), device="cpu", until=until)
    return np.array(watch.rows, dtype=float), summary


def main() -> None:
    """Runs the three models, prints and writes the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="leaf_in")
    parser.add_argument("--until", type=float, default=2.4, help="s")
    options = parser.parse_args()
    wp.config.quiet = True
    thickness = load_scene(options.scene).contact.thickness
    results = {label: run(options.scene, setting, options.until) for label, setting in MODELS.items()}

    edges = np.arange(0.0, options.until + 0.05, 0.1)
    table = [["time from", *(f"{label}: depth/thickness" for label in MODELS), *(f"{m}: crossing" for m in MODELS)]]
    for low, high in pairwise(edges):
        inside = [rows[(rows[:, 0] > low) & (rows[:, 0] <= high)] for rows, _ in results.values()]
        depth = [f"{part[:, 1].max(initial=0.0) / thickness:.4f}" for part in inside]
        table.append([f"{low:.1f}", *depth, *(f"{int(part[:, 2].sum())} of {len(part)}" for part in inside)])
    width = [max(len(row[k]) for row in table) for k in range(len(table[0]))]
    for row in table:
        print("  ".join(cell.rjust(w) for cell, w in zip(row, width, strict=True)))
    for label, (rows, summary) in results.items():
        print(
            f"{label}: deepest {rows[:, 1].max() / thickness:.4f} of the thickness, {int(rows[:, 2].sum())} of "
            f"{len(rows)} steps cross, {summary['newton_iterations']} iterations, {summary['wall_seconds']:.0f} s"
        )

    RESULTS.mkdir(exist_ok=True)
    with open(RESULTS / "three_models.csv", "w", newline="") as file:
        csv.writer(file).writerows(table)
    figure, axes = plt.subplots(figsize=(8, 4))
    for label, (rows, _) in results.items():
        (line,) = axes.semilogy(rows[:, 0], np.maximum(rows[:, 1] / thickness, 1e-6), label=label)
        crossing = rows[rows[:, 2] > 0]
        axes.plot(crossing[:, 0], crossing[:, 1] / thickness, "x", color=line.get_color())
    axes.set(xlabel="time, s", ylabel="deepest penetration / thickness", title="crosses: the drawn triangles intersect")
    axes.legend()
    figure.tight_layout()
    figure.savefig(RESULTS / "three_models.png", dpi=100)


if __name__ == "__main__":
    main()
