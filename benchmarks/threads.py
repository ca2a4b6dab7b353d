"""What threads gain: assembly and contact on one thread and on all cores, in turn, and whether the results agree.

    python benchmarks/threads.py [--elements 48 700 20000] [--rounds 15] [--threads N]

Prints medians and the ratio of their times, and writes results/threads.csv. Assembly: element tangents, their gradient
and the sum into the tangent of the free coordinates. Contact: one evaluation of a crumpled sheet of leaf-in folds. Run
it on an otherwise idle machine: a second core that is busy gains nothing.
"""

import argparse
import csv
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import warp as wp

import warp_origami as origami
from warp_origami.clock import PhaseClock
from warp_origami.system import System
from warp_origami.terms.threads import available_cores, use_threads

RESULTS = Path(__file__).parent / "results" / "threads.csv"
WAVE = 1e-3
"""Amplitude of the random change of q, over the size of the sheet, at the finest mesh less."""


def main() -> None:
    """Measures every size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", nargs="+", type=int, default=[48, 700, 20000])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--threads", type=int, default=available_cores())
    options = parser.parse_args()
    wp.config.quiet = True
    rows = []
    for elements in options.elements:
        system = _system(elements)
        q = _state(system)
        for name, work in (("assembly", _assembly(system, q)), ("contact", _contact(system, q))):
            one, several, equal = _compare(work, options.rounds, options.threads)
            row = (name, len(system.mesh.triangles), options.threads, one * 1e3, several * 1e3, one / several, equal)
            rows.append(row)
            times = f"1 thread {row[3]:9.3f} ms, {row[2]} threads {row[4]:9.3f} ms: {row[5]:.2f} times as fast"
            print(f"{name:<9} {row[1]:6} elements: {times}, bitwise equal: {equal}", flush=True)
    RESULTS.parent.mkdir(exist_ok=True)
    with open(RESULTS, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["work", "elements", "threads", "ms_one", "ms_several", "ratio", "bitwise_equal"])
        writer.writerows((*row[:3], *(f"{value:.4g}" for value in row[3:6]), row[6]) for row in rows)


def _system(elements: int) -> System:
    """The stowed leaf-in, refined to about so many elements."""
    refine = max(1, round((elements / 48.0) ** 0.5))
    return System(origami.load_scene("leaf_in", [f"pattern.refine={refine}"]), "cpu", PhaseClock())


def _state(system: System) -> np.ndarray:
    """A state a little off the start, smooth enough for layers to touch here and there."""
    random = np.random.default_rng(1)
    scale = WAVE * system.mesh.size * np.minimum(1.0, 10.0 * system.row_lengths / system.mesh.size)
    return system.q0 + scale[:, None] * random.standard_normal(system.q0.shape)


def _assembly(system: System, q: np.ndarray) -> Callable[[], list[np.ndarray]]:
    def work() -> list[np.ndarray]:
        _, gradient = system.membrane.linearize(q)
        return [gradient, system.reduced_sparsity.values(system.membrane.blocks)]

    return work


def _contact(system: System, q: np.ndarray) -> Callable[[], list[np.ndarray]]:
    states = [q, system.q0]  # in turn, for the last state is kept

    def work() -> list[np.ndarray]:
        return [system.contact.gradient(state)[1] for state in states]

    return work


def _compare(work: Callable[[], list[np.ndarray]], rounds: int, threads: int) -> tuple[float, float, bool]:
    """Median seconds on one and on several threads, taken in turn, and whether all results agree bitwise."""
    expected = [part.copy() for part in work()]
    times, equal = ([], []), True
    with use_threads(threads) as team:
        for _ in range(rounds):
            for place, count in enumerate((1, threads)):
                team.size = count
                start = time.perf_counter()
                found = work()
                times[place].append(time.perf_counter() - start)
                equal &= all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))
        team.size = threads
    return float(np.median(times[0])), float(np.median(times[1])), equal


if __name__ == "__main__":
    main()
