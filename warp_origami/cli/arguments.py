"""What several commands take in the same way."""

import click

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
