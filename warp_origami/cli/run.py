"""run and report: simulate a scene, and write the page of a run."""

import contextlib
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import click
import psutil

from ..errors import InputError
from .arguments import check_until, scene_argument, set_option
from .exit_codes import FAILED, INTERRUPTED
from .places import check_file, check_folder
from .quiet import quiet_warp

EXIT_CODES = {"done": 0, "failed": FAILED, "interrupted": INTERRUPTED}


@click.command()
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
    from ..scene import load_scene

    read = load_scene(scene, overrides)
    folder = Path("runs") / read.name if out is None else out
    check_folder(folder)
    check_until(until, read.analysis)
    end = read.analysis.end if until is None else until
    quiet_warp()
    from ..clock import PhaseClock
    from ..output.observers import Observers
    from ..output.progress import Progress
    from ..output.run_directory import RunDirectory, is_finished, read_run
    from ..solve.simulate import simulate

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
    sys.exit(_report(summary, folder, quiet, directory.report_failure is None))


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE", help="The page [DIR/report.html]."
)
def report(folder: Path, out: Path | None) -> None:
    """Write the page of the run in DIR, report.html, again.

    It is made from what the run has left there: a finished run, one that goes on, or one that was killed. The page
    opens in any browser, without a network; it says what is missing.
    """
    from ..output.report.page import build_report

    if out is not None:
        check_file(out, ".html")
    path, remarks = build_report(folder, out)
    click.echo("\n".join([str(path), *(f"  {remark}" for remark in remarks)]))


def _process_start() -> float:
    """Start of this process on the clock of time.perf_counter, s: wall_seconds counts from there."""
    return time.perf_counter() - (time.time() - psutil.Process().create_time())


@contextlib.contextmanager
def _page_in_any_case(folder: Path) -> Iterator[None]:
    """Where a run ends without its own end (full disk, second Ctrl-C), a page of what there is, if it can be had."""
    from ..output.report.page import build_report

    try:
        yield
    except (OSError, KeyboardInterrupt):
        with contextlib.suppress(InputError, OSError):
            build_report(folder)
        raise


def _report(summary: dict, folder: Path, quiet: bool, has_page: bool) -> int:
    """Says how a run ended and where its page is, and gives the exit code."""
    from ..output.report.page import NAME

    status = summary["status"]
    if status != "done" or not quiet:
        reasons = [summary[key] for key in ("message", "advice") if summary.get(key)]
        go_on = ["go on with --resume"] if status == "interrupted" else []
        results = f"results in {folder} (open {folder / NAME})" if has_page else f"results in {folder}"
        click.echo("; ".join([f"{status}: {results}", *reasons, *go_on]), err=True)
    return EXIT_CODES[status]
