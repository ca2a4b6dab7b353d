"""The leaf-in deployment against what its issue and the paper's story ask for."""

import ipctk
import numpy as np
import pytest
from scipy.spatial import cKDTree

import warp_origami as wo

REFLECTIONS = [np.diag([-1.0, 1.0]), np.diag([1.0, -1.0]), np.array([[0.0, 1.0], [1.0, 0.0]])]


def symmetry_error(run):
    """(frames,) largest violation of the four-fold mirror symmetry of the drawn points, m."""
    flat = run.surface.flat
    tree = cKDTree(flat)
    points = np.array([frame.points for frame in run.frames])
    error = np.zeros(len(points))
    for mirror in REFLECTIONS:
        distance, image = tree.query(flat @ mirror.T)
        assert distance.max() < 1e-9
        reflection = np.eye(3)
        reflection[:2, :2] = mirror
        error = np.maximum(error, np.abs(points[:, image] - points @ reflection.T).max(axis=(1, 2)))
    return error


def crossing(run):
    """Times of the frames in which the drawn triangles cross."""
    triangles = run.surface.triangles.astype(np.int32)
    mesh = ipctk.CollisionMesh(run.frames[0].points, ipctk.edges(triangles), triangles)
    return [frame.time for frame in run.frames if ipctk.has_intersections(mesh, frame.points)]


def test_start():
    """Stress-free, uncrossed, symmetric for 0.4 s."""
    run = wo.simulate(wo.load_scene("leaf_in"), device="cpu", until=0.4)
    assert run.history["strain_energy"][0] < 1e-12
    assert run.history["contact_energy"][0] == 0.0
    assert symmetry_error(run).max() < 1e-6
    assert not crossing(run)


@pytest.fixture(scope="module")
def mixed():
    return wo.simulate(wo.load_scene("leaf_in"), device="cpu")


@pytest.mark.slow
def test_mixed_run_keeps_the_layers_apart_and_ends_tense(mixed):
    history, thickness = mixed.history, wo.load_scene("leaf_in").contact.thickness
    assert mixed.summary["status"] == "done"
    assert mixed.summary["energy_gain"] < 5e-3
    assert history["contacts_sts"].max() > 0 and history["contacts_nts"].max() > 0
    assert 0.0 < mixed.summary["max_penetration"] < 0.5 * thickness
    assert not crossing(mixed)
    late = history["time"] >= 3.9
    assert history["slack"][late].max() < 0.05
    assert np.abs(mixed.frames[-1].points[:, 2]).max() < 0.01
    error = symmetry_error(mixed)
    print(
        "symmetry error, m:", {frame.time: float(e) for frame, e in zip(mixed.frames[::30], error[::30], strict=True)}
    )
    assert error[[frame.time <= 0.4 for frame in mixed.frames]].max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("method", [None, "sts"])
def test_other_models_of_the_paper_run(method):
    scene = wo.load_scene("leaf_in", [] if method is None else [f"contact.method={method}"])
    if method is None:
        scene = scene.model_copy(update={"contact": None})
    run = wo.simulate(scene, device="cpu")
    assert run.summary["status"] == "done"
    assert run.summary["energy_gain"] < 5e-3
    if method is None:
        assert crossing(run), "without contact the sheet passes through itself"
