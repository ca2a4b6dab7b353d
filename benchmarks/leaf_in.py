"""The leaf-in from start to end: seconds by phase, Newton iterations, one thread and all, and how long a start takes.

    python benchmarks/leaf_in.py [--rounds 1]

Every run is a process of its own, as from the command line. Prints a table and writes results/leaf_in.csv. Rows: the
scene as it is, on all cores and on one; without contact, with a local error of 1e-3 m a step; one step from a warm and
from an empty kernel cache. `ms` is the time of one Newton iteration, everything included but what a run to the first
step takes with a warm cache (imports, set-up).
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from warp_origami.scene import load_scene

RESULTS = Path(__file__).parent / "results" / "leaf_in.csv"
ERROR = 1e-3
"""Local error of a step, m, of the runs without contact."""
WARM = "first step, warm cache"
COLUMNS = ("run", "seconds", "steps_accepted", "steps_rejected", "newton_iterations", "ms", "other", "energy_gain")


def main() -> None:
    """Runs all rows, the shortest of some rounds each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        free = Path(folder) / "free.toml"
        _write_without_contact(free)
        size = 0.6 * 2.0**0.5
        runs = {
            WARM: ("leaf_in", "--until", "1e-4"),
            "first step, empty cache": ("leaf_in", "--until", "1e-4"),
            "all cores": ("leaf_in",),
            "one thread": ("leaf_in", "--threads", "1"),
            "without contact, 1e-3 m": (str(free), "--set", f"integrator.tolerance={ERROR / size}"),
        }
        rows = []
        for name, arguments in runs.items():
            found = [_run(name, arguments, Path(folder)) for _ in range(options.rounds)]
            row = min(found, key=lambda row: row["seconds"])
            if row["steps_accepted"] > 1:
                row["ms"] = round(1e3 * (row["seconds"] - rows[0]["seconds"]) / row["newton_iterations"], 3)
            rows.append(row)
            print("  ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
    RESULTS.parent.mkdir(exist_ok=True)
    with open(RESULTS, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


def _write_without_contact(path: Path) -> None:
    scene = load_scene("leaf_in").model_copy(update={"contact": None})
    path.write_text(scene.to_toml())


def _run(name: str, arguments: tuple[str, ...], folder: Path) -> dict:
    out = folder / "run"
    environment = dict(os.environ)
    if "empty" in name:
        environment["WARP_CACHE_PATH"] = tempfile.mkdtemp(dir=folder)
    command = [sys.executable, "-m", "warp_origami", "run", *arguments, "--quiet", "--out", str(out)]
    start = time.perf_counter()
    subprocess.run(command, check=True, env=environment)
    seconds = time.perf_counter() - start
    summary = json.loads((out / "summary.json").read_text())
    return {
        "run": name,
        "seconds": round(seconds, 2),
        **{key: summary[key] for key in ("steps_accepted", "steps_rejected", "newton_iterations")},
        "ms": None,
        "other": round(summary["phases"]["other"] / summary["wall_seconds"], 3),
        "energy_gain": f"{summary['energy_gain']:.3g}",
    }


if __name__ == "__main__":
    main()
