"""What a Newton iteration costs from 50 to 50 000 elements, by parts, with SciPy and with PARDISO.

    python benchmarks/scaling.py [--iterations 8] [--threads 1] [--cells 5 10 22 50 105 158] [--out results/scaling.csv]

A square sheet held along its rim sags under gravity: with the linear law and with wrinkling (SRM), the first steps of
the motion and the equilibrium. An iteration goes from one factorization to the next: factorization, solution, line
search, assembly. Medians over the iterations, CPU seconds of one thread (of several threads: wall seconds); every size
is measured in a process of its own, whose peak of memory goes with it. The first factorization, with the analysis, is
left out and has a column of its own. `ratio` is that of the iteration to its factorization and solution. Exponents
are slopes of log(seconds) over log(elements) from 2000 elements on, by least squares.

Writes results/scaling.csv and .png.
"""

import argparse
import csv
import json
import subprocess
import sys
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from threadpoolctl import threadpool_limits

import warp_origami.clock
from warp_origami.clock import PhaseClock
from warp_origami.scene import Scene
from warp_origami.solve.equilibrium import FIRST_MULTIPLE, EquilibriumSolver, Start
from warp_origami.solve.generalized_alpha import GeneralizedAlpha
from warp_origami.solve.linear import pardiso
from warp_origami.solve.step import Stepper
from warp_origami.solve.summary import peak_memory
from warp_origami.system import System
from warp_origami.terms.threads import use_threads

RESULTS = Path(__file__).parent / "results"
CELLS = (5, 10, 22, 50, 105, 158)
CASES = (("dynamic", "linear"), ("dynamic", "srm"), ("static", "linear"), ("static", "srm"))
PARTS = ("assembly", "factorization", "solve", "other")
LARGE = 2000
"""Elements from which on exponents are fitted."""
STEP = 2e-3
STEPS = 50


class Enough(Exception):
    """All iterations that were wanted."""


class Watch:
    """Takes the place of a constraint form's `factorize` and notes the time of every part at each call."""

    def __init__(self, form, clock: PhaseClock, iterations: int):
        self.clock, self.wanted, self.notes = clock, iterations + 2, []
        self.factorize = form.factorize
        form.factorize = self

    def __call__(self, *arguments):
        self.clock.total()
        self.notes.append(dict(self.clock.seconds))
        if len(self.notes) > self.wanted:
            raise Enough
        return self.factorize(*arguments)

    def parts(self) -> dict[str, float]:
        """Median seconds of each part of an iteration, and of all; of the first factorization."""
        seconds = np.array([[note[part] for part in PARTS] for note in self.notes])
        each = np.diff(seconds, axis=0)
        result = dict(zip(PARTS, np.median(each[1:], axis=0).tolist(), strict=True))
        totals = each[1:].sum(axis=1)
        alone = each[1:, PARTS.index("factorization")] + each[1:, PARTS.index("solve")]
        return {
            **result,
            "iteration": float(np.median(totals)),
            "ratio": float(np.median(totals / alone)),
            "first_factorization": float(each[0, PARTS.index("factorization")]),
            "iterations": len(totals),
        }


def scene(cells: int, kind: str, law: str, solver: str) -> Scene:
    """A square sheet of cells x cells squares of two elements."""
    return Scene(
        name="scaling",
        analysis={"kind": kind} | ({"duration": STEPS * STEP} if kind == "dynamic" else {}),
        pattern={"kind": "sheet", "width": 0.6, "height": 0.6, "nx": cells, "ny": cells},
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4, "model": law},
        support=[{"name": "rim", "at": {"boundary": True}}],
        load=[{"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}],
        integrator={"linear_solver": solver},
    )


def measure(cells: int, kind: str, law: str, solver: str, threads: int, iterations: int) -> dict:
    """A row of the table."""
    if threads == 1:
        warp_origami.clock.time.perf_counter = time.process_time
    clock = PhaseClock()
    begin = time.perf_counter()
    with threadpool_limits(1), use_threads(threads):
        system = System(scene(cells, kind, law, solver), "cpu", clock)
        if kind == "dynamic":
            run = Stepper(system, GeneralizedAlpha(0.3))
            state = run.start(STEP)
        else:
            run = EquilibriumSolver(system)
            state = Start(system.q0, np.zeros(system.q0.size))
        setup = time.perf_counter() - begin
        watch = Watch(run.constraint_form, clock, iterations)
        try:
            if kind == "dynamic":
                for _ in range(STEPS):
                    outcome = run.try_step(*state, STEP)
                    state = (outcome.kinematics, outcome.forces, outcome.balance)
            else:
                run.solve(state, system.external.at(1.0), FIRST_MULTIPLE)
        except Enough:
            pass
    return {
        "elements": len(system.mesh.triangles),
        "unknowns": system.constraints.null_space.shape[1],
        "kind": kind,
        "law": law,
        "solver": solver,
        "threads": threads,
        **watch.parts(),
        "setup": setup,
        "peak_megabytes": peak_memory() / 1e6,
    }


def measure_apart(options: argparse.Namespace) -> list[dict]:
    """All rows, each measured in its own process, written as soon as they are there."""
    rows = []
    solvers = ("scipy", "pardiso") if pardiso.is_installed() else ("scipy",)
    for kind, law in CASES:
        for solver in solvers:
            for cells in options.cells:
                one = [kind, law, solver, str(options.threads), str(options.iterations)]
                command = [sys.executable, __file__, "--one", str(cells), *one]
                found = subprocess.run(command, capture_output=True, text=True, check=True)
                rows.append(json.loads(found.stdout.splitlines()[-1]))
                print(rows[-1], flush=True)
                with options.out.open("w", newline="", encoding="utf-8") as file:
                    writer = csv.DictWriter(file, rows[0])
                    writer.writeheader()
                    writer.writerows(
                        {k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows
                    )
    return rows


def exponent(rows: list[dict], part: str) -> float:
    """Slope of log(seconds) over log(elements) of the large sizes."""
    large = [(float(row["elements"]), float(row[part])) for row in rows if float(row["elements"]) >= LARGE]
    return float(np.polyfit(*np.log(np.array(large)).T, 1)[0]) if len(large) > 1 else float("nan")


def plot(rows: list[dict], path: Path) -> None:
    """Seconds of the parts over the size, a picture for each case and solver."""
    groups: dict[tuple, list[dict]] = {}
    for row in rows:
        groups.setdefault((row["solver"], row["kind"], row["law"]), []).append(row)
    solvers = sorted({key[0] for key in groups}, reverse=True)
    figure, axes = plt.subplots(len(solvers), len(CASES), figsize=(15, 3.6 * len(solvers)), sharex=True, sharey=True)
    for (solver, kind, law), group in groups.items():
        axis = np.atleast_2d(axes)[solvers.index(solver), CASES.index((kind, law))]
        elements = [float(row["elements"]) for row in group]
        for part, style in (
            ("iteration", "k-o"),
            ("factorization", "C3-"),
            ("assembly", "C0-"),
            ("solve", "C2-"),
            ("other", "C7-"),
        ):
            label = f"{part} ({exponent(group, part):.2f})"
            axis.loglog(elements, [1e3 * float(row[part]) for row in group], style, markersize=3, label=label)
        ratio = next((float(row["ratio"]) for row in group if 2e4 <= float(row["elements"]) <= 3e4), float("nan"))
        axis.set_title(f"{solver}, {kind}, {law}: ratio {ratio:.2f} at 22 050", fontsize=9)
        axis.legend(fontsize=7, title="ms (exponent)", title_fontsize=7)
        axis.grid(alpha=0.3)
        axis.set_xlabel("elements")
    figure.supylabel("milliseconds of a Newton iteration")
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main() -> None:
    """Measures, writes and draws."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=8)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--cells", type=int, nargs="+", default=CELLS)
    parser.add_argument("--out", type=Path, default=RESULTS / "scaling.csv")
    parser.add_argument("--one", nargs=6, metavar=("CELLS", "KIND", "LAW", "SOLVER", "THREADS", "ITERATIONS"))
    parser.add_argument("--draw", action="store_true", help="draw the table that is there")
    options = parser.parse_args()
    if options.one:
        cells, kind, law, solver, threads, iterations = options.one
        print(json.dumps(measure(int(cells), kind, law, solver, int(threads), int(iterations))))
        return
    if options.draw:
        rows = list(csv.DictReader(options.out.open(encoding="utf-8")))
    else:
        rows = measure_apart(options)
    plot(rows, options.out.with_suffix(".png"))


if __name__ == "__main__":
    main()
