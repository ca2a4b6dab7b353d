"""Simulating from Python."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .errors import NumericalFailure
from .model.submesh import Submesh
from .output.memory import Memory
from .output.observers import Observers
from .scene import Scene
from .solve.records import Frame, Observer
from .solve.simulate import simulate as run


@dataclass(frozen=True)
class Run:
    """What a simulation gave.

    Attributes:
        history: column of history.csv -> (n,) values, a row for the initial state and each accepted step.
        probes: name of a probe -> (n, 9) position (m), velocity (m/s), von Mises and principal stresses (Pa).
        reactions: name of a support or driver -> (n, 6) force (N) and moment about the origin (N m) on the sheet.
        spin: column of spin.csv -> (n,) rate (rad/s), moment of inertia (kg m^2) and angular momentum (N m s); empty
            for a scene without hub and initial spin.
        frames: frames of the animation, in order of time.
        surface: the drawn triangles, whose points the frames hold.
        summary: content of summary.json.
    """

    history: dict[str, np.ndarray]
    probes: dict[str, np.ndarray]
    reactions: dict[str, np.ndarray]
    spin: dict[str, np.ndarray]
    frames: list[Frame]
    surface: Submesh
    summary: dict


def simulate(
    scene: Scene,
    device: str | None = None,
    until: float | None = None,
    observers: Sequence[Observer] = (),
    threads: int | None = None,
) -> Run:
    """Simulates a scene and keeps everything in memory.

    Args:
        scene: from load_scene or made with Scene(...).
        device: "cpu" (also for None) or "cuda:0".
        until: end earlier than the scene does, at this time (s) or load factor.
        observers: told in addition about every step and frame, for example output.run_directory.RunDirectory(path).
        threads: of the CPU, each on a core of its own (None: all cores); results do not depend on their number,
            but for round-off where PARDISO is used.

    Raises:
        InputError: the scene cannot be run.
        NumericalFailure: the numerics failed; its `result` is the run up to then.
    """
    memory = Memory()
    everyone = Observers([memory, *observers])
    summary = run(scene, device=device, until=until, observer=everyone, resume=None, threads=threads)
    result = Run(memory.history, memory.probes, memory.reactions, memory.spin, memory.frames, memory.surface, summary)
    if summary["status"] == "failed":
        parts = [summary.get(key) for key in ("message", "advice")]
        raise NumericalFailure(". ".join(part for part in parts if part) or "the numerics failed", result)
    return result
