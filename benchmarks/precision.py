"""Does float32 earn its place? Seconds, errors and convergence of three variants of the membrane, side by side.

    python benchmarks/precision.py

float64   the product.
float32   membrane, pressure and the sums into the tangent matrix in float32, the rest in float64 (float32_copy.py).
mixed     forces from the float64 kernels, tangents from the float32 ones.

Writes results/precision.csv and .png, in about two minutes of CPU time. Times are CPU seconds of one thread on one
core, each variant in turn, medians; only their ratios mean something on another machine.
"""

import csv
import os
import tempfile
import time
from functools import partial
from pathlib import Path
from types import ModuleType

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import warp as wp
from float32_copy import import_single, make_system, module_of
from warp_origami.kernels.membrane import PAIRS

import warp_origami
from warp_origami.output.memory import Memory
from warp_origami.solve.equilibrium import STEP_TOLERANCE
from warp_origami.solve.step import NEWTON_SHARE
from warp_origami.terms.quadrature import rule
from warp_origami.terms.shapes import tabulate

RESULTS = Path(__file__).parent / "results"
POLYIMIDE = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4}
STRAINS = np.logspace(-6, -2, 17)
OVERSTRETCH = 2e-4
"""Of the corners of the leaf-in at the end: its largest strain."""
PATIENCE = 10
"""CPU seconds granted to a run."""
RUNS = (
    ("square", "1000 Pa", 1.0, None),
    ("square", "1000 Pa", 1.0, 1e-7),
    ("square", "1 Pa", 1.0, None),
    ("square", "1 Pa", 1.0, 1e-7),
    ("sagging_sheet", "auto", 0.02, None),
    ("sagging_sheet", "auto", 0.02, 1e-5),
    ("sagging_sheet", "5e-4", 0.02, 1e-5),
    ("leaf_in", "auto", 0.2, None),
    ("leaf_in", "auto", 0.2, 4e-7),
    ("leaf_in", "0.02", 0.2, 4e-7),
)
"""Scene, its pressure or its step (s), where to end, and Newton's tolerance over the size (None: the product's)."""


def square(package: ModuleType, cells: int, load: float = 0.0):
    """A square of 0.6 m, held all around, under follower pressure (Pa)."""
    pattern = {"kind": "sheet", "width": 0.6, "height": 0.6, "nx": cells, "ny": cells}
    support, loads = [{"at": {"boundary": True}}], [{"kind": "pressure", "value": load}] if load else []
    analysis = {"kind": "static", "load_steps": 4}
    given = {"analysis": analysis, "pattern": pattern, "support": support, "load": loads}
    return package.Scene(name="square", material=POLYIMIDE | {"model": "linear"}, **given)


def time_kernels(packages: list[ModuleType]) -> list[list]:
    """Median CPU milliseconds of both packages in turn: 48 elements (leaf-in, wrinkling law), 2048 and 20 000."""
    rows = []
    for cells, repeats in ((0, 300), (32, 40), (100, 9)):
        taken = np.empty((repeats + 1, len(packages), 3))
        ready = []
        for package in packages:
            system = make_system(package, square(package, cells) if cells else package.load_scene("leaf_in"))
            sparsity = module_of(package, "terms.sparsity").ReducedSparsity(
                system.coordinates.elements, system.coordinates.count, system.constraints.null_space
            )
            q = system.q0 + 1e-4 * np.sin(np.arange(system.q0.size)).reshape(-1, 3)
            ready.append((system.membrane, sparsity, q))
        for row in taken:
            for k, (membrane, sparsity, q) in enumerate(ready):
                marks = [time.process_time()]
                for call in (
                    membrane.gradient,
                    membrane.linearize,
                    lambda _, s=sparsity, m=membrane: s.values(m.blocks),
                ):
                    call(q)
                    marks.append(time.process_time())
                row[k] = np.diff(marks)
        median = 1e3 * np.median(taken[1:], axis=0)
        for name, pair in zip(("gradient", "gradient and tangent", "sums into the matrix"), median.T, strict=True):
            rows.append(["CPU ms", f"{name}, {len(system.mesh.triangles)} elements", *pair, ""])
    return rows


def errors_of_forces(packages: list[ModuleType], cells: int, strains: np.ndarray) -> np.ndarray:
    """(strains, 2 energy and force, packages) relative errors of a turned sheet under equal stretch both ways."""
    systems = [make_system(p, square(p, cells)) for p in packages]
    mesh, coordinates, q0 = systems[0].mesh, systems[0].coordinates, systems[0].q0
    turn = np.linalg.qr(np.array([[0.3, 0.8, 0.1], [0.5, -0.2, 0.9], [-0.7, 0.4, 0.6]]))[0]
    areas, weights = rule(6)
    count = len(mesh.triangles)
    shapes = tabulate(mesh, np.repeat(np.arange(count), len(areas)), np.tile(areas, (count, 1))).gradients
    volumes = POLYIMIDE["thickness"] * mesh.areas[:, None] * weights
    derivatives = np.einsum("ep,epia->eia", volumes, shapes.reshape(count, len(areas), 9, 2))
    positions = coordinates.positions[coordinates.positions >= 0]
    errors = np.empty((len(strains), 2, len(packages)))
    for k, strain in enumerate(strains):
        # exact: with stretch l the Green strain is (l^2 - 1) / 2 = e both ways, S = E e / (1 - nu), t = S l a_x
        stretch = np.sqrt(1.0 + 2.0 * strain)
        stress = POLYIMIDE["youngs_modulus"] / (1.0 - POLYIMIDE["poisson_ratio"]) * strain
        force = np.zeros_like(q0)
        np.add.at(force, coordinates.elements, stress * stretch * derivatives @ turn.T[:2])
        for j, system in enumerate(systems):
            energy, gradient = system.membrane.gradient(stretch * q0 @ turn.T)
            errors[k, 0, j] = abs(energy / (volumes.sum() * stress * strain) - 1.0)
            errors[k, 1, j] = np.linalg.norm((gradient - force)[positions]) / np.linalg.norm(force[positions])
    return errors


class Watch(Memory):
    """Keeps the run and ends it after so many CPU seconds."""

    def __init__(self):
        super().__init__()
        self.end = time.process_time() + PATIENCE

    def step(self, record) -> None:
        super().step(record)
        if time.process_time() > self.end:
            raise TimeoutError


def run(package: ModuleType, scene, exact_forces: bool, until: float, tolerance: float) -> tuple[str, Watch]:
    """What became of a run with Newton's `tolerance` (over the size of the sheet)."""
    module_of(package, "solve.simulate").System = partial(make_system, package, exact_forces=exact_forces)
    module_of(package, "solve.equilibrium").STEP_TOLERANCE = tolerance
    module_of(package, "solve.step").NEWTON_SHARE = tolerance / scene.integrator.tolerance
    watch = Watch()
    try:
        package.simulate(scene, device="cpu", until=until, observers=[watch])
    except TimeoutError:
        last = {name: column[-1] for name, column in watch.history.items()}
        return f"given up after {PATIENCE} s at t = {last['time']:.1e} s with steps of {last['step']:.0e} s", watch
    except module_of(package, "errors").NumericalFailure:
        return watch.summary["message"], watch
    if watch.summary["status"] != "done":
        raise KeyboardInterrupt
    return f"{watch.summary['newton_iterations']} iterations", watch


def deviation(watch: Watch, reference: Watch) -> float:
    """Largest difference of the drawn points at the end, over the largest displacement of the reference."""
    end, begin = reference.frames[-1].points, reference.frames[0].points
    return np.abs(watch.frames[-1].points - end).max() / np.abs(end - begin).max()


def compare_runs(packages: list[ModuleType]) -> tuple[list[list], float]:
    """Rows on convergence and on the share of assembly; the strain (rms) of the leaf-in after 0.2 s."""
    rows, shares = [], []
    for name, setting, until, loose in RUNS:
        row = []
        for package, exact in ((packages[0], False), (packages[1], False), (packages[1], True)):
            if name == "square":
                scene = square(package, 8, float(setting.split()[0]))
            else:
                scene = package.load_scene(name, [] if setting == "auto" else [f"integrator.step={setting}"])
            own = STEP_TOLERANCE if name == "square" else NEWTON_SHARE * scene.integrator.tolerance
            words, watch = run(package, scene, exact, until, loose or own)
            if not row and loose is None:
                reference = watch
            done = watch.summary.get("status") == "done"
            row.append(words + (f", off by {deviation(watch, reference):.1e}" if done else ""))
        step = setting if name == "square" else f"step {setting}"
        rows.append(["run", f"{name}, {step}, Newton tolerance {loose or own:.0e}", *row])
        print(*rows[-1], sep="; ", flush=True)
        if setting == "auto" and loose is None:
            phases = reference.summary["phases"]
            loop = sum(phases.values()) - phases["compile"] - phases["setup"]
            parts = ("assembly", "contact", "factorization")
            shares += [["share of the time loop", f"{part}, {name}", phases[part] / loop, "", ""] for part in parts]
    energy = reference.history["strain_energy"][-1]
    return rows + shares, np.sqrt(2.0 * energy / POLYIMIDE["youngs_modulus"] / (0.36 * POLYIMIDE["thickness"]))


def draw(errors: np.ndarray, smallest: float) -> None:
    """Errors of the force against strain."""
    figure, axes = plt.subplots(figsize=(7, 4.5))
    axes.axvspan(smallest, OVERSTRETCH, color="0.9", label="leaf_in: at 0.2 s to the end (4 s)")
    for k, name in enumerate(("float64", "float32")):
        (line,) = axes.loglog(STRAINS, errors[:, 1, k], "o-", label=f"force, {name}")
        axes.loglog(STRAINS, errors[:, 0, k], ":", color=line.get_color(), label=f"energy, {name}")
        unit = np.finfo(name).eps / 2.0
        axes.loglog(STRAINS, unit / STRAINS, "--", color="0.4", label="unit round-off / strain" if k else None)
    axes.set(xlabel="Green strain, equal both ways", ylabel="relative error", xlim=(STRAINS[0], STRAINS[-1]))
    axes.legend(fontsize=8, loc="center", bbox_to_anchor=(0.5, 0.46))
    figure.tight_layout()
    figure.savefig(RESULTS / "precision.png", dpi=100)


def main() -> None:
    """Measures, prints and writes the table and the plot."""
    wp.config.log_level = wp.LOG_WARNING
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as folder:
        packages = [warp_origami, import_single(Path(folder))]
        rows = [["quantity", "case", "float64", "float32", "mixed"], *time_kernels(packages)]
        errors = errors_of_forces(packages, 5, STRAINS)
        for k in range(0, len(STRAINS), 4):
            for j, name in enumerate(("energy", "force")):
                rows.append(
                    [f"relative error of the {name}", f"strain {STRAINS[k]:.0e}, 50 elements", *errors[k, j], ""]
                )
        for cells in (10, 20, 40):
            ((_, force),) = errors_of_forces(packages, cells, np.array([1e-5]))
            rows.append(["relative error of the force", f"strain 1e-05, {2 * cells**2} elements", *force, ""])
        others, tangent = 12 * (2 * 9 + 1) + 9 * 3 + 1, 9 * PAIRS  # shapes, volumes, gradient and energy; blocks
        sizes = [8 * (others + tangent), 4 * (others + tangent), 12 * others + 4 * tangent]
        rows.append(["bytes on the device", "an element, membrane", *sizes])
        found, smallest = compare_runs(packages)
    rows += found
    RESULTS.mkdir(exist_ok=True)
    cells = [[f"{c:.3g}" if isinstance(c, float) else c for c in row] for row in rows]
    with open(RESULTS / "precision.csv", "w", newline="") as file:
        csv.writer(file).writerows(cells)
    for row in cells[: -len(found)] + [row for row in cells if row[0].startswith("share")]:
        print(*row, sep="; ")
    draw(errors, smallest)


if __name__ == "__main__":
    main()
