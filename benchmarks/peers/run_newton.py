"""Newton: cloth of triangles with the VBD solver (vertex block descent), stable neo-Hookean, single precision.

https://newton-physics.github.io/newton/latest/api/newton_solvers.html. tri_ke and tri_ka are the Lame constants of
plane stress times the thickness, so that small strains have the stiffness of the sheet. No bending, damping or contact.
A millisecond of steps is recorded as a graph where Warp can do so on this device.
"""

import newton
import numpy as np
import warp as wp
from job import Loop, run
from sheet import AREAL_MASS, DURATION, GRAVITY, POISSON, SAMPLE_STEP, THICKNESS, YOUNG, Grid, Recorder


def simulate(job: dict) -> dict:
    """job: scene, nx, ny, step (s), iterations."""
    loop = Loop()
    wp.config.quiet = True
    grid = Grid(job["nx"], job["ny"])
    recorder = Recorder(grid, grid.triangles)
    builder = newton.ModelBuilder(gravity=wp.vec3(0.0, 0.0, -GRAVITY))
    builder.add_cloth_mesh(
        pos=wp.vec3(0.0),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(0.0),
        vertices=[wp.vec3(x, y, 0.0) for x, y in grid.flat],
        indices=grid.triangles.ravel().tolist(),
        density=AREAL_MASS,
        tri_ke=YOUNG * THICKNESS / (2.0 * (1.0 + POISSON)),
        tri_ka=YOUNG * THICKNESS * POISSON / (1.0 - POISSON**2),
        tri_kd=0.0,
        edge_ke=0.0,
        edge_kd=0.0,
        particle_radius=1e-4,
    )
    for vertex in np.flatnonzero(grid.held(job["scene"])):
        builder.particle_mass[vertex] = 0.0
        builder.particle_flags[vertex] = builder.particle_flags[vertex] & ~int(newton.ParticleFlags.ACTIVE)
    builder.color()
    model = builder.finalize(device="cpu")
    solver = newton.solvers.SolverVBD(model, iterations=job["iterations"], particle_enable_self_contact=False)
    states = [model.state(), model.state()]
    control = model.control()
    per_sample = 2 * max(1, round(0.5 * SAMPLE_STEP / job["step"]))  # even: the states are back in their places
    samples = round(DURATION[job["scene"]] / SAMPLE_STEP)
    if job["step"] > SAMPLE_STEP / 2:
        raise ValueError("step: at most half a millisecond")

    def advance():
        for _ in range(per_sample):
            states[0].clear_forces()
            solver.step(states[0], states[1], control, None, SAMPLE_STEP / per_sample)
            states.reverse()

    graph = _graph(advance, states)
    for sample in range(samples + 1):
        if sample:
            with loop:
                if graph is None:
                    advance()
                else:
                    wp.capture_launch(graph)
                wp.synchronize()
        q, v = states[0].particle_q.numpy().astype(float), states[0].particle_qd.numpy().astype(float)
        recorder.add(sample, q, v)
    return {
        **recorder.result(),
        **loop.result(),
        "steps": per_sample * samples,
        "unknowns": int(3 * np.sum(~grid.held(job["scene"]))),
        "version": newton.__version__,
        "graph": graph is not None,
    }


def _graph(advance, states):
    """A recorded millisecond, None where it cannot be recorded; the states are as before."""
    kept = [(state.particle_q.numpy(), state.particle_qd.numpy()) for state in states]
    advance()  # compiles
    try:
        with wp.ScopedCapture(device="cpu") as capture:
            advance()
        graph = capture.graph
    except Exception as error:  # whatever this version cannot record
        print(f"no graph: {error}")
        graph = None
    for state, (q, v) in zip(states, kept, strict=True):
        state.particle_q.assign(q)
        state.particle_qd.assign(v)
    return graph


if __name__ == "__main__":
    run(simulate)
