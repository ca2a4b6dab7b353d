"""The command line. Exit codes: 0 done, 2 wrong input, 3 the numerics failed, 130 interrupted.

Warp and USD are imported inside the commands that need them, so that `--help` and `list` answer at once.
"""

import contextlib
import math
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import click
import psutil

from .errors import InputError
from .scenes import bundled_scenes

WRONG_INPUT, FAILED, INTERRUPTED = 2, 3, 130
EXIT_CODES = {"done": 0, "failed": FAILED, "interrupted": INTERRUPTED}

scene_argument = click.argument("scene")
set_option = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change one value of the scene, in the unit the scene file has it (SI): material.thickness=1e-4 (m), "
    "driver.0.profile.end=2 (s). May be given several times.",
)


pattern_option = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change one parameter of the pattern, in SI units: strips=5, opening=0.1 (rad); of a scene pattern.strips=5. "
    "May be given several times.",
)


class Commands(click.Group):
    """Turns wrong input and interruption into messages and exit codes."""

    def invoke(self, context: click.Context):
        """Runs a command."""
        try:
            return super().invoke(context)
        except InputError as error:
            click.echo(str(error), err=True)
            sys.exit(WRONG_INPUT)
        except BrokenPipeError:  # whoever read the output, `head` for instance, has seen enough
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        except OSError as error:
            click.echo(f"files: {error}; what was written before stays", err=True)
            sys.exit(FAILED)
        except KeyboardInterrupt:
            click.echo("interrupted", err=True)
            sys.exit(INTERRUPTED)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="warp-origami")
def main() -> None:
    """Simulates the deployment of foldable space membranes. Units are SI: m, kg, s, N, Pa, rad.

    SCENE is the name of a bundled scene or the path of a .toml file.
    """


@main.command("list")
def list_scenes() -> None:
    """List the bundled scenes, one line each."""
    scenes = bundled_scenes()
    width = max(map(len, scenes), default=0)
    for name, (_, line) in scenes.items():
        click.echo(f"{name:<{width}}  {line}".rstrip())


@main.command()
@scene_argument
@set_option
def check(scene: str, overrides: tuple[str, ...]) -> None:
    """Validate SCENE and print what will be modelled, without running."""
    from .scene import load_scene

    read = load_scene(scene, overrides)
    _quiet_warp()
    from .description import describe
    from .solve.linear import choose_solver

    lines = describe(read)
    choose_solver(read.integrator.linear_solver, size=0, kind="definite")  # refuses what is not installed
    width = max(len(label) for label, _ in lines)
    for label, value in lines:
        click.echo(f"{label:<{width}}  {value}")


@main.command()
@scene_argument
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results [runs/<scene>].")
@click.option("--device", metavar="NAME", help="cpu or cuda:0 [cpu, until CUDA has been measured].")
@set_option
@click.option(
    "--until",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="T",
    help="End at time T, s (static: load factor).",
)
@click.option("--resume", is_flag=True, help="Go on from the checkpoint in DIR; without one start anew.")
@click.option(
    "--threads", type=click.IntRange(min=1), metavar="N", help="CPU threads, each on a core of its own [all cores]."
)
@click.option("--quiet", is_flag=True, help="No progress bar.")
def run(
    scene: str,
    out: Path | None,
    device: str | None,
    overrides: tuple[str, ...],
    until: float | None,
    resume: bool,
    threads: int | None,
    quiet: bool,
) -> None:
    """Simulate SCENE and write tables, animation, summary and checkpoint into DIR.

    Without --resume, the results of an earlier run in DIR are replaced.
    """
    from .scene import load_scene

    read = load_scene(scene, overrides)
    folder = Path("runs") / read.name if out is None else out
    _check_folder(folder)
    if until is not None and not math.isfinite(until):
        raise InputError("--until", until, "a time in s")
    end = read.analysis.end if until is None else min(until, read.analysis.end)
    _quiet_warp()
    from .clock import PhaseClock
    from .output.observers import Observers
    from .output.progress import Progress
    from .output.run_directory import RunDirectory, is_finished, read_run
    from .solve.simulate import simulate

    checkpoint = read_run(folder, read) if resume else None
    if resume and is_finished(folder, end):
        if not quiet:
            click.echo(f"{folder} is finished: nothing to do", err=True)
        return
    directory = RunDirectory(folder)
    watchers = [directory] if quiet else [directory, Progress(end)]
    options = {"device": device, "threads": threads}
    with _page_in_any_case(folder):
        summary = simulate(
            read,
            observer=Observers(watchers),
            until=end,
            resume=checkpoint,
            clock=PhaseClock(_process_start()),
            **{name: value for name, value in options.items() if value is not None},
        )
    if directory.report_failure is not None:
        click.echo(f"no report.html: {directory.report_failure}; try `warp-origami report {folder}`", err=True)
    sys.exit(_report(summary, folder, quiet))


@main.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE", help="The page [DIR/report.html]."
)
def report(folder: Path, out: Path | None) -> None:
    """Write the page of the run in DIR, report.html, again.

    It is made from what the run has left there: a finished run, one that goes on, or one that was killed. The page
    opens in any browser, without a network; it says what is missing.
    """
    from .output.report.page import build_report

    path, remarks = build_report(folder, out)
    click.echo("\n".join([str(path), *(f"  {remark}" for remark in remarks)]))


@main.command()
@click.argument("name", required=False)
@click.option("--quick", is_flag=True, help="Coarse meshes only: less than a minute in all.")
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="DIR", help="Also write tables (CSV, JSON) and plots (PNG) here."
)
@click.option("--device", metavar="NAME", help="cpu or cuda:0 [cpu, until CUDA has been measured].")
def verify(name: str | None, quick: bool, out: Path | None, device: str | None) -> None:
    """Run the verification scenes, or the one called NAME, over their meshes and compare with exact values.

    NAME is a verification scene ("drum"), or the path of a scene of your own with a table [verification]. Prints for
    each value what is expected and obtained, the relative error (absolute where 0 is expected), its order, and the
    seconds taken without compilation. Exit code 3 if a value misses its tolerance.
    """
    if out is not None:
        _check_folder(out)
    _quiet_warp()
    from .study.verification.cases import find_cases
    from .study.verification.table import HEADING, case_lines

    cases, found = find_cases(name, device), []
    click.echo(HEADING)
    for case in cases:
        found.append(case.convergence(list(case.levels(quick))))
        click.echo("\n".join(case_lines(found[-1])))
        if out is not None:
            _write_verification(out, found)
    missed = [case.name for case in found if not case.passed]
    click.echo("")
    click.echo(f"missed in {', '.join(missed)}" if missed else "all values are within their tolerances")
    if missed:
        sys.exit(FAILED)


def _write_verification(folder: Path, found: list) -> None:
    """Writes tables of all results so far, and the plot of the last case if its errors have orders."""
    from .study.verification.files import draw, write_results

    folder.mkdir(parents=True, exist_ok=True)
    write_results(folder, found)
    if found[-1].converges:
        draw(found[-1], folder / f"{Path(found[-1].name).stem}.png")


@main.command()
@scene_argument
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results [pareto/<scene>].")
@click.option(
    "--budget",
    type=click.FloatRange(min=0.0, min_open=True),
    default=1080.0,
    show_default=True,
    metavar="SECONDS",
    help="Wall time for everything, s.",
)
@click.option(
    "--until",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="T",
    help="End every run at time T, s (static: load factor).",
)
@set_option
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Runs side by side [the number of cores].")
def pareto(
    scene: str, out: Path | None, budget: float, until: float | None, overrides: tuple[str, ...], jobs: int | None
) -> None:
    """Run SCENE over its settings and compare speed with error.

    Each run is held against exact values if the scene has them, else against the scene's own finest run. Writes
    pareto.csv and pareto.png into DIR, and prints the table with the Pareto front marked. Runs that are in DIR already
    are not repeated.
    """
    from .scene import load_scene

    folder = Path("pareto") / load_scene(scene, overrides).name if out is None else out
    _check_folder(folder)
    from .study.pareto.measured_study import Request
    from .study.pareto.plans import study

    def told(line: str) -> None:
        click.echo(line, err=True)

    comparison = study(Request(scene, overrides, folder, budget, until, jobs or os.cpu_count() or 1, told))
    try:
        comparison.run()
    finally:  # also after Ctrl-C
        if comparison.runs:
            _write_pareto(folder, comparison.findings())


def _write_pareto(folder: Path, findings) -> None:
    from .study.pareto.plot import draw
    from .study.pareto.table import lines, write_table

    write_table(folder / "pareto.csv", findings)
    draw(findings, folder / "pareto.png")
    click.echo("\n".join(lines(findings)))


@main.command()
@click.argument("pattern")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.svg", help="The drawing [<pattern>.svg].")
@pattern_option
def draw(pattern: str, out: Path | None, overrides: tuple[str, ...]) -> None:
    """Draw the crease diagram of PATTERN as SVG: mountains, valleys, boundary, cuts, vertex numbers.

    PATTERN is a generator's name (leaf_in, leaf_out, miura, z_fold, cross_fold, square_twist, sheet, ...; its default
    parameters), the name of a bundled scene, or the path of a .toml scene or a .fold file. Says how it folds, too.
    """
    from .output.crease_diagram import crease_diagram
    from .output.files import write_text
    from .scene.patterns import describe_pattern, load_pattern

    name, read = load_pattern(pattern, overrides)
    path = Path(f"{Path(name).name}.svg") if out is None else out
    _check_file(path, ".svg")
    write_text(path, crease_diagram(read.mesh, name))
    click.echo(f"{path}: {len(read.mesh.vertices)} vertices, {int(read.mesh.faces.max()) + 1} faces")
    for label, value in describe_pattern(read):
        click.echo(f"{label:<13}  {value}")


@main.command()
@click.argument("source")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE.fold",
    help="The file [<pattern>.fold; animation.fold in the folder of a run].",
)
@pattern_option
def fold(source: str, out: Path | None, overrides: tuple[str, ...]) -> None:
    """Write SOURCE as a FOLD 1.2 file: crease pattern, stowed state, layer order; of a run all its frames.

    SOURCE is a pattern, as for draw, or the folder of a run: finished, stopped or killed.
    """
    from .output.fold_run import write_pattern, write_run
    from .scene.patterns import load_pattern

    folder = Path(source)
    if folder.is_dir():
        if overrides:
            raise InputError("--set", " ".join(overrides), "nothing to change in a run")
        path = folder / "animation.fold" if out is None else out
        _check_file(path, ".fold")
        frames = write_run(path, folder)
    else:
        name, read = load_pattern(source, overrides)
        path = Path(f"{Path(name).name}.fold") if out is None else out
        _check_file(path, ".fold")
        if path.exists() and folder.exists() and path.samefile(folder):
            raise InputError("--out", repr(str(path)), "another file than the one that is read")
        frames = write_pattern(path, read, name)
    click.echo(f"{path}: {frames} frames" if frames > 1 else f"{path}: 1 frame")


@main.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results [sweeps/<study>].")
@click.option("--scheduler", metavar="ADDRESS", help="Run on a Dask cluster, for example tcp://host:8786 (extra dask).")
@click.option(
    "--workers", type=click.IntRange(min=1), metavar="N", help="Processes on this machine, a thread each [cores]."
)
@click.option("--quiet", is_flag=True, help="No progress line.")
def sweep(study: Path, out: Path | None, scheduler: str | None, workers: int | None, quiet: bool) -> None:
    """Run a scene over values of its keys, as the file STUDY (.toml) says: a grid, a list, or a Latin hypercube.

    Writes sweep.csv and sweep.png into DIR, and the results of every run into DIR/runs. Started again, it makes only
    what is not done yet. Runs that fail are recorded, the rest goes on. Exit code 3 if none is done, or if some could
    not be brought to an end (out of time, workers lost, no room on the disk).
    """
    from .study.sweep.document import load_study
    from .study.sweep.plan import plan
    from .study.sweep.sweep import Sweep, refuse_folder_of_runs

    read, place = load_study(study)
    folder = Path("sweeps") / read.name if out is None else out
    _check_folder(folder)
    refuse_folder_of_runs(folder)
    if scheduler is not None and workers is not None:
        raise InputError("--workers", f"{workers} beside --scheduler", "--workers only for processes on this machine")
    runs = plan(read, place)
    _quiet_warp()
    from .study.sweep.cluster import ClusterWorkers
    from .study.sweep.local import LocalWorkers, NoWorkers
    from .study.sweep.progress import Line, report

    chosen = LocalWorkers(workers) if scheduler is None else ClusterWorkers(scheduler)
    asked = Sweep(read, runs, folder)
    try:
        with Line(len(runs), quiet) as line:
            asked.run(chosen, line.show)
    except NoWorkers as error:
        click.echo(f"failed: {error}", err=True)
        sys.exit(FAILED)
    except KeyboardInterrupt:
        click.echo(report(asked.progress(), folder, interrupted=True), err=True)
        sys.exit(INTERRUPTED)
    reached = asked.progress()
    well = reached.is_final and "done" in reached.statuses
    if not quiet or not well:
        click.echo(report(reached, folder, interrupted=False), err=True)
    sys.exit(0 if well else FAILED)


def _process_start() -> float:
    """Start of this process on the clock of time.perf_counter, s: wall_seconds counts from there."""
    return time.perf_counter() - (time.time() - psutil.Process().create_time())


@contextlib.contextmanager
def _page_in_any_case(folder: Path) -> Iterator[None]:
    """Where a run ends without its own end (full disk, second Ctrl-C), a page of what there is, if it can be had."""
    from .output.report.page import build_report

    try:
        yield
    except (OSError, KeyboardInterrupt):
        with contextlib.suppress(InputError, OSError):
            build_report(folder)
        raise


def _report(summary: dict, folder: Path, quiet: bool) -> int:
    """Says how a run ended and gives the exit code."""
    status = summary["status"]
    if status != "done" or not quiet:
        reasons = [summary[key] for key in ("message", "advice") if summary.get(key)]
        go_on = ["go on with --resume"] if status == "interrupted" else []
        click.echo("; ".join([f"{status}: results in {folder}", *reasons, *go_on]), err=True)
    return EXIT_CODES[status]


def _check_folder(folder: Path) -> None:
    """Refuses a place where no folder can be, before anything is computed."""
    try:
        existing = next(path for path in [folder, *folder.absolute().parents] if path.exists())
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError("--out", f"{str(folder)[:100]!r} ({reason})", "the path of a folder") from None
    if not existing.is_dir():
        raise InputError("--out", f"{str(existing)!r}, which is a file", "the path of a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError("--out", f"{str(existing)!r}, which cannot be written to", "a folder that can be written to")


def _check_file(path: Path, suffix: str) -> None:
    """Refuses the name of a file that cannot be written, before anything is computed."""
    if path.suffix != suffix:
        raise InputError("--out", repr(str(path)), f"a file name that ends in {suffix}")
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise InputError("--out", repr(str(path)), "a file in a folder that exists")
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        raise InputError("--out", repr(str(path)), "a folder that can be written to")


def _quiet_warp() -> None:
    """Starts Warp without its own messages: the terminal belongs to the progress bar."""
    import warp

    warp.config.log_level = warp.LOG_WARNING
    # the native part writes past Python that there is no CUDA driver, which on a machine without a GPU is no news
    sys.stderr.flush()
    with tempfile.TemporaryFile() as captured, contextlib.ExitStack() as restored:
        terminal = os.dup(2)
        restored.callback(os.close, terminal)
        os.dup2(captured.fileno(), 2)
        restored.callback(os.dup2, terminal, 2)
        warp.init()
        captured.seek(0)
        lines = captured.read().decode(errors="replace").splitlines()
    for line in lines:
        if "Could not find or load the NVIDIA CUDA driver" not in line:
            click.echo(line, err=True)


if __name__ == "__main__":
    main()
