"""list and check: which scenes there are, and what one of them models."""

import click

from ..scenes import bundled_scenes
from .arguments import scene_argument, set_option
from .quiet import quiet_warp


@click.command("list")
def list_scenes() -> None:
    """List the bundled scenes, one line each."""
    scenes = bundled_scenes()
    width = max(map(len, scenes), default=0)
    for name, (_, line) in scenes.items():
        click.echo(f"{name:<{width}}  {line}".rstrip())


@click.command()
@scene_argument
@set_option
def check(scene: str, overrides: tuple[str, ...]) -> None:
    """Validate SCENE and print what will be modelled, without running."""
    from ..scene import load_scene

    read = load_scene(scene, overrides)
    quiet_warp()
    from ..description import describe
    from ..solve.linear import choose_solver

    lines = describe(read)
    choose_solver(read.integrator.linear_solver, size=0, kind="definite")  # refuses what is not installed
    width = max(len(label) for label, _ in lines)
    for label, value in lines:
        click.echo(f"{label:<{width}}  {value}")
