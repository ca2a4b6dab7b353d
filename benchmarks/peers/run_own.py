"""This program: `scenes/swinging_sheet.toml` and `scenes/sagging_sheet.toml` with other settings, on the CPU.

The loop is what the program's own clock counts after set-up and compilation, without output; the total is the whole
call, with kernels that were compiled before. One thread: sheets this small gain nothing from more.
"""

import importlib.metadata
import time

import numpy as np
import warp as wp
from job import run
from scipy.interpolate import LinearNDInterpolator
from sheet import DURATION, ENERGY_SCALE, POINTS, POSITION_TIME, SAG_POINTS, SAMPLE_STEP, Triangles

import warp_origami as origami
from warp_origami.scene.settings import Probe

wp.config.quiet = True


def simulate(job: dict) -> dict:
    """job: scene, set (overrides KEY=VALUE)."""
    scene = _scene(job)
    origami.simulate(scene, device="cpu", until=1e-3 * DURATION[job["scene"]], threads=1)  # compiles
    started, cpu = time.perf_counter(), time.process_time()
    try:
        result = origami.simulate(scene, device="cpu", threads=1)
    except origami.NumericalFailure as failure:
        raise FloatingPointError(str(failure)) from failure
    wall, cpu = time.perf_counter() - started, time.process_time() - cpu
    phases, history = result.summary["phases"], result.history
    setup, output = phases["compile"] + phases["setup"], phases["output"]
    frames = np.array([frame.points for frame in result.frames])
    sheet = Triangles(result.surface.flat, result.surface.triangles)
    swings = job["scene"] == "swinging"
    return {
        "setup_seconds": setup,
        "loop_seconds": wall - setup - output,
        "cpu_seconds": cpu * (1.0 - (setup + output) / wall),
        "total_seconds": wall,
        "phases": phases,
        "steps": len(history["time"]) - 1,
        "iterations": int(result.summary["newton_iterations"]),
        "version": importlib.metadata.version("warp-origami"),
        "peak_strain": max(sheet.peak_strain(points) for points in frames),
        "energy_drift": float(history["energy_error"][-1] / ENERGY_SCALE),
        "positions": _positions(result).tolist() if swings else None,
        "sags": None if swings else _sags(result, frames),
    }


def _scene(job: dict):
    fixed = [f"output.fps={1.0 / SAMPLE_STEP}", "output.fields=[]"]
    scene = origami.load_scene(f"{job['scene']}_sheet", [*fixed, *job["set"]])
    if job["scene"] == "sagging":
        return scene
    return scene.model_copy(update={"probe": tuple(Probe(name=f"p{k}", at=at) for k, at in enumerate(POINTS))})


def _positions(result) -> np.ndarray:
    """(36, 3) at POSITION_TIME, between steps by cubic interpolation with the velocities, m."""
    times = result.history["time"]
    k = int(np.clip(np.searchsorted(times, POSITION_TIME - 1e-9), 1, len(times) - 1))
    h = times[k] - times[k - 1]
    s = (POSITION_TIME - times[k - 1]) / h
    before, after = (np.array([result.probes[f"p{n}"][row] for n in range(len(POINTS))]) for row in (k - 1, k))
    (x0, v0), (x1, v1) = (before[:, :3], before[:, 3:6]), (after[:, :3], after[:, 3:6])
    ends = (1 + 2 * s) * (1 - s) ** 2 * x0 + s**2 * (3 - 2 * s) * x1
    return ends + h * (s * (1 - s) ** 2 * v0 - s**2 * (1 - s) * v1)


def _sags(result, frames: np.ndarray) -> list[float]:
    """Mean deflection at 10, 20, ... ms, m."""
    at = [round(0.01 * k / SAMPLE_STEP) for k in range(1, 11)]
    z = np.moveaxis(frames[at, :, 2], 0, 1)
    return LinearNDInterpolator(result.surface.flat, z)(SAG_POINTS).mean(axis=0).tolist()


if __name__ == "__main__":
    run(simulate)
