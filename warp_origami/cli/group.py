"""The group of commands: how all of them end."""

import os
import sys

import click

from ..errors import InputError
from .exit_codes import FAILED, INTERRUPTED, WRONG_INPUT


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
