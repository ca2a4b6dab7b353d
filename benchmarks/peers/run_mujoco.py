"""MuJoCo: a flex of triangles with `elasticity elastic2d="stretch"`, explicit (semi-implicit Euler) or implicit steps.

https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-flexcomp. A flexcomp gives every vertex the same mass;
here each has a third of its triangles, without which the sheet is heavier at its edges. Contact is off.
"""

import mujoco
import numpy as np
from job import Loop, run
from sheet import AREAL_MASS, DURATION, GRAVITY, POISSON, SAMPLE_STEP, SIDE, THICKNESS, YOUNG, Grid, Recorder

MODEL = """<mujoco>
<option timestep="{step}" gravity="0 0 -{gravity}" integrator="{integrator}"><flag contact="disable"/></option>
<size memory="200M"/>
<worldbody><flexcomp name="sheet" type="grid" dim="2" count="{columns} {rows} 1" spacing="{dx} {dy} 1" mass="{mass}"
radius="1e-4" pos="{middle} {middle} 0"><contact selfcollide="none" contype="0" conaffinity="0"/>
<edge equality="false" damping="0"/>
<elasticity young="{young}" poisson="{poisson}" thickness="{thickness}" damping="0" elastic2d="stretch"/>
{pins}</flexcomp></worldbody></mujoco>"""


def simulate(job: dict) -> dict:
    """job: scene, nx, ny, step (s), integrator (Euler, implicitfast, ...)."""
    loop = Loop()
    grid = Grid(job["nx"], job["ny"])
    per_sample = round(SAMPLE_STEP / job["step"])
    model = mujoco.MjModel.from_xml_string(_xml(job, SAMPLE_STEP / per_sample))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    order = np.lexsort((data.flexvert_xpos[:, 1].round(9), data.flexvert_xpos[:, 0].round(9)))
    number = np.argsort(order)  # of MuJoCo's vertices in the grid
    recorder = Recorder(grid, number[model.flex_elem.reshape(-1, 3)])
    _spread_mass(model, data, recorder.elements.masses[number])
    body = model.flex_vertbodyid[order]
    first = np.where(grid.held(job["scene"]), -1, model.body_dofadr[body])
    lag = (
        0.5 * SAMPLE_STEP / per_sample if job.get("integrator", "Euler") == "Euler" else 0.0
    )  # v is half a step behind q
    for sample in range(round(DURATION[job["scene"]] / SAMPLE_STEP) + 1):
        if sample:
            with loop:
                mujoco.mj_step(model, data, per_sample)
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            raise FloatingPointError(f"unstable at {sample * SAMPLE_STEP:.3f} s")
        mujoco.mj_forward(model, data)
        now = data.qvel + lag * data.qacc if sample else data.qvel
        v = np.where((first >= 0)[:, None], now[np.maximum(first, 0)[:, None] + np.arange(3)], 0.0)
        recorder.add(sample, data.flexvert_xpos[order], v)
    steps = per_sample * round(DURATION[job["scene"]] / SAMPLE_STEP)
    return {**recorder.result(), **loop.result(), "steps": steps, "unknowns": model.nv, "version": mujoco.__version__}


def _xml(job: dict, step: float) -> str:
    nx, ny = job["nx"], job["ny"]
    ranges = [(0, 0, 0, ny)]
    if job["scene"] == "sagging":
        ranges += [(nx, 0, nx, ny), (0, 0, nx, 0), (0, ny, nx, ny)]
    return MODEL.format(
        step=step,
        gravity=GRAVITY,
        integrator=job.get("integrator", "Euler"),
        columns=nx + 1,
        rows=ny + 1,
        dx=SIDE / nx,
        dy=SIDE / ny,
        mass=AREAL_MASS * SIDE**2,
        middle=0.5 * SIDE,
        young=YOUNG,
        poisson=POISSON,
        thickness=THICKNESS,
        pins="".join(f'<pin gridrange="{a} {b} {c} {d}"/>' for a, b, c, d in ranges),
    )


def _spread_mass(model, data, masses: np.ndarray) -> None:
    """Gives every vertex the mass (n,) of its triangles, kg."""
    for vertex, body in enumerate(model.flex_vertbodyid):
        if body > 0:
            model.body_mass[body] = masses[vertex]
    mujoco.mj_setConst(model, data)
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)


if __name__ == "__main__":
    run(simulate)
