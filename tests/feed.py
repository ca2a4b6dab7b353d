"""A bending sheet told to observers as a run would tell it, without the run."""

import json

import numpy as np

import warp_origami as wo
from warp_origami.model.generators.sheet import sheet
from warp_origami.model.submesh import build_submesh
from warp_origami.solve.records import HISTORY_COLUMNS, Frame, StepRecord

PATTERN = sheet(1.0, 0.6, 4, 2, creases_x=(2,))
SURFACE = build_submesh(PATTERN.mesh, 4)
FPS = 20.0


def scene(duration=1.0, **tables):
    """A scene with one support and one probe."""
    return wo.Scene(
        name="bending",
        analysis={"kind": "dynamic", "duration": duration},
        pattern={"kind": "sheet", "width": 1.0, "height": 0.6, "nx": 4, "ny": 2, "creases_x": [2]},
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4},
        support=[{"name": "root", "at": {"near": [0, 0]}}],
        probe=[{"name": "tip", "at": [1.0, 0.3]}],
        **{"output": {"fps": FPS}, **tables},
    )


def bent(flat, time):
    """(n, 3) points of the sheet rolled up to the curvature 3 t, 1/m."""
    curvature = 3.0 * time + 1e-9
    x, y = flat.T
    return np.stack([np.sin(curvature * x) / curvature, y, (1.0 - np.cos(curvature * x)) / curvature], axis=1)


def record(time, step):
    """A row whose numbers have no short decimal form."""
    history = dict.fromkeys(HISTORY_COLUMNS, 0.0) | {"time": time, "step": step, "strain_energy": np.pi * time}
    history |= {"newton_iterations": 3, "kinetic_energy": np.float64(1 / 3), "taut": 1.0}
    return StepRecord(history, {"tip": np.sin(np.arange(9) + time)}, {"root": np.cos(np.arange(6) + time)})


def frame(time):
    """The sheet with a stress that grows along x and with time."""
    fields = {"von_mises": 1e6 * time * SURFACE.flat[:, 0], "state": np.rint(2.0 * SURFACE.flat[:, 0])}
    return Frame(time, bent(SURFACE.flat, time), bent(PATTERN.mesh.vertices, time), fields)


def write_fold(path, angle=None):
    """Two triangles and the crease between them, folded by an angle in degrees or with flat coordinates only."""
    content = {
        "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]],
        "edges_assignment": ["B", "B", "B", "B", "V"],
        "faces_vertices": [[0, 1, 2], [0, 2, 3]],
    }
    if angle is not None:
        content["edges_foldAngle"] = [0, 0, 0, 0, angle]
    path.write_text(json.dumps(content))


def feed(observer, told, until, start=0, status="done", kill=False, **extra):
    """Steps of 1/40 s from number `start` until a time; a frame every second step, a checkpoint every fourth.

    With `kill` it ends without a word, as a killed process does.
    """
    observer.phase("compiling kernels")
    observer.start(told, SURFACE, start / 40.0 if start else None)
    last = round(until * 40)
    for k in range(start + 1 if start else 0, last + 1):
        observer.step(record(k / 40.0, 1 / 40.0 if k else 0.0))
        if k % 2 == 0:
            observer.frame(frame(k / 40.0))
        if k % 4 == 0 or (k == last and not kill):
            observer.checkpoint({"number": np.array(k), "q": bent(PATTERN.mesh.vertices, k / 40.0)})
    summary = {"status": status, "scene": told.name, "energy_loss": np.float64("nan"), **extra}
    if not kill:
        observer.save()
        observer.finish(summary)
    return summary
