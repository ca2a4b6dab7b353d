"""How far a study is, on a line of the terminal."""

import sys
import time
from pathlib import Path

from tqdm import tqdm

from .sweep import PLOT, TABLE, Progress

LINE_INTERVAL = 10.0
"""Seconds between lines where there is no terminal to draw a bar on."""


class Line:
    """A bar on a terminal, a line now and then elsewhere; nothing where it is to be quiet."""

    def __init__(self, runs: int, quiet: bool):
        self._bar = None
        self._plain = not quiet and not sys.stderr.isatty()
        self._next = 0.0
        if not quiet and not self._plain:
            form = "{percentage:3.0f}%|{bar}| {n} of {total} runs [{elapsed}<{remaining}]{postfix}"
            self._bar = tqdm(total=runs, file=sys.stderr, bar_format=form, dynamic_ncols=True)

    def __enter__(self) -> "Line":
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def show(self, progress: Progress) -> None:
        """Shows how far the study is."""
        if self._bar is not None:
            self._bar.set_postfix_str(_counts(progress), refresh=False)
            self._bar.update(progress.ended - self._bar.n)
        elif self._plain and (time.monotonic() >= self._next or progress.ended == progress.runs):
            print(f"{progress.ended} of {progress.runs} runs: {_counts(progress)}", file=sys.stderr, flush=True)
            self._next = time.monotonic() + LINE_INTERVAL


def _counts(progress: Progress) -> str:
    counts = [f"{count} {status}" for status, count in sorted(progress.statuses.items())]
    return ", ".join([*counts, *([f"{progress.kept} kept from before"] if progress.kept else [])])


def report(progress: Progress, folder: Path, interrupted: bool) -> str:
    """What is told at the end."""
    parts = [f"{'interrupted' if interrupted else 'ended'}: {_counts(progress)}"]
    parts.append(f"{folder / TABLE}, {folder / PLOT}")
    if not progress.is_final:
        parts.append("the same command goes on")
    return "; ".join(parts)
