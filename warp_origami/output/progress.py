"""The progress bar: time (load factor in statics), step size, Newton iterations, energy balance."""

import sys
import time
from typing import TextIO

import numpy as np
from tqdm import tqdm

from warp_origami.model.submesh import Submesh
from warp_origami.scene import Scene
from warp_origami.solve.records import Frame, StepRecord

LINE_INTERVAL = 10.0
"""Seconds between lines where there is no terminal to draw a bar on."""


class Progress:
    """Shows how a run goes (an Observer): a bar on a terminal, a line now and then elsewhere."""

    def __init__(self, until: float, stream: TextIO | None = None):
        """`until` is where the run ends (s, or a load factor); the stream is the standard error unless given."""
        self.until = until
        self._unit = ""  # of time, with a space; none for the load factor
        self.stream = sys.stderr if stream is None else stream
        self._bar: tqdm | None = None
        self._phase = ""
        self._next_line = 0.0
        self._largest = 0.0
        self._began: tuple[float, float] | None = None  # clock and time at the first record

    def start(self, scene: Scene, surface: Submesh, resumed_at: float | None) -> None:
        """Says what begins."""
        dynamic = scene.analysis.kind == "dynamic"
        self._unit = " s" if dynamic else ""
        begins = scene.name
        if resumed_at is not None:
            begins += f", resumed at {'' if dynamic else 'load factor '}{resumed_at:.4g}{self._unit}"
        self.phase(begins)

    def phase(self, name: str) -> None:
        """Shows what the program is busy with, for example compiling kernels, which takes a while the first time."""
        self._phase = name
        if self._bar is None:
            self._line(f"{name} ...")

    def step(self, record: StepRecord) -> None:
        """Moves on to the time of the record."""
        history = record.history
        text = self._describe(history)
        if not self.stream.isatty():
            now = time.monotonic()
            self._began = self._began or (now, history["time"])
            if now >= self._next_line:
                left = self._left(now, history["time"])
                self._line(f"{history['time']:.4f} of {self.until:g}{self._unit}{left}: {text}")
                self._next_line = now + LINE_INTERVAL
            return
        if self._bar is None:
            form = "{percentage:3.0f}%|{bar}| {n:.4f}/{total:g}{unit} [{elapsed}<{remaining}]{postfix}"
            self._bar = tqdm(total=self.until, unit=self._unit, file=self.stream, bar_format=form, dynamic_ncols=True)
        self._bar.set_postfix_str(text, refresh=False)
        self._bar.update(min(history["time"], self.until) - self._bar.n)

    def _left(self, now: float, reached: float) -> str:
        """How long it takes to the end, at the mean pace so far; nothing before there is one."""
        clock, begin = self._began
        if not begin < reached < self.until:
            return ""
        return f", {tqdm.format_interval((now - clock) / (reached - begin) * (self.until - reached))} left"

    def _describe(self, history: dict[str, float]) -> str:
        # the balance is told relative to the largest energy so far, as in summary.json
        energy = history["kinetic_energy"] + history["strain_energy"] + history["contact_energy"]
        self._largest = max(self._largest, energy)
        error = history["energy_error"] / self._largest if self._largest > 0.0 else 0.0
        return (
            f"step {history['step']:.1e}{self._unit}, Newton {int(history['newton_iterations'])}, "
            f"energy balance {100.0 * error:+.2g} % of the largest energy"
        )

    def frame(self, frame: Frame) -> None:
        """Nothing to show."""

    def checkpoint(self, arrays: dict[str, np.ndarray]) -> None:
        """Nothing to show."""

    def save(self) -> None:
        """Nothing to do."""

    def finish(self, summary: dict) -> None:
        """Ends the bar."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def _line(self, text: str) -> None:
        print(text, file=self.stream, flush=True)
