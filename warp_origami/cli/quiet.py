"""Warp without its own messages."""

import contextlib
import os
import sys
import tempfile

import click


def quiet_warp() -> None:
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
