"""What the step tolerance buys on a scene: energy lost to the method, steps, Newton iterations, seconds.

    python benchmarks/tolerance.py [--scene leaf_in] [--tolerances 4e-4 2e-4 1e-4 5e-5]

Prints a table and writes results/tolerance.csv. Loss and gain are over the largest energy of the run.
"""

import argparse
import csv
from pathlib import Path

import warp as wp

import warp_origami as origami

COLUMNS = ("energy_loss", "energy_gain", "steps_accepted", "steps_rejected", "newton_iterations", "wall_seconds")
RESULTS = Path(__file__).parent / "results"


def main() -> None:
    """Runs the scene once per tolerance."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="leaf_in")
    parser.add_argument("--tolerances", nargs="+", type=float, default=[4e-4, 2e-4, 1e-4, 5e-5])
    options = parser.parse_args()
    wp.config.quiet = True
    rows = [["tolerance", *COLUMNS]]
    print("  ".join(name.rjust(17) for name in rows[0]), flush=True)
    for tolerance in options.tolerances:
        scene = origami.load_scene(options.scene, [f"integrator.tolerance={tolerance}"])
        summary = origami.simulate(scene, device="cpu").summary
        rows.append([f"{tolerance:g}", *(f"{summary[name]:.4g}" for name in COLUMNS)])
        print("  ".join(cell.rjust(17) for cell in rows[-1]), flush=True)
    RESULTS.mkdir(exist_ok=True)
    with open(RESULTS / "tolerance.csv", "w", newline="") as file:
        csv.writer(file).writerows(rows)


if __name__ == "__main__":
    main()
