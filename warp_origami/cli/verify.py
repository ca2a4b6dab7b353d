"""verify: the verification scenes against exact values."""

import sys
from pathlib import Path

import click

from .exit_codes import FAILED
from .places import check_folder
from .quiet import quiet_warp


@click.command()
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
        check_folder(out)
    quiet_warp()
    from ..study.verification.cases import find_cases
    from ..study.verification.table import HEADING, case_lines

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
    from ..study.verification.files import draw, write_results

    folder.mkdir(parents=True, exist_ok=True)
    write_results(folder, found)
    if found[-1].converges:
        draw(found[-1], folder / f"{Path(found[-1].name).stem}.png")
