"""What the step tolerance buys: energy lost to the method, steps, iterations and seconds; error of smooth motion.

    python benchmarks/tolerance.py [--scene leaf_in] [--tolerances 4e-4 2e-4 1e-4 5e-5]
    python benchmarks/tolerance.py --smooth

Prints a table and writes results/tolerance.csv, or results/tolerance_smooth.csv. Loss and gain are over the largest
energy of the run. Smooth: a sheet that drums, held at its rim, against its own run with small steps; root mean square
of the error in position after 2.5 vibrations.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
import warp as wp

import warp_origami as origami

COLUMNS = ("energy_loss", "energy_gain", "steps_accepted", "steps_rejected", "newton_iterations", "wall_seconds")
RESULTS = Path(__file__).parent / "results"
PLACES = [[0.075 * i, 0.075 * j] for i in range(1, 8) for j in range(1, 8)]
REFERENCE = {"step": 1e-4, "spectral_radius": 0.9}


def drumming(**integrator: float) -> origami.Run:
    """A run of the drumming sheet."""
    scene = origami.Scene(
        name="drumming_sheet",
        analysis={"kind": "dynamic", "duration": 0.4},
        pattern={
            "kind": "sheet",
            "width": 0.6,
            "height": 0.6,
            "nx": 4,
            "ny": 4,
            "initial": {"stretch": [1.002, 1.002]},
        },
        material={
            "density": 1420.0,
            "youngs_modulus": 2.5e7,
            "poisson_ratio": 0.34,
            "thickness": 5e-4,
            "model": "linear",
        },
        support=[{"name": "rim", "at": {"boundary": True}}],
        load=[{"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}],
        probe=[{"name": f"p{k}", "at": place} for k, place in enumerate(PLACES)],
        integrator=integrator,
        output={"fps": 1.0, "fields": []},
    )
    return origami.simulate(scene, device="cpu", until=0.3)


def final_places(run: origami.Run) -> np.ndarray:
    """(n, 3) positions of the probes at the end, m."""
    return np.array([probe[-1, :3] for probe in run.probes.values()])


def smooth(tolerances: list[float]) -> list[list[str]]:
    """Rows of error against tolerance at both spectral radii."""
    exact = final_places(drumming(**REFERENCE))
    rows = [["spectral_radius", "tolerance", "error_mm", "error_over_tolerance", "steps_accepted", "steps_rejected"]]
    for radius in (0.3, 0.8):
        for tolerance in tolerances:
            run = drumming(spectral_radius=radius, tolerance=tolerance)
            error = float(np.sqrt(np.mean((final_places(run) - exact) ** 2)))
            share = error / (tolerance * 0.6 * np.sqrt(2.0))
            steps = [str(run.summary[name]) for name in ("steps_accepted", "steps_rejected")]
            rows.append([f"{radius:g}", f"{tolerance:g}", f"{1e3 * error:.3g}", f"{share:.3g}", *steps])
            show(rows[-1])
    return rows


def losses(name: str, tolerances: list[float]) -> list[list[str]]:
    """Rows of a scene's summary, one per tolerance."""
    rows = [["tolerance", *COLUMNS]]
    for tolerance in tolerances:
        scene = origami.load_scene(name, [f"integrator.tolerance={tolerance}"])
        summary = origami.simulate(scene, device="cpu").summary
        rows.append([f"{tolerance:g}", *(f"{summary[column]:.4g}" for column in COLUMNS)])
        show(rows[-1])
    return rows


def show(row: list[str]) -> None:
    """Prints a row of the table as soon as it is known."""
    print("  ".join(cell.rjust(17) for cell in row), flush=True)


def main() -> None:
    """Runs once per tolerance."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="leaf_in")
    parser.add_argument("--smooth", action="store_true")
    parser.add_argument("--tolerances", nargs="+", type=float)
    options = parser.parse_args()
    wp.config.quiet = True
    if options.smooth:
        rows = smooth(options.tolerances or [2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6])
    else:
        rows = losses(options.scene, options.tolerances or [4e-4, 2e-4, 1e-4, 5e-5])
    RESULTS.mkdir(exist_ok=True)
    with open(RESULTS / ("tolerance_smooth.csv" if options.smooth else "tolerance.csv"), "w", newline="") as file:
        csv.writer(file).writerows(rows)


if __name__ == "__main__":
    main()
