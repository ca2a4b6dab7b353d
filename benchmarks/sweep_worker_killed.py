"""A study whose workers are killed: no finished run is lost or made again, the others are resumed, nothing differs.

    python benchmarks/sweep_worker_killed.py [--runs 50] [--kills 5] [--workers 2] [--seed 1] [--dask] [--no-compare]

Starts `warp-origami sweep` on a Latin hypercube of small runs (--dask: on a Dask cluster on this machine) and kills
(SIGKILL) a process that makes runs whenever some more have ended. Then it is interrupted once, as by Ctrl-C, and
started again. In the end all runs are to be done, those that had ended before are to be untouched, and the table is to
be that of a study that was left alone. Prints the counts; exit code 1 if anything is otherwise.
"""

import argparse
import contextlib
import csv
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

STUDY = """
name = "films"
scene = "film.toml"
[sampling]
kind = "latin_hypercube"
count = {runs}
seed = {seed}
[[parameter]]
key = "material.thickness"
range = [1e-4, 1e-3]
scale = "log"
[[parameter]]
key = "load.0.acceleration"
values = [[0.0, 0.0, -9.81], [0.0, 1.0, -9.81], [0.0, 0.0, -1.62]]
[[result]]
name = "lowest (m)"
of = "min(probes.tip.z)"
"""
SCENE = """
name = "film"
[analysis]
kind = "dynamic"
duration = 0.02
[pattern]
kind = "sheet"
width = 0.6
height = 0.6
nx = 2
ny = 2
[material]
density = 1420.0
youngs_modulus = 2.5e9
poisson_ratio = 0.34
thickness = 5e-4
[[support]]
at = { near = [0.0, 0.0] }
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]
[[probe]]
name = "tip"
at = [0.6, 0.6]
"""
WORKER = "warp_origami.study.sweep.worker"
CHANGING = ("wall_seconds", "peak_memory_bytes")


def started(folder: Path, out: str, options: list[str]) -> subprocess.Popen:
    """The command line at work on the study in a folder."""
    command = [sys.executable, "-m", "warp_origami", "sweep", str(folder / "study.toml"), "--quiet"]
    return subprocess.Popen([*command, "--out", str(folder / out), *options], start_new_session=True)


def ended(folder: Path) -> dict[Path, int]:
    """Outcomes of the runs in a folder that have one, and when these were written, ns."""
    found = {}
    for path in folder.glob("runs/*/outcome.json"):
        found[path] = path.stat().st_mtime_ns
    return found


def workers_of(process: psutil.Process) -> list[psutil.Process]:
    """Processes below a process that make runs."""
    found = []
    for child in process.children(recursive=True):
        with contextlib.suppress(psutil.Error):
            found += [child] if WORKER in child.cmdline() else []
    return found


def disturbed(folder: Path, options: list[str], given, parent: psutil.Process | None) -> tuple[int, dict[Path, int]]:
    """Kills workers, then interrupts; how many were killed, and what had ended by then, with the times."""
    chance, out = random.Random(given.seed), folder / "disturbed"
    process, killed, kept = started(folder, out.name, options), 0, {}
    owner = parent or psutil.Process(process.pid)
    marks = [given.runs * (k + 1) // (given.kills + 2) for k in range(given.kills + 1)]
    for k, mark in enumerate(marks):
        while process.poll() is None and len(ended(out)) < mark:
            time.sleep(0.02)
        if process.poll() is not None:
            break
        kept |= ended(out)
        if k == given.kills:
            process.send_signal(signal.SIGINT)
            print(f"interrupted with {len(ended(out))} runs ended: exit code {process.wait()}", flush=True)
            break
        at_work = workers_of(owner)
        while process.poll() is None and not at_work:
            time.sleep(0.02)
            at_work = workers_of(owner)
        if at_work:
            victim = chance.choice(at_work)
            with contextlib.suppress(psutil.Error):
                if parent is not None:  # the worker of Dask, which has started the process of the run
                    victim = victim.parent()
                victim.kill()
                killed += 1
                print(f"killed {victim.pid} with {len(ended(out))} runs ended", flush=True)
    process.wait()
    return killed, kept


def table(folder: Path) -> list[dict[str, str]]:
    """Rows of the table of a study, without what no two studies have in common."""
    with (folder / "sweep.csv").open(newline="", encoding="utf-8") as file:
        return [{key: value for key, value in row.items() if key not in CHANGING} for row in csv.DictReader(file)]


@contextlib.contextmanager
def cluster(given):
    """Options for the command line, and the process that workers are below."""
    if not given.dask:
        yield ["--workers", str(given.workers)], None
        return
    import distributed

    with distributed.LocalCluster(n_workers=given.workers, threads_per_worker=1, dashboard_address=None) as running:
        yield ["--scheduler", running.scheduler_address], psutil.Process()


def main() -> int:
    """Runs what is asked for; exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--dask", action="store_true")
    parser.add_argument("--no-compare", action="store_true")
    given = parser.parse_args()
    print(f"seed {given.seed}")
    with tempfile.TemporaryDirectory() as place, cluster(given) as (options, parent):
        folder = Path(place)
        (folder / "film.toml").write_text(SCENE, encoding="utf-8")
        (folder / "study.toml").write_text(STUDY.format(runs=given.runs, seed=given.seed), encoding="utf-8")
        killed, kept = disturbed(folder, options, given, parent)
        code = started(folder, "disturbed", options).wait()
        found = table(folder / "disturbed")
        done = sum(row["status"] == "done" for row in found)
        again = sum(path.stat().st_mtime_ns != written for path, written in kept.items())
        print(
            f"{given.runs} runs, {killed} workers killed: {done} done, {len(found) - done} not done, exit code {code}"
        )
        print(f"{len(kept)} had ended before, {again} of them were made again")
        different = 0
        if not given.no_compare:
            started(folder, "alone", ["--workers", str(given.workers)]).wait()
            different = sum(a != b for a, b in zip(found, table(folder / "alone"), strict=True))
            print(f"{different} of {len(found)} rows differ from those of a study left alone")
    return 1 if code or done < given.runs or again or different or killed < given.kills else 0


if __name__ == "__main__":
    sys.exit(main())
