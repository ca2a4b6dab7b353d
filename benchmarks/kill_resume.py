"""Runs that are killed at random moments and resumed, against runs that are left alone: every number is the same.

    python benchmarks/kill_resume.py [--moments 20] [--operations 60] [--seed 1] [--cases thrown,pulled,...]

Moments: the command line as a process of its own is killed (SIGKILL) at a random time of its whole life, resumed, killed
again while it resumes, and resumed to the end. Operations: a copy of this process, in which everything is imported and
compiled, runs the scene and kills itself just before a random one of its operations on files (a file opened, put in
its place, removed or synchronized, a row written by half); so does the run that resumes it. Compared are the bytes of
the tables, all of the animation, and the summary but for times and memory. Prints every moment and the counts; exit
code 1 if a number differs.
"""

import argparse
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
from collections.abc import Callable
from pathlib import Path

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
    # pulled by a driver whose velocity has kinks, held by multipliers, drawn at every step
    "pulled": _case(
        {"kind": "dynamic", "duration": 0.05},
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
        output={"fps": "steps"},
        probe=[{"name": "crease", "at": [0.3, 0.3]}],
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
    from pxr import Sdf

    found = [name for name in TABLES if (whole / name).read_bytes() != (resumed / name).read_bytes()]
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


class Bomb:
    """Kills this process before its operation number `at` on files in a folder; counts them."""

    def __init__(self, folder: Path, at: int | None):
        self.folder, self.at, self.count = str(folder), at, 0
        self.row = ""

    def install(self) -> None:
        """From now on; there is no way back."""
        from warp_origami.output import files, run_directory

        sys.addaudithook(self._heard)
        fsync, append = os.fsync, files.CsvFile.append

        def counted_fsync(handle: int) -> None:
            self._operation()
            fsync(handle)

        def by_half(table: files.CsvFile, values: list[float]) -> None:
            if self.count + 1 == self.at:
                table._file.write(b"0.12345,0.3")
            self._operation()
            append(table, values)

        os.fsync, files.CsvFile.append = counted_fsync, by_half
        run_directory.SAVING_SHARE = float("inf")  # saves at every step: more places to be killed at

    def _heard(self, event: str, arguments: tuple) -> None:
        if event in ("open", "os.rename", "os.remove") and str(arguments[0]).startswith(self.folder):
            self._operation()

    def _operation(self) -> None:
        self.count += 1
        if self.count == self.at:
            os.kill(os.getpid(), signal.SIGKILL)


def forked(work: Callable[[], None]) -> int:
    """Exit code of a copy of this process that does some work: minus the signal if it was killed."""
    child = os.fork()
    if child == 0:
        try:
            work()
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def simulated(scene, folder: Path, at: int | None, told: Path | None = None) -> None:
    """Runs or resumes a scene as the command line does, and dies at an operation; writes their number to `told`."""
    from warp_origami.output.run_directory import RunDirectory, read_run
    from warp_origami.solve.simulate import simulate

    bomb = Bomb(folder, at)
    bomb.install()
    simulate(scene, RunDirectory(folder), resume=read_run(folder, scene), threads=1)
    if told is not None:
        told.write_text(str(bomb.count))


def at_operations(name: str, moments: int, chance: random.Random, folder: Path) -> Counter:
    """Kills copies of this process at random operations on files, twice each; counts what came of it."""
    import warp

    from warp_origami.scene import load_scene
    from warp_origami.solve.simulate import simulate

    warp.config.log_level = warp.LOG_WARNING
    scene, counts = load_scene(folder / f"{name}.toml"), Counter()
    from warp_origami.output.memory import Memory

    simulate(scene, Memory(), threads=1)  # compiles
    assert forked(lambda: simulated(scene, folder / "whole", None, folder / "count")) == 0
    operations = int((folder / "count").read_text())
    for k in range(moments):
        place = folder / f"operation{k}"
        places = [chance.randint(1, operations) for _ in range(2)]
        codes = [forked(lambda at=at, place=place: simulated(scene, place, at)) for at in (*places, None)]
        found = differences(folder / "whole", place) if codes[-1] == 0 else [f"exit code {codes[-1]}"]
        kills = codes.count(-signal.SIGKILL)
        _tell(name, f"killed at operations {places[0]} and {places[1]} of {operations}", kills, found, counts)
    return counts


def main() -> int:
    """Runs what is asked for; exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, default=20)
    parser.add_argument("--operations", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", default=",".join(CASES))
    given = parser.parse_args()
    import tomli_w

    names, total = given.cases.split(","), Counter()
    print(f"seed {given.seed}")
    for kind, moments in ((at_moments, given.moments), (at_operations, given.operations)):
        for k, name in enumerate(names):
            share = moments // len(names) + (k < moments % len(names))
            if share == 0:
                continue
            with tempfile.TemporaryDirectory() as place:
                folder = Path(place)
                (folder / f"{name}.toml").write_text(tomli_w.dumps(CASES[name]), encoding="utf-8")
                total += kind(name, share, random.Random(f"{given.seed} {name}"), folder)
    print(f"{total['same'] + total['different']} moments, {total['kills']} kills: {total['same']} runs with the same")
    print(f"numbers, {total['different']} with others")
    return 1 if total["different"] else 0


if __name__ == "__main__":
    sys.exit(main())
