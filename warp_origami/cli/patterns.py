"""draw and fold: crease diagrams as SVG, patterns and runs as FOLD."""

from pathlib import Path

import click

from ..errors import InputError
from .arguments import pattern_option
from .places import check_file


@click.command()
@click.argument("pattern")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.svg", help="The drawing [<pattern>.svg].")
@pattern_option
def draw(pattern: str, out: Path | None, overrides: tuple[str, ...]) -> None:
    """Draw the crease diagram of PATTERN as SVG: mountains, valleys, boundary, cuts, vertex numbers.

    PATTERN is a generator's name (leaf_in, leaf_out, miura, z_fold, cross_fold, square_twist, sheet, ...; its default
    parameters), the name of a bundled scene, or the path of a .toml scene or a .fold file. Says how it folds, too.
    """
    from ..output.crease_diagram import crease_diagram
    from ..output.files import write_text
    from ..scene.patterns import describe_pattern, load_pattern

    name, read = load_pattern(pattern, overrides)
    path = Path(f"{Path(name).name}.svg") if out is None else out
    check_file(path, ".svg")
    write_text(path, crease_diagram(read.mesh, name))
    click.echo(f"{path}: {len(read.mesh.vertices)} vertices, {int(read.mesh.faces.max()) + 1} faces")
    for label, value in describe_pattern(read):
        click.echo(f"{label:<13}  {value}")


@click.command()
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
    from ..output.fold_run import write_pattern, write_run
    from ..scene.patterns import load_pattern

    folder = Path(source)
    if folder.is_dir():
        if overrides:
            raise InputError("--set", " ".join(overrides), "nothing to change in a run")
        path = folder / "animation.fold" if out is None else out
        check_file(path, ".fold")
        frames = write_run(path, folder)
    else:
        name, read = load_pattern(source, overrides)
        path = Path(f"{Path(name).name}.fold") if out is None else out
        check_file(path, ".fold")
        if path.exists() and (out is None or (folder.exists() and path.samefile(folder))):
            # a scene mine.toml is likely to have its pattern in mine.fold
            raise InputError("--out", f"{str(path)!r}, which exists", "the name of a new file, or of one to replace")
        frames = write_pattern(path, read, name)
    click.echo(f"{path}: {frames} frames" if frames > 1 else f"{path}: 1 frame")
