"""Other programs side by side with this one: wall seconds against error on the swinging and the sagging sheet.

    python benchmarks/peers.py [--only MuJoCo warp_origami] [--scene swinging] [--quick] [--reference]

MuJoCo, Exudyn and Newton are installed into an environment of their own (benchmarks/.peers) by the first run. All runs
follow one another on the same cores. Prints a table and writes results/peers.csv and results/peers.png, a comparison in
part results/peers_part.csv and .png. `--reference` computes anew what positions are held against (some minutes). What
is measured, and with which settings: docs/peers.md.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "peers"))

import cases  # noqa: E402
import environment  # noqa: E402
import table  # noqa: E402
from job import ANSWER  # noqa: E402

RESULTS = HERE / "results"
REFERENCE = RESULTS / "peers_reference.csv"
TIME_LIMIT = 600.0


def main() -> None:
    """Runs what is asked for."""
    options = _options()
    cores = set(options.cores or sorted(os.sched_getaffinity(0))[:2]) if hasattr(os, "sched_setaffinity") else None
    chosen = [case for case in cases.CASES if case.program in options.only and case.job["scene"] in options.scene]
    chosen = [case for case in chosen if case.quick or not options.quick]
    options.environment = options.environment.resolve()
    packages = sorted({cases.PACKAGES[case.program] for case in chosen if case.program in cases.PACKAGES})
    missing = environment.prepare(options.environment, packages)
    if options.reference or not REFERENCE.exists():
        _write_reference(cores)
    reference = np.loadtxt(REFERENCE, delimiter=",", skiprows=1)
    rows = []
    for case in chosen:
        reason = missing.get(cases.PACKAGES.get(case.program))
        answer = {"status": reason} if reason else _run(case, options.environment, cores)
        rows.append(table.row(case, answer, reference))
        print(table.line(rows[-1]), flush=True)
    path = RESULTS / ("peers.csv" if len(chosen) == len(cases.CASES) else "peers_part.csv")
    table.write(rows, path)
    table.plot(rows, path.with_suffix(".png"))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=list(cases.FILES), choices=list(cases.FILES), metavar="NAME")
    parser.add_argument("--scene", nargs="+", default=["swinging", "sagging"], choices=["swinging", "sagging"])
    parser.add_argument("--quick", action="store_true", help="one or two runs a program")
    parser.add_argument("--reference", action="store_true", help="compute the reference anew")
    parser.add_argument("--cores", nargs="+", type=int, help="of all programs [the first two]")
    parser.add_argument("--environment", type=Path, default=HERE / ".peers", help="folder of the peers' environment")
    return parser.parse_args()


def _run(case: cases.Case, folder: Path, cores: set[int] | None) -> dict:
    """The answer of one run in a process of its own."""
    python = environment.interpreter(folder) if case.program in cases.PACKAGES else sys.executable
    return _answer([python, HERE / "peers" / cases.FILES[case.program], json.dumps(case.job)], cores)


def _answer(command: list, cores: set[int] | None) -> dict:
    folder = tempfile.gettempdir()  # MuJoCo writes a log where it runs
    pinned = (lambda: os.sched_setaffinity(0, cores)) if cores else None
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=TIME_LIMIT, cwd=folder, preexec_fn=pinned
        )
    except subprocess.TimeoutExpired:
        return {"status": f"not done after {TIME_LIMIT:g} s"}
    answers = [line for line in done.stdout.splitlines() if line.startswith(ANSWER)]
    if answers:
        return json.loads(answers[-1].removeprefix(ANSWER))
    lines = done.stderr.strip().splitlines()
    return {"status": "failed: " + (lines[-1] if lines else f"exit code {done.returncode}")}


def _write_reference(cores: set[int] | None) -> None:
    print("computing the reference (some minutes)", flush=True)
    answer = _answer([sys.executable, HERE / "peers" / "run_explicit.py", json.dumps(cases.REFERENCE)], cores)
    np.savetxt(REFERENCE, answer["positions"], delimiter=",", header="x,y,z", comments="", fmt="%.7f")


if __name__ == "__main__":
    main()
