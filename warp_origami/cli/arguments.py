"""What several commands take in the same way."""

import math

import click

from ..errors import InputError

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


def check_until(until: float | None, analysis) -> None:
    """Refuses a time that the scene does not reach; `analysis` is the scene's."""
    if until is None:
        return
    if not math.isfinite(until):
        raise InputError("--until", until, "a time in s")
    if until > analysis.end:
        end = f"the end of the scene, {analysis.end:g} s (--set analysis.duration=... moves it)"
        raise InputError("--until", f"{until:g}", f"at most {end if analysis.kind == 'dynamic' else 'load factor 1'}")
