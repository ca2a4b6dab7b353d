"""Angular momentum of spinning runs: what the integrator loses of it, and spin rate against deployment.

    python benchmarks/spin.py           all parts: about five minutes on two cores
    python benchmarks/spin.py rigid     a rigid body, one turn: loss over step and spectral radius
    python benchmarks/spin.py settings  the first 1.3 s of a coarse sail: loss over tolerance and spectral radius
    python benchmarks/spin.py ikaros    the scene `ikaros`: table and plot; exit 1 if more than 0.1 % is lost

Results: results/spin_rigid.csv, results/spin_settings.csv, results/spin_ikaros.csv, results/spin_ikaros.png.
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import warp_origami as wo

RESULTS = Path(__file__).parent / "results"
ALLOWED = 1e-3
"""Of the angular momentum, that a deployment may lose."""


def rigid() -> None:
    """Prints and writes the share of the angular momentum that a rigid body loses in one turn."""
    rows = []
    for radius in (0.0, 0.3, 0.6, 0.9):
        for turn in (0.1, 0.05, 0.025):
            scene = wo.Scene(
                name="rigid",
                analysis={"kind": "dynamic", "duration": 2.0 * np.pi},
                pattern={"kind": "sheet", "origin": [-0.5, -0.5]},
                material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 7.5e-6},
                hub={"at": {"all": True}, "mass": 3.0, "axial_inertia": 2.0, "transverse_inertia": 1.5},
                load=[{"kind": "initial_spin", "rate": 1.0}],
                integrator={"step": turn, "spectral_radius": radius},
                output={"fps": 0.1},
            )
            loss = -wo.simulate(scene).summary["angular_momentum_change"]
            rows.append((radius, turn, loss, loss / (2.0 * np.pi * turn**3)))
    _write("spin_rigid.csv", ("spectral_radius", "angle_per_step", "lost_in_a_turn", "over_angle_cubed"), rows)


def settings() -> None:
    """Prints and writes what the sail with two strips a petal loses while its arms open."""
    rows = []
    for radius, tolerance in ((0.3, 4e-4), (0.3, 1e-4), (0.3, 2.5e-5), (0.0, 1e-4), (0.15, 1e-4), (0.6, 1e-4)):
        changes = [
            "pattern.strips=2",
            "pattern.opening=0.3",
            f"integrator.tolerance={tolerance}",
            f"integrator.spectral_radius={radius}",
        ]
        result = wo.simulate(wo.load_scene("ikaros", changes), until=1.3)
        momentum = result.spin["angular_momentum.z"]
        worst = float(np.abs(momentum / momentum[0] - 1.0).max())
        rows.append((radius, tolerance, result.summary["steps_accepted"], worst, result.summary["energy_loss"]))
    _write("spin_settings.csv", ("spectral_radius", "tolerance", "steps", "largest_change", "energy_loss"), rows)


def ikaros() -> float:
    """Runs the scene; writes its table and plot; returns the largest relative change of angular momentum."""
    result = wo.simulate(wo.load_scene("ikaros"))
    time, spin = result.history["time"], result.spin
    inertia, momentum = spin["moment_of_inertia"], spin["angular_momentum.z"]
    mean, law = momentum / inertia, momentum[0] / inertia
    change = momentum / momentum[0] - 1.0
    columns = ("time", "moment_of_inertia", "hub_rate", "mean_rate", "rate_of_conservation", "change")
    _write("spin_ikaros.csv", columns, np.column_stack([time, inertia, spin["rate"], mean, law, change])[::5])
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    order = np.argsort(inertia)
    left.plot(inertia[order], law[order], color="0.6", linewidth=4, label="conservation, L(0) / I")
    left.plot(inertia, mean, color="C0", linewidth=1.2, label="all, L / I")
    left.plot(inertia, spin["rate"], color="C1", linewidth=0.8, label="hub")
    left.set(xlabel="moment of inertia I (kg m$^2$)", ylabel="spin rate (rad/s)")
    left.legend()
    right.plot(time, 100.0 * change, color="C0")
    right.axhspan(-100.0 * ALLOWED, 100.0 * ALLOWED, color="0.92")
    right.set(xlabel="time (s)", ylabel="change of angular momentum (%)")
    figure.savefig(RESULTS / "spin_ikaros.png", dpi=110)
    worst = float(np.abs(change).max())
    counts = [result.summary[key] for key in ("elements", "dofs", "steps_accepted", "newton_iterations")]
    print("{} elements, {} unknowns, {} steps, {} Newton iterations".format(*counts))
    touching = sum(result.history[f"contacts_{kind}"] for kind in ("sts", "nts", "edge")) > 0
    print(f"contact in {int(touching.sum())} steps, deepest {result.summary['max_penetration']:.2g} m")
    print(
        f"moment of inertia {inertia[0]:.1f} to {inertia.max():.1f} kg m^2; mean rate {mean[0]:.3f} to {mean.min():.3f}"
    )
    print(f"angular momentum changes by {100.0 * worst:.3f} % at most; {100.0 * ALLOWED:g} % is allowed")
    return worst


def _write(name: str, columns, rows) -> None:
    with (RESULTS / name).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([f"{value:.6g}" for value in row] for row in rows)
    if len(rows) < 20:
        print((RESULTS / name).read_text(encoding="utf-8"))


def main(parts: list[str]) -> int:
    """Runs the parts; 1 if the scene loses too much."""
    if not parts or "rigid" in parts:
        rigid()
    if not parts or "settings" in parts:
        settings()
    if not parts or "ikaros" in parts:
        return int(ikaros() > ALLOWED)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
