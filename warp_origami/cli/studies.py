"""pareto and sweep: many runs of one scene."""

import os
import sys
from pathlib import Path

import click

from ..errors import InputError
from .arguments import check_until, scene_argument, set_option
from .exit_codes import FAILED, INTERRUPTED
from .places import check_folder
from .quiet import quiet_warp


@click.command()
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
    from ..scene import load_scene

    read = load_scene(scene, overrides)
    folder = Path("pareto") / read.name if out is None else out
    check_folder(folder)
    check_until(until, read.analysis)
    from ..study.pareto.measured_study import Request
    from ..study.pareto.plans import study

    def told(line: str) -> None:
        click.echo(line, err=True)

    comparison = study(Request(scene, overrides, folder, budget, until, jobs or os.cpu_count() or 1, told))
    try:
        comparison.run()
    finally:  # also after Ctrl-C
        if comparison.runs:
            _write_pareto(folder, comparison.findings())


def _write_pareto(folder: Path, findings) -> None:
    from ..study.pareto.plot import draw
    from ..study.pareto.table import lines, write_table

    write_table(folder / "pareto.csv", findings)
    draw(findings, folder / "pareto.png")
    click.echo("\n".join(lines(findings)))


@click.command()
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
    from ..study.sweep.document import load_study
    from ..study.sweep.plan import plan
    from ..study.sweep.sweep import Sweep, refuse_folder_of_runs

    read, place = load_study(study)
    folder = Path("sweeps") / read.name if out is None else out
    check_folder(folder)
    refuse_folder_of_runs(folder)
    if scheduler is not None and workers is not None:
        raise InputError("--workers", f"{workers} beside --scheduler", "--workers only for processes on this machine")
    runs = plan(read, place)
    quiet_warp()
    from ..study.sweep.cluster import ClusterWorkers
    from ..study.sweep.local import LocalWorkers, NoWorkers
    from ..study.sweep.progress import Line, report

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
