"""Reference: triangles with linear displacements, St. Venant-Kirchhoff, lumped mass, velocity Verlet; NumPy and SciPy.

Written for this comparison and sharing nothing with any of the programs; second order in space and time.
"""

import numpy as np
from job import Loop, run
from scipy.sparse import csr_matrix
from sheet import DURATION, GRAVITY, POISSON, SAMPLE_STEP, SIDE, THICKNESS, WAVE_SPEED, YOUNG, Grid, Recorder


def simulate(job: dict) -> dict:
    """job: scene, nx, ny, courant (step over the time that a wave takes through a cell), until (s, optional)."""
    loop = Loop()
    grid = Grid(job["nx"], job["ny"])
    recorder = Recorder(grid, grid.triangles)
    acceleration = _acceleration(grid, recorder.elements, job["scene"])
    longest = job["courant"] * SIDE / max(grid.nx, grid.ny) / WAVE_SPEED
    per_sample = int(np.ceil(SAMPLE_STEP / longest))
    h = SAMPLE_STEP / per_sample
    q = np.column_stack([grid.flat, np.zeros(len(grid.flat))])
    v = np.zeros_like(q)
    recorder.add(0, q, v)
    samples = round(job.get("until", DURATION[job["scene"]]) / SAMPLE_STEP)
    for sample in range(1, samples + 1):
        with loop:
            v += 0.5 * h * acceleration(q)
            for _ in range(per_sample):
                q += h * v
                a = acceleration(q)
                v += h * a
            v -= 0.5 * h * a
        recorder.add(sample, q, v)
    return {
        **recorder.result(),
        **loop.result(),
        "steps": per_sample * samples,
        "unknowns": int(3 * np.sum(~grid.held(job["scene"]))),
        "version": np.__version__,
    }


def _acceleration(grid: Grid, elements, scene: str):
    """q (n, 3) -> accelerations (n, 3), m/s^2."""
    triangles, areas = elements.triangles, elements.areas
    rows = np.repeat(np.arange(len(triangles)), 3)
    operators = []
    for k in range(2):
        first, second = elements.inverse[:, 0, k], elements.inverse[:, 1, k]
        slopes = np.stack([-first - second, first, second], axis=1)
        operators.append(csr_matrix((slopes.ravel(), (rows, triangles.ravel())), (len(triangles), len(grid.flat))))
    along_x, along_y = operators
    back_x, back_y = (operator.T.multiply(areas * THICKNESS).tocsr() for operator in operators)
    free = ~grid.held(scene)
    inverse_mass = (free / elements.masses)[:, None]
    gravity = np.outer(free, (0.0, 0.0, -GRAVITY))
    plane, shear = YOUNG / (1.0 - POISSON**2), YOUNG / (1.0 + POISSON)

    def acceleration(q):
        x, y = along_x @ q, along_y @ q
        xx, yy = 0.5 * (np.einsum("ij,ij->i", x, x) - 1.0), 0.5 * (np.einsum("ij,ij->i", y, y) - 1.0)
        s_x, s_y = plane * (xx + POISSON * yy), plane * (yy + POISSON * xx)
        s_xy = 0.5 * shear * np.einsum("ij,ij->i", x, y)
        force = back_x @ (s_x[:, None] * x + s_xy[:, None] * y) + back_y @ (s_y[:, None] * y + s_xy[:, None] * x)
        return gravity - inverse_mass * force

    return acceleration


if __name__ == "__main__":
    run(simulate)
