"""Speed against error: the command on tiny scenes, errors, fronts, failed runs, runs that are there already."""

import csv
import subprocess

import numpy as np
import pytest
from click.testing import CliRunner

import warp_origami as wo
from runs import GRAVITY, film
from warp_origami.cli import main
from warp_origami.model.generators import build_pattern
from warp_origami.study.measured.measurement import Measurement
from warp_origami.study.measured.side_by_side import Job, SideBySide
from warp_origami.study.pareto import settings
from warp_origami.study.pareto.errors import agreement, differences, motion_error, pareto_front, values_error
from warp_origami.study.pareto.measured_study import coinciding

SAGGING = {
    "pattern": {"nx": 2, "ny": 2},
    "material": {"model": "linear"},
    "support": [{"at": {"boundary": True}}],
    "load": [GRAVITY],
}


@pytest.fixture(scope="module")
def few_settings():
    """A study of few settings, one of them impossible."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settings, "TOLERANCES", (64.0, 0.5, 0.25))
        patch.setattr(settings, "COMBINED_FACTORS", (0.25,))
        patch.setattr(settings, "RADII", (2.0,))
        patch.setattr(settings, "COMBINED_RADII", ())
        patch.setattr(settings, "DEGREES", (2,))
        patch.setattr(settings, "FORMS", ("eliminate",))
        patch.setattr(settings, "LOAD_STEPS", ())
        patch.setattr(settings, "REFINEMENTS", (2,))
        yield


def pareto(*arguments):
    ended = CliRunner().invoke(main, ["pareto", *map(str, arguments)], catch_exceptions=False)
    return ended.exit_code, ended.stdout


def table(folder):
    with open(folder / "pareto.csv", newline="") as file:
        return {row["setting"]: row for row in csv.DictReader(file)}


@pytest.fixture(scope="module")
def motion(few_settings, tmp_path_factory):
    """Folder, exit code and output of a study of a motion."""
    folder = tmp_path_factory.mktemp("motion")
    scene = folder / "sagging.toml"
    tables = {key: value for key, value in SAGGING.items() if key not in ("pattern", "material")}
    scene.write_text(film(0.02, SAGGING["pattern"], SAGGING["material"], **tables).to_toml())
    return scene, folder, *pareto(scene, "--out", folder, "--budget", 60, "--jobs", 2)


@pytest.fixture(scope="module")
def deflection(few_settings, tmp_path_factory):
    """The same of a static scene with exact values, its finest mesh of 8 x 8 cells."""
    folder = tmp_path_factory.mktemp("deflection")
    meshes = 'verification.refinement=[["pattern.nx=4", "pattern.ny=4"], ["pattern.nx=8", "pattern.ny=8"]]'
    change = ["--set", meshes, "--set", "verification.quick=1", "--set", "verification.value.0.tolerance=1e-2"]
    change += ["--set", "verification.value.1.tolerance=1e-6", "--set", "pattern.nx=2", "--set", "pattern.ny=2"]
    return folder, *pareto("verification/drum_deflection", "--out", folder, *change, "--jobs", 2)


def test_a_motion_is_held_against_its_finest_run(motion):
    _, folder, code, text = motion
    rows = table(folder)
    assert code == 0
    assert {"the scene's own", "tolerance 0.0064", "tolerance 2.5e-05", "refine 2", "quadrature 2"} <= set(rows)
    assert "its own finest run (refine 2, tolerance 2.5e-05)" in text
    assert rows["refine 2, tolerance 2.5e-05"]["error"] == ""
    assert float(rows["refine 2"]["error"]) < 0.1 * float(rows["the scene's own"]["error"])
    assert float(rows["the scene's own"]["error_on_mesh"]) < 0.1 * float(rows["the scene's own"]["error"])
    for row in rows.values():
        if row["status"] == "done":
            assert 0.0 < float(row["wall_seconds"]) <= float(row["whole_seconds"])
            assert float(row["peak_memory_bytes"]) > 1e7
    assert any(row["front"] == "1" for row in rows.values())


def test_output_names_machine_versions_and_what_to_use(motion):
    _, folder, _, text = motion
    assert "2 runs side by side" in text
    assert all(f"{name} " in text for name in ("python", "numpy", "scipy", "warp", "warp-origami"))
    assert text.count("Errors below") == 6
    assert "on the scene's own mesh: " in text
    assert (folder / "pareto.png").read_bytes().startswith(b"\x89PNG")


def test_a_run_that_cannot_be_made_is_a_row(motion):
    _, folder, _, _ = motion
    row = table(folder)["radius 2"]
    assert row["status"] == "refused"
    assert "integrator.spectral_radius: got 2.0" in row["message"]
    assert row["error"] == row["wall_seconds"] == ""
    assert row["front"] == "0"


def test_statistics_of_whole_runs(motion):
    _, folder, _, text = motion
    rows = table(folder)
    assert float(rows["tolerance 2.5e-05"]["deviation_max_kinetic"]) == 0.0
    assert abs(float(rows["the scene's own"]["deviation_mean_kinetic"])) < 1e-3
    assert float(rows["refine 2"]["max_kinetic"]) > 1.01 * float(rows["the scene's own"]["max_kinetic"])
    assert "deviation from tolerance 2.5e-05" in text


def test_what_is_there_is_not_run_again(motion, monkeypatch):
    scene, folder, _, _ = motion
    before = table(folder)

    def refuse(*arguments, **options):
        raise AssertionError("a process was started")

    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "Popen", refuse)
        assert pareto(scene, "--out", folder, "--budget", 60, "--jobs", 2)[0] == 0
        assert table(folder) == before
        with pytest.raises(AssertionError, match="a process was started"):
            pareto(scene, "--out", folder, "--jobs", 2, "--set", "material.thickness=6e-4")


def test_exact_values_are_the_reference_where_a_scene_has_them(deflection):
    folder, code, text = deflection
    rows = table(folder)
    assert code == 0
    assert "against exact values (w_xx + w_yy" in text
    errors = [float(rows[name]["error"]) for name in ("the scene's own", "nx 4, ny 4", "nx 8, ny 8")]
    assert errors[1] < 0.2 * errors[0]
    assert errors[2] < 0.2 * errors[1]
    assert rows["nx 8, ny 8"]["front"] == "1"
    assert "quadrature 2" in rows
    assert "nx 8, ny 8, quadrature 2" in rows
    assert not any(name.startswith("tolerance") for name in rows)


def test_input_that_cannot_be_modelled_is_refused(tmp_path):
    ended = CliRunner().invoke(main, ["pareto", "leaf_in", "--out", str(tmp_path), "--set", "probe.0.at=[9, 9]"])
    assert ended.exit_code == 2
    assert "probe.0.at: got" in ended.stderr
    assert not (tmp_path / "pareto.csv").exists()


def test_a_run_out_of_time_keeps_what_it_has_and_one_that_dies_says_why(tmp_path):
    pool = SideBySide(tmp_path, 2)
    scene = film(1e4, {"nx": 1, "ny": 1}, integrator={"step": 0.1})
    ended = {}
    jobs = [Job("long", scene, np.arange(4), 1e4, 1e4, 1.0), Job("dead", scene, np.arange(4), 1e4, 1e4, 60.0)]
    running = pool.run(iter(jobs))
    start = pool._start

    def start_and_kill(job):
        one = start(job)
        if job.label == "dead":
            one.process.kill()
        return one

    pool._start = start_and_kill
    for job, gave, _ in running:
        ended[job.label] = gave
    assert ended["long"].status == "timed out"
    assert ended["long"].history["time"][-1] > 0.0
    assert ended["long"].positions.shape == (1, 4, 3)
    assert (ended["dead"].status, ended["dead"].message) == ("failed", "exit code -9")


def test_compared_vertices_are_the_same_on_every_mesh():
    coarse, fine = (wo.load_scene("sagging_sheet", [f"pattern.nx={n}", f"pattern.ny={n}"]) for n in (4, 8))
    refined = wo.load_scene("sagging_sheet", ["pattern.nx=4", "pattern.ny=4", "pattern.refine=2"])
    meshes = [mesh_of(scene) for scene in (coarse, fine, refined)]
    for other in meshes[1:]:
        same = coinciding(meshes[0], other)
        np.testing.assert_allclose(other.vertices[same], meshes[0].vertices, atol=1e-12)
    assert list(coinciding(meshes[0], meshes[2])) == list(range(25))
    missing = coinciding(meshes[1], meshes[0])
    assert np.sum(missing >= 0) == 25
    assert np.sum(missing < 0) == 56


def mesh_of(scene):
    return build_pattern(scene.pattern.kind, scene.pattern.parameters()).mesh


def moving(offset, frames=5, vertices=3):
    """A motion along x at 1 m/s, whose vertices are `offset` (m, at each frame) too far in z."""
    positions = np.zeros((frames, vertices, 3))
    positions[:, :, 0] = np.arange(frames)[:, None]
    positions[:, :, 2] = np.broadcast_to(offset, frames)[:, None]
    times = np.arange(frames, dtype=float)
    return Measurement("done", "", {}, (), times, times, times, times, positions, {})


def test_errors_of_motions():
    a, b = moving(0.0), moving([0.0, 1e-4, 2e-4, 3e-3, 5e-3])
    np.testing.assert_allclose(differences(a, b), [0.0, 1e-4, 2e-4, 3e-3, 5e-3])
    assert agreement(a, b, 1.0) == 3
    assert agreement(a, a, 1.0) == 5
    assert motion_error(b, a, 3, 2.0) == pytest.approx(np.sqrt(5e-8 / 3.0) / 2.0)
    assert np.isnan(motion_error(moving(0.0, frames=2), a, 3, 1.0))
    b.positions[:, 1:] = np.nan
    np.testing.assert_allclose(differences(a, b), [0.0, 1e-4, 2e-4, 3e-3, 5e-3])


def test_errors_of_values_are_relative_but_to_zero():
    assert values_error((1.1, 1e-3), (1.0, 0.0)) == pytest.approx(0.1)
    assert np.isnan(values_error((), (1.0,)))
    assert np.isnan(values_error((1.1, float("nan")), (1.0, 1.0)))


def test_front_of_given_points():
    nan = float("nan")
    points = [(1.0, 1.0), (2.0, 0.5), (3.0, 0.6), (2.5, 0.48), (4.0, 0.1), (0.5, nan), (nan, 0.01), (2.0, 0.7)]
    assert pareto_front(points) == [True, True, False, False, True, False, False, False]
    assert pareto_front([(nan, nan), (5.0, 0.1), (nan, nan), (1.0, 1.0), (3.0, 0.5), (nan, nan), (4.0, 0.7)]) == [
        False,
        True,
        False,
        True,
        True,
        False,
        False,
    ]
    assert pareto_front([]) == []
