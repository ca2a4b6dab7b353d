"""What the parts of Newton's iteration are worth: factorizations of the leaf-in without contact, 4 s.

    python benchmarks/strategies.py [--tolerances 1e-3 1.1785e-3] [--variants plain "as it is"]

Runs the scene once per variant of the iteration and per tolerance, each variant in a process of its own; prints a table
and writes results/strategies.csv. A tolerance of 1.1785e-3 is 1 mm a step. Counts depend on where steps happen to
end: differences of 10 % say nothing.
"""

import argparse
import csv
import json
import subprocess
import sys
import time
from pathlib import Path

import warp as wp
from warp_origami.kernels import srm
from warp_origami.kernels.precision import vec3

import warp_origami as origami
from warp_origami.solve import mixed_newton, newton, step
from warp_origami.solve.step_potential import StepPotential

RESULTS = Path(__file__).parent / "results"
COLUMNS = ("steps_accepted", "steps_rejected", "newton_iterations", "energy_gain")


@wp.func
def strain_of_the_step(p: srm.Parameters, at: vec3, to: vec3):
    """The strain that the step leads to, whatever stress was foretold."""
    return to


def plain() -> None:
    """Newton's iteration on q alone, with the line search on the slope."""
    step.minimize_mixed = lambda potential, start, before, tolerance: newton.minimize(potential, start, tolerance)


def searched() -> None:
    """The line search on the slope of the potential instead of few lengths."""

    def length(potential, q, direction, slope):
        slope = float(potential.gradient(q) @ direction)
        return (newton.line_search(potential, q, direction, slope) if slope < 0.0 else 0.3), None

    mixed_newton._length = length


def from_the_last_state() -> None:
    """The iteration starts from the state at the begin of the step, but where drivers move the sheet."""
    predictor = step.Stepper._predictor

    def start(self, form):
        still = type(form)(**{**vars(form), "predictor": self.begin})
        return predictor(self, still)

    tried = step.Stepper.try_step

    def try_step(self, before, *others):
        self.begin = before.q
        return tried(self, before, *others)

    step.Stepper._predictor, step.Stepper.try_step = start, try_step


def strains_by_power(power: float) -> None:
    """Strains take another part of a step than q."""
    advance = StepPotential.advance_strains
    StepPotential.advance_strains = lambda self, q, d, length: advance(self, q, d, length**power)


def setting(name: str, value: object):
    """A variant with another constant of the mixed iteration."""
    return lambda: setattr(mixed_newton, name, value)


VARIANTS = {
    "as it is": lambda: None,
    "plain iteration": plain,
    "states by strain alone": lambda: setattr(srm, "next_strain", strain_of_the_step),
    "strains take l^0.5": lambda: strains_by_power(0.5),
    "strains take whole steps": lambda: strains_by_power(0.0),
    "ends with a factor of its own": setting("MAXIMUM_CHORDS", 0),
    "full steps only": setting("LENGTHS", (1.0,)),
    "lengths 1, 0.5": setting("LENGTHS", (1.0, 0.5)),
    "lengths 1, 0.5, 0.3": setting("LENGTHS", (1.0, 0.5, 0.3)),
    "line search on the slope": searched,
    "slope may rise to 0.5": setting("LARGEST_RISE", 0.5),
    "slope may rise to 2": setting("LARGEST_RISE", 2.0),
    "starts from the last state": from_the_last_state,
}


def run(variant: str, tolerance: float) -> dict:
    """Summary of one run in this process, with its CPU seconds after everything is compiled."""
    wp.config.quiet = True
    VARIANTS[variant]()
    scene = origami.load_scene("leaf_in", [f"integrator.tolerance={tolerance}"]).model_copy(update={"contact": None})
    origami.simulate(scene, device="cpu", until=0.01)
    begin = time.process_time()
    summary = origami.simulate(scene, device="cpu", threads=1).summary
    return {name: summary[name] for name in ("status", *COLUMNS)} | {"cpu": time.process_time() - begin}


def main() -> None:
    """Runs all variants."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tolerances", nargs="+", type=float, default=[1e-3, 1.1785e-3])
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=list(VARIANTS))
    parser.add_argument("--one", action="store_true", help="print the summary of one variant as JSON")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(run(options.variants[0], options.tolerances[0])))
        return
    rows = [["variant", "tolerance", "status", *COLUMNS, "cpu_seconds"]]
    for variant in options.variants:
        for tolerance in options.tolerances:
            command = [sys.executable, __file__, "--one", "--variants", variant, "--tolerances", str(tolerance)]
            output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            found = json.loads(output.splitlines()[-1])
            numbers = [f"{found[name]:.5g}" for name in COLUMNS]
            rows.append([variant, f"{tolerance:g}", found["status"], *numbers, f"{found['cpu']:.1f}"])
            print("  ".join(cell.rjust(18) for cell in rows[-1]), flush=True)
    RESULTS.mkdir(exist_ok=True)
    with open(RESULTS / "strategies.csv", "w", newline="") as file:
        csv.writer(file).writerows(rows)


if __name__ == "__main__":
    main()
