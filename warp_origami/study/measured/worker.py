"""One run of a scene in a process of its own, measured: wall seconds and memory at every frame.

    python -m warp_origami.study.measured.worker FOLDER UNTIL LIMIT CONDITIONS

runs FOLDER/scene.toml up to UNTIL (s, or load factor), keeps the vertices whose numbers are in vertices.npy (-1: none),
and leaves arrays.npz and, last, measurement.json with CONDITIONS (JSON) in it: see Measurement. After LIMIT seconds it
ends with what it has. Time counts from where the imports are done.
"""

import json
import math
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import warp

from warp_origami.clock import PhaseClock
from warp_origami.errors import InputError
from warp_origami.output.files import replacing, write_text
from warp_origami.output.memory import Memory
from warp_origami.scene import load_scene
from warp_origami.solve.records import HISTORY_COLUMNS, Frame, StepRecord
from warp_origami.solve.simulate import simulate
from warp_origami.solve.summary import peak_memory

from ..results import read_value
from .measurement import ARRAYS, SCENE, TOLD, VERTICES


class Meter(Memory):
    """Keeps rows, and of the frames what is compared; ends a run that is out of time or whose parent is gone."""

    def __init__(self, vertices: np.ndarray, started: float, limit: float):
        super().__init__()
        self.vertices, self.started, self.limit = vertices, started, limit
        self.parent = os.getppid()
        self.times, self.seconds, self.processor, self.memory, self.positions = [], [], [], [], []
        self.imports = time.process_time()

    def frame(self, frame: Frame) -> None:
        """Keeps time, wall time, memory and the compared vertices."""
        known = self.vertices >= 0
        positions = np.full((len(self.vertices), 3), np.nan)
        positions[known] = frame.nodes[self.vertices[known]]
        self.times.append(frame.time)
        self.seconds.append(time.perf_counter() - self.started)
        self.processor.append(self.processor_seconds)
        self.memory.append(peak_memory())
        self.positions.append(positions)

    def step(self, record: StepRecord) -> None:
        """Keeps a row."""
        super().step(record)
        if self.out_of_time or os.getppid() != self.parent:
            os.kill(os.getpid(), signal.SIGINT)  # the run then ends after this step and hands out what it has

    @property
    def processor_seconds(self) -> float:
        """Processor time so far, s."""
        return time.process_time() - self.imports

    @property
    def out_of_time(self) -> bool:
        """Whether the limit has passed."""
        return time.perf_counter() - self.started > self.limit


def main(folder: Path, until: float, limit: float, conditions: dict) -> None:
    """Runs and writes."""
    started = time.perf_counter()
    imports = time.time() - psutil.Process().create_time()
    warp.config.log_level = warp.LOG_WARNING
    scene = load_scene(folder / SCENE)
    meter = Meter(np.load(folder / VERTICES), started, limit)
    told = {"conditions": conditions, "until": until, "limit": limit, "imports": imports, "summary": {}, "values": []}
    try:
        # runs side by side have a core each
        summary = simulate(scene, observer=meter, until=until, threads=1, clock=PhaseClock(started))
    except InputError as error:
        _write(folder / TOLD, told | {"status": "refused", "message": str(error)})
        return
    status = "timed out" if summary["status"] == "interrupted" else summary["status"]
    message = summary.get("message", f"stopped after {limit:.0f} s" if status == "timed out" else "")
    if status == "done" and scene.verification is not None and until >= scene.analysis.end:
        told["values"] = [read_value(one.of, meter) / one.over for one in scene.verification.value]
    told["processor_seconds"] = meter.processor_seconds
    history = meter.history
    with replacing(folder / ARRAYS) as path:
        np.savez(
            path,
            times=meter.times,
            seconds=meter.seconds,
            processor=meter.processor,
            memory=meter.memory,
            positions=np.array(meter.positions).reshape(len(meter.times), len(meter.vertices), 3),
            history=np.stack([history[column] for column in HISTORY_COLUMNS], axis=1),
        )
    _write(folder / TOLD, told | {"status": status, "message": message, "summary": summary})


def _write(path: Path, told: dict) -> None:
    write_text(path, json.dumps(_plain(told), indent=1) + "\n")


def _plain(value: object) -> object:
    """As JSON has it: null for numbers that are not finite."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


if __name__ == "__main__":
    main(Path(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]), json.loads(sys.argv[4]))
