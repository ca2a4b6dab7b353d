"""The comparison with other programs: what is read off a motion, and the explicit reference."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from peers.sheet import (
    ENERGY_SCALE,
    GRAVITY,
    POINTS,
    POISSON,
    POSITION_TIME,
    SAG_REFERENCE,
    SAMPLE_STEP,
    SIDE,
    THICKNESS,
    YOUNG,
    Grid,
    Recorder,
    Triangles,
    position_error,
    sag_error,
)

PEERS = Path(__file__).parents[1] / "benchmarks" / "peers"


def stretched(flat, slopes):
    """An affine map of the flat sheet."""
    return flat @ np.asarray(slopes, dtype=float).T


def test_strain_and_energy_of_a_stretched_and_sheared_sheet_are_exact():
    grid = Grid(3, 5)
    sheet = Triangles(grid.flat, grid.triangles)
    slopes = np.array([[1.1, 0.2], [0.0, 0.9], [0.05, -0.1]])
    q = stretched(grid.flat, slopes)
    green = 0.5 * (slopes.T @ slopes - np.eye(2))
    for found, exact in zip(sheet.strains(q), (green[0, 0], green[1, 1], green[0, 1]), strict=True):
        np.testing.assert_allclose(found, exact, atol=1e-14)
    assert sheet.peak_strain(q) == pytest.approx(np.linalg.eigvalsh(green)[-1], rel=1e-12)
    stress = YOUNG / (1.0 - POISSON**2) * ((1.0 - POISSON) * green + POISSON * np.trace(green) * np.eye(2))
    strain_energy = 0.5 * THICKNESS * SIDE**2 * np.sum(stress * green)
    mass = 2.0 * ENERGY_SCALE / (GRAVITY * SIDE)
    weight = mass * GRAVITY * q[:, 2] @ sheet.masses / mass
    assert sheet.masses.sum() == pytest.approx(mass, rel=1e-12)
    v = np.tile([3.0, 0.0, 4.0], (len(q), 1))
    assert sheet.energy(q, v) == pytest.approx(12.5 * mass + strain_energy + weight, rel=1e-12)


def test_positions_between_vertices_are_bilinear():
    grid = Grid(4, 3)
    values = np.column_stack([grid.flat, grid.flat.prod(axis=1)])
    np.testing.assert_allclose(grid.at(values, POINTS), np.column_stack([POINTS, POINTS.prod(axis=1)]), atol=1e-15)


def test_the_error_of_a_sheet_that_is_shifted_is_the_shift():
    grid = Grid(6, 6)
    recorder = Recorder(grid, grid.triangles)
    q = np.column_stack([grid.flat, np.zeros(len(grid.flat))])
    recorder.add(round(POSITION_TIME / SAMPLE_STEP), q + np.array([0.0, 3e-3, -4e-3]))
    reference = np.column_stack([POINTS, np.zeros(len(POINTS))])
    assert position_error(recorder.positions, reference) == pytest.approx(5e-3, rel=1e-9)


def test_a_sheet_that_flies_apart_is_no_result():
    grid = Grid(2, 2)
    q = np.column_stack([3.0 * grid.flat, np.zeros(len(grid.flat))])
    with pytest.raises(FloatingPointError, match=r"unstable at 0\.007 s"):
        Recorder(grid, grid.triangles).add(7, q)


def test_the_explicit_reference_on_the_cells_of_the_table_is_the_table_to_its_rounding():
    job = {"scene": "sagging", "nx": 22, "ny": 22, "courant": 0.5, "until": 0.03}
    done = subprocess.run(
        [sys.executable, PEERS / "run_explicit.py", json.dumps(job)], capture_output=True, text=True, check=True
    )
    answer = json.loads(done.stdout.split("answer: ")[-1])
    assert answer["status"] == "done"
    error = sag_error(answer["sags"], until=0.03)
    print(f"22 x 22 cells, to 30 ms: {1e3 * error:.4f} mm of {-1e3 * SAG_REFERENCE[2]} mm")
    assert error < 0.005e-3
    assert abs(answer["energy_drift"]) < 1e-6
