"""The command line.

Warp and USD are imported inside the commands that need them, so that `--help` and `list` answer at once.
"""

import click

from .group import Commands
from .patterns import draw, fold
from .run import report, run
from .scenes import check, list_scenes
from .studies import pareto, sweep
from .verify import verify


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="warp-origami")
def main() -> None:
    """Simulates the deployment of foldable space membranes. Units are SI: m, kg, s, N, Pa, rad.

    SCENE is the name of a bundled scene or the path of a .toml file.
    """


for command in (list_scenes, check, run, report, draw, fold, verify, pareto, sweep):
    main.add_command(command)
