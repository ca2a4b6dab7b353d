"""Scenes written in Python and their runs, with every accepted state kept."""

from types import SimpleNamespace

import numpy as np

import warp_origami as wo
from warp_origami.clock import PhaseClock
from warp_origami.system import System

GRAVITY = {"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}


class States:
    """Keeps time, q, v and q'' of every accepted state (an Observer)."""

    def __init__(self):
        self.times, self.q, self.v, self.accelerations = [], [], [], []

    def start(self, scene, surface, resumed_at):
        pass

    def phase(self, name):
        pass

    def step(self, record):
        pass

    def frame(self, frame):
        pass

    def save(self):
        pass

    def finish(self, summary):
        pass

    def checkpoint(self, arrays):
        time = float(arrays["kinematics.time"])
        if not self.times or time > self.times[-1]:
            self.times.append(time)
            self.q.append(arrays["kinematics.q"].copy())
            self.v.append(arrays["kinematics.v"].copy())
            self.accelerations.append(arrays["kinematics.acceleration"].copy())


def film(duration, pattern, material=None, **tables):
    """A scene of polyimide film; `pattern` and `material` change single values."""
    return wo.Scene(
        name="film",
        analysis={"kind": "dynamic", "duration": duration},
        pattern={"kind": "sheet", "width": 0.6, "height": 0.6, "nx": 2, "ny": 2} | pattern,
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4}
        | (material or {}),
        **{"output": {"fps": 1.0 / duration, "fields": []}, **tables},
    )


def system_of(scene):
    """The equations of motion of a scene."""
    return System(scene, "cpu", PhaseClock())


def run(scene, **options):
    """What a run gave, and the states after each step: times (k,), q, v and accelerations (k, n, 3)."""
    states = States()
    result = wo.simulate(scene, device="cpu", observers=[states], **options)
    return SimpleNamespace(
        history=result.history,
        probes=result.probes,
        reactions=result.reactions,
        frames=result.frames,
        surface=result.surface,
        summary=result.summary,
        times=np.array(states.times),
        q=np.array(states.q),
        v=np.array(states.v),
        accelerations=np.array(states.accelerations),
    )
