"""Runs that are killed at random moments and resumed, against runs that are left alone: every number is the same.

    python benchmarks/kill_resume.py [--moments 20] [--operations 40] [--full 20] [--seed 1] [--cases thrown,...]

Moments: the command line as a process of its own is killed (SIGKILL) at a random time of its life, resumed, killed
again while it resumes, and resumed to the end. Operations: a copy of this process, in which everything is imported and
compiled, runs the scene and kills itself just before a random one of its operations on files (a file opened, put in
its place, removed or synchronized, a row written by half); so does the run that resumes it. Full: from a random one of
these operations on the disk is full; the run is to end with exit code 3, one line, and files that can be read, and goes
on when there is room. Compared are the bytes of the tables, all of the animation, and the summary but for times and
memory. Prints every moment and the counts; exit code 1 if anything is otherwise.
"""

import argparse
import errno
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import numpy as np
import tomli_w
import warp
from pxr import Sdf, Usd

from warp_origami.cli import main as command
from warp_origami.output.memory import Memory
from warp_origami.scene import load_scene
from warp_origami.solve.simulate import simulate

FILM = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4}
LEFT, RIGHT = {"box": [[0.0, 0.0], [0.0, 0.6]]}, {"box": [[0.6, 0.0], [0.6, 0.6]]}


def _case(kind: dict, pattern: dict, **tables) -> dict:
    sheet = {"kind": "sheet", "width": 0.6, "height": 0.6, "nx": 2, "ny": 2} | pattern
    return {"name": "case", "analysis": kind, "pattern": sheet, "material": FILM, **tables}


CASES = {
    # a fold thrown shut, its panels rub and bounce
    "thrown": _case(
        {"kind": "dynamic", "duration": 0.02},
        {"creases_x": [1], "opening": 0.1},
        load=[{"kind": "initial_velocity", "value": [2.0, 0.3, 0.0], "at": LEFT}],
        support=[{"name": "corner", "at": {"near": [0.6, 0.0]}}],
        contact={"method": "mixed", "friction": 0.3},
        integrator={"tolerance": 1e-5},
        output={"fps": 2000, "fields": ["contact_pressure", "von_mises"]},
        probe=[{"name": "edge", "at": [0.0, 0.3]}],
    ),
    # pulled by a driver whose velocity has kinks, held by multipliers
    "pulled": _case(
        {"kind": "dynamic", "duration": 0.1},
        {"creases_x": [1], "opening": 2.4},
        support=[{"name": "held", "at": LEFT, "fix": "xz"}],
        driver=[
            {
                "name": "pulled",
                "at": RIGHT,
                "axes": "xz",
                "translate_to": "deployed",
                "profile": {"kind": "trapezoid", "end": 0.04},
            }
        ],
        integrator={"constraints": "multipliers"},
        output={"fps": 300},
        probe=[{"name": "crease", "at": [0.3, 0.3]}],
    ),
    # a fold with a spring, spun by the hub that holds its crease
    "spun": _case(
        {"kind": "dynamic", "duration": 0.2},
        {"creases_x": [1], "opening": 2.0},
        hub={"at": {"box": [[0.3, 0.0], [0.3, 0.6]]}, "mass": 0.2, "axial_inertia": 0.01, "axis": [0.0, 1.0, 0.0]},
        crease=[{"stiffness": 0.05, "rest_angle": 1.0}],
        mass=[{"at": {"near": [0.6, 0.6]}, "value": 0.05}],
        load=[{"kind": "initial_spin", "rate": 4.0, "axis": [0.0, 1.0, 0.0], "centre": [0.3, 0.3, 0.0]}],
        output={"fps": 200},
    ),
    "blown": _case(
        {"kind": "static", "load_steps": 12},
        {"nx": 4, "ny": 4},
        support=[{"name": "rim", "at": {"boundary": True}}],
        load=[{"kind": "pressure", "value": 2e3}],
        probe=[{"name": "middle", "at": [0.3, 0.3]}],
    ),
    "drummed": _case(
        {"kind": "modal", "count": 6, "load_steps": 8},
        {"nx": 4, "ny": 4, "initial": {"stretch": [1.001, 1.001]}},
        support=[{"name": "rim", "at": {"boundary": True}}],
        load=[{"kind": "pressure", "value": 1e3}],
    ),
}
TABLES = ("history.csv", "probes.csv", "reactions.csv", "scene.toml")
CHANGING = ("wall_seconds", "phases", "peak_memory_bytes")
"""Entries of the summary that no two runs have in common."""


def differences(whole: Path, resumed: Path) -> list[str]:
    """Names of the results in which two finished runs differ."""
    tables = (*TABLES, "spin.csv") if (whole / "spin.csv").exists() else TABLES
    found = [name for name in tables if (whole / name).read_bytes() != (resumed / name).read_bytes()]
    layers = [Sdf.Layer.OpenAsAnonymous(str(folder / "animation.usdc")) for folder in (whole, resumed)]
    if layers[0].ExportToString() != layers[1].ExportToString():
        found.append("animation.usdc")
    numbers = []
    for folder in (whole, resumed):
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        numbers.append({key: value for key, value in summary.items() if key not in CHANGING})
    return found + ([] if numbers[0] == numbers[1] else ["summary.json"])


def killed_process(arguments: list[str], seconds: float | None) -> int:
    """Exit code of the command line, killed after so many seconds of wall time if it has not ended by then."""
    process = subprocess.Popen([sys.executable, "-m", "warp_origami", *arguments])
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        return process.wait()


def at_moments(name: str, moments: int, chance: random.Random, folder: Path) -> Counter:
    """Kills the command line at random times, twice each; counts what came of it."""
    scene, counts = folder / f"{name}.toml", Counter()
    common = ["run", str(scene), "--threads", "1", "--quiet", "--out"]
    killed_process([*common, str(folder / "warm")], None)
    began = time.monotonic()
    assert killed_process([*common, str(folder / "whole")], None) == 0
    life = time.monotonic() - began
    for k in range(moments):
        run = [*common, str(folder / f"moment{k}"), "--resume"]
        times = [life * chance.random() for _ in range(2)]
        kills = sum(killed_process(run, seconds) == -signal.SIGKILL for seconds in times)
        ended = killed_process(run, None)
        found = differences(folder / "whole", folder / f"moment{k}") if ended == 0 else [f"exit code {ended}"]
        _tell(name, f"killed at {times[0]:.2f} and {times[1]:.2f} of {life:.2f} s", kills, found, counts)
    return counts


def _tell(name: str, moment: str, kills: int, found: list[str], counts: Counter) -> None:
    print(f"{name}: {moment}: {', '.join(found) + ' differs' if found else 'the same numbers'}", flush=True)
    counts["different" if found else "same"] += 1
    counts["kills"] += kills


class Fault:
    """Kills this process before its operation number `at` on the files of a folder, or fills the disk then."""

    def __init__(self, folder: Path, at: int | None, full: bool):
        self.folder, self.at, self.full, self.count = str(folder), at, full, 0

    def install(self) -> None:
        """From now on; there is no way back."""
        from warp_origami.output import files, run_directory

        sys.addaudithook(self._heard)
        fsync, append = os.fsync, files.CsvFile.append

        def counted_fsync(handle: int) -> None:
            self._operation()
            fsync(handle)

        def by_half(table: files.CsvFile, values: list[float]) -> None:
            if self.count + 1 == self.at and not self.full:
                table._file.write(b"0.12345,0.3")
            self._operation()
            append(table, values)

        os.fsync, files.CsvFile.append = counted_fsync, by_half
        run_directory.SAVING_SHARE = float("inf")  # saves at every step: more places to fail at

    def _heard(self, event: str, arguments: tuple) -> None:
        if event not in ("open", "os.rename", "os.remove") or not str(arguments[0]).startswith(self.folder):
            return
        writes = event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR)
        if writes or not self.full:
            self._operation()

    def _operation(self) -> None:
        self.count += 1
        if self.at is None or self.count < self.at:
            return
        if self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        os.kill(os.getpid(), signal.SIGKILL)


def forked(scene: Path, folder: Path, at: int | None = None, full: bool = False) -> tuple[int, str, int]:
    """Runs or resumes a scene by the command line in a copy of this process, with a fault at an operation.

    Returns its exit code (minus the signal if it was killed), what it said, and how many operations there were.
    """
    with tempfile.TemporaryDirectory() as place:
        said, count = Path(place, "said"), Path(place, "count")
        child = os.fork()
        if child == 0:
            os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT), 2)
            code, fault = 1, Fault(folder, at, full)
            try:
                fault.install()
                command.main(["run", str(scene), "--out", str(folder), "--resume", "--threads", "1", "--quiet"])
            except SystemExit as ended:
                code = ended.code
            except BaseException:
                traceback.print_exc()
            count.write_text(str(fault.count))
            os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        operations = int(count.read_text()) if count.exists() else 0
        return code, said.read_text(encoding="utf-8"), operations


def at_operations(name: str, moments: int, chance: random.Random, folder: Path) -> Counter:
    """Kills copies of this process at random operations on files, twice each; counts what came of it."""
    scene, counts = folder / f"{name}.toml", Counter()
    operations = _prepared(scene, folder, full=False)
    for k in range(moments):
        place = folder / f"operation{k}"
        places = [chance.randint(1, operations) for _ in range(2)]
        codes = [forked(scene, place, at)[0] for at in (*places, None)]
        found = differences(folder / "whole", place) if codes[-1] == 0 else [f"exit code {codes[-1]}"]
        kills = codes.count(-signal.SIGKILL)
        _tell(name, f"killed at operations {places[0]} and {places[1]} of {operations}", kills, found, counts)
    return counts


def at_full_disk(name: str, moments: int, chance: random.Random, folder: Path) -> Counter:
    """Fills the disk at random operations on files, and goes on when there is room; counts what came of it."""
    scene, counts = folder / f"{name}.toml", Counter()
    operations = _prepared(scene, folder, full=True)
    for k in range(moments):
        place, at = folder / f"full{k}", chance.randint(1, operations)
        code, said, _ = forked(scene, place, at, full=True)
        found = [] if (code, said.count("\n")) == (3, 1) and os.strerror(errno.ENOSPC) in said else [f"{code}: {said}"]
        found += unreadable(place)
        code = forked(scene, place)[0]
        found += differences(folder / "whole", place) if code == 0 else [f"exit code {code}"]
        _tell(name, f"the disk was full from operation {at} of {operations} on", 0, found, counts)
    return counts


def unreadable(folder: Path) -> list[str]:
    """Names of the files of a run that has ended anyhow which cannot be read."""
    found = []
    for path in sorted(folder.iterdir()):
        lines = path.read_text(encoding="utf-8").split("\n") if path.suffix == ".csv" else [""]
        if lines.pop() or len({line.count(",") for line in lines}) > 1:
            found.append(path.name)
        if path.suffix == ".usdc":
            stage = Usd.Stage.Open(str(path))
            found += [] if stage.GetDefaultPrim() else [path.name]
        if path.suffix == ".json":
            json.loads(path.read_text(encoding="utf-8"))
        if path.suffix == ".npz":
            np.load(path).close()
        if "partial" in path.name:
            found.append(path.name)
    return found


def _prepared(scene: Path, folder: Path, full: bool) -> int:
    """Runs the scene as a whole; how many operations on files there were."""
    simulate(load_scene(scene), Memory(), threads=1)  # what it compiles, the copies of this process have
    code, said, operations = forked(scene, folder / "whole", full=full)
    assert code == 0, said
    return operations


def main() -> int:
    """Runs what is asked for; exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, default=20)
    parser.add_argument("--operations", type=int, default=40)
    parser.add_argument("--full", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", default=",".join(CASES))
    given = parser.parse_args()
    warp.config.log_level = warp.LOG_WARNING
    names, total = given.cases.split(","), Counter()
    print(f"seed {given.seed}")
    parts = ((at_moments, given.moments), (at_operations, given.operations), (at_full_disk, given.full))
    for kind, moments in parts:
        for k, name in enumerate(names):
            share = moments // len(names) + (k < moments % len(names))
            if share == 0:
                continue
            with tempfile.TemporaryDirectory() as place:
                folder = Path(place)
                (folder / f"{name}.toml").write_text(tomli_w.dumps(CASES[name]), encoding="utf-8")
                total += kind(name, share, random.Random(f"{given.seed} {name}"), folder)
    moments = total["same"] + total["different"]
    print(f"{moments} moments, {total['kills']} kills: {total['same']} the same, {total['different']} different")
    return 1 if total["different"] else 0


if __name__ == "__main__":
    sys.exit(main())
