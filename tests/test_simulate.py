"""Whole runs: order in time, both constraint forms, momentum, free fall, frames, and runs that fail."""

import csv
import json
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner

import warp_origami as wo
from runs import GRAVITY, film, run, system_of
from warp_origami.cli import main
from warp_origami.errors import NumericalFailure
from warp_origami.solve import dynamic
from warp_origami.solve.result import Failure

TAUT = {"initial": {"stretch": [1.0004, 1.0004]}}


def lifted(step, form="eliminate", radius=0.8):
    """A taut sheet whose right edge is lifted smoothly, everything else of its rim held in its plane."""
    return film(
        0.04,
        TAUT | {"nx": 3, "ny": 3},
        {"model": "linear"},
        support=[
            {"at": {"boundary": True}, "fix": "xy"},
            {"at": {"box": [[0.0, 0.0], [0.0, 0.6]]}, "fix": "z"},
        ],
        driver=[{"name": "d", "at": {"box": [[0.6, 0], [0.6, 0.6]]}, "axes": "z", "translate": [0, 0, 0.005]}],
        integrator={"step": step, "spectral_radius": radius, "tolerance": 1e-7, "constraints": form},
    )


@pytest.fixture(scope="module")
def fine():
    """The motion with steps of a quarter of the finest below, or less."""
    return run(lifted(0.04 / 3200))


def test_second_order_in_position_velocity_and_reaction(fine):
    errors = []
    for n in (200, 400, 800):
        coarse = run(lifted(0.04 / n))
        ends = [(coarse.q, fine.q), (coarse.v, fine.v), (coarse.reactions["d"], fine.reactions["d"])]
        errors.append([np.abs(a[-1] - b[-1]).max() for a, b in ends])
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    print(f"errors of q, v, reaction at n = 200, 400, 800: {np.array(errors)}\norders {orders}")
    assert orders[-1].min() > 1.9


def test_error_is_proportional_to_the_tolerance(fine):
    """Steps of their own choice on the same motion: they fall with the root of the tolerance, the error as a whole with
    their square."""
    errors, steps = [], []
    for tolerance in (1e-7, 1e-8, 1e-9):
        scene = lifted("auto")
        scene = scene.model_copy(update={"integrator": scene.integrator.model_copy(update={"tolerance": tolerance})})
        result = run(scene)
        errors.append(np.abs(result.q[-1] - fine.q[-1]).max())
        steps.append(result.summary["steps_accepted"])
    powers = np.log10(np.array(errors[:-1]) / errors[1:])
    print(f"errors {errors} m with {steps} steps, powers of the tolerance {powers}")
    assert powers.min() > 0.9
    assert steps[2] < 10 * steps[0]


def compare_forms(scene, until):
    """Largest difference of positions and, relative, of reactions between elimination and multipliers."""
    results = []
    for form in ("eliminate", "multipliers"):
        integrator = scene.integrator.model_copy(update={"constraints": form})
        results.append(run(scene.model_copy(update={"integrator": integrator}), until=until))
    a, b = results
    assert (a.summary["constraint_form"], b.summary["constraint_form"]) == ("eliminate", "multipliers")
    position = np.abs(a.q - b.q).max()
    force = max(np.abs(a.reactions[k] - b.reactions[k]).max() for k in a.reactions)
    return position, force, max(np.abs(values).max() for values in a.reactions.values())


def test_eliminated_and_multiplier_runs_agree_on_a_smooth_motion():
    position, force, size = compare_forms(lifted(2e-4), None)
    print(f"difference {position:.2e} m, reactions {force:.2e} of {size:.2e} N")
    assert position < 1e-12
    assert force < 1e-9 * size


@pytest.mark.parametrize("name", ["single_fold", "leaf_in"])
def test_eliminated_and_multiplier_runs_agree_on_folded_sheets(name):
    scene = wo.load_scene(name, ["integrator.step=2e-3", "integrator.tolerance=1e-8"])
    position, force, size = compare_forms(scene, 0.1)
    print(f"{name}: difference {position:.2e} m, reactions {force:.2e} of {size:.2e} N")
    assert position < 1e-8
    assert force < 1e-6 * size


def test_eliminated_and_multiplier_runs_agree_in_contact():
    """A fold that is thrown shut: its panels bounce off each other."""
    closing = [{"kind": "initial_velocity", "value": [2.0, 0.0, 0.0], "at": {"box": [[0.0, 0.0], [0.0, 0.6]]}}]
    scene = film(
        0.02,
        {"creases_x": [1], "opening": 0.1},
        load=closing,
        support=[{"name": "corner", "at": {"near": [0.6, 0.0]}}],
        contact={"method": "mixed"},
        integrator={"step": 2e-4, "tolerance": 1e-8},
    )
    position, force, size = compare_forms(scene, None)
    contacts = run(scene).history
    assert contacts["contacts_sts"].max() > 0 and contacts["contacts_nts"].max() > 0
    print(f"difference {position:.2e} m, reactions {force:.2e} of {size:.2e} N")
    assert position < 1e-8
    assert force < 1e-6 * size


def fall(model, radius, step):
    """Deviation (k, n, 3) of all positions from free fall, 100 steps at the most."""
    duration = min(0.9, 100 * step)
    scene = film(duration, {}, {"model": model}, load=[GRAVITY], integrator={"step": step, "spectral_radius": radius})
    system, result = system_of(scene), run(scene)
    positions = system.coordinates.positions
    deviation = result.q[:, positions] - system.q0[positions]
    deviation[:, :, 2] += 0.5 * 9.81 * result.times[:, None] ** 2
    return deviation


STEPS = (1e-4, 1e-3, 0.01, 0.05, 0.1)


@pytest.mark.parametrize("model", ["linear", "srm"])
@pytest.mark.parametrize("radius", [0.0, 0.3, 1.0])
def test_free_fall_is_exact_at_any_step(model, radius):
    for step in STEPS:
        assert np.abs(fall(model, radius, step)[:, :, 2]).max() < 5e-13


@pytest.mark.parametrize(
    ("model", "radius"),
    [
        ("linear", 0.0),
        ("linear", 0.5),
        ("linear", 1.0),
        ("srm", 0.0),
        ("srm", 0.3),
        ("srm", 0.6),
        ("srm", 1.0),
    ],
)
def test_a_falling_sheet_stays_as_it_is(model, radius):
    """An unstressed sheet sits on the kinks of the stiffness reduction model, where round-off changes the stiffness."""
    for step in STEPS:
        assert np.abs(fall(model, radius, step)[:, :, :2]).max() < 1e-9


def tumbling(step, duration=0.02):
    """A free sheet, one side thrown up and the other down and sideways: it spins, stretches and vibrates."""
    load = [
        {"kind": "initial_velocity", "value": [0.3, 0.0, 2.0], "at": {"box": [[0.6, 0.0], [0.6, 0.6]]}},
        {"kind": "initial_velocity", "value": [0.0, 0.5, -1.0], "at": {"box": [[0.0, 0.0], [0.0, 0.6]]}},
    ]
    integrator = {"step": step, "spectral_radius": 1.0, "tolerance": 1e-7}
    return film(duration, {}, {"model": "linear"}, load=load, integrator=integrator)


def test_momentum_of_a_free_sheet_is_kept_to_round_off():
    """Linear momentum; angular momentum L + h^2 / 4 sum v x M q'', what the trapezoidal rule keeps in place of L.

    Round-off of v is that of q over the step.
    """
    deviations = []
    for step in (1e-4, 5e-5, 2.5e-5):
        scene = tumbling(step)
        system, result = system_of(scene), run(scene)
        positions = system.coordinates.positions
        linear = np.array([(system.mass @ v)[positions].sum(axis=0) for v in result.v])
        angular = np.array([np.cross(q, system.mass @ v).sum(axis=0) for q, v in zip(result.q, result.v, strict=True)])
        kept = angular + step**2 / 4.0 * np.array(
            [np.cross(v, system.mass @ a).sum(axis=0) for v, a in zip(result.v, result.accelerations, strict=True)]
        )
        assert np.abs(linear - linear[0]).max() < 1e-9 * np.abs(linear).max()
        assert np.abs(kept - kept[0]).max() < 1e-9 * np.abs(kept).max()
        deviations.append(np.abs(angular - kept[0]).max() / np.abs(angular).max())
        assert result.history["strain_energy"].max() > 1e-3 * result.history["kinetic_energy"].max()
        gain = result.summary["energy_gain"]
        print(f"step {step:g}: angular momentum within {deviations[-1]:.2e}, energy gain {gain:.2e}")
        assert gain < 0.02
    assert deviations[0] > 10.0 * deviations[-1]


def test_equal_runs_give_equal_bits():
    one, two = (run(wo.load_scene("single_fold"), until=0.05) for _ in range(2))
    assert one.q.tobytes() == two.q.tobytes()
    assert one.history["newton_iterations"].tolist() == two.history["newton_iterations"].tolist()


def test_frames_come_at_the_frame_rate_and_lie_on_the_motion():
    """Frames between steps are interpolated: free fall is reproduced exactly at any step."""
    scene = film(0.5, {}, load=[GRAVITY], integrator={"step": 0.07}, output={"fps": 60})
    result = run(scene)
    times = np.array([frame.time for frame in result.frames])
    np.testing.assert_allclose(times, np.arange(31) / 60, atol=1e-12)
    for frame in result.frames:
        np.testing.assert_allclose(frame.points[:, 2], -0.5 * 9.81 * frame.time**2, atol=1e-12)
    every = run(film(0.5, {}, load=[GRAVITY], integrator={"step": 0.07}, output={"fps": "steps"}))
    assert [frame.time for frame in every.frames] == every.history["time"].tolist()


def test_contact_pressure_is_drawn_where_nothing_has_been_near_yet():
    fold = {"creases_x": [1], "opening": 0.1}
    result = run(film(0.01, fold, contact={}, output={"fps": 100, "fields": ["contact_pressure"]}))
    assert [frame.fields["contact_pressure"].max() for frame in result.frames] == [0.0, 0.0]


def test_a_run_ends_exactly_where_it_is_asked_to():
    scene = film(0.5, {}, load=[GRAVITY], integrator={"step": 0.07})
    for until in (0.5, 0.3, 0.01):
        assert run(scene, until=until).history["time"][-1] == pytest.approx(until, rel=1e-12)


HOPELESS = ["integrator.step=0.1", "integrator.tolerance=1e-13"]


def test_a_run_that_cannot_go_on_ends_with_what_there_is_and_advice(tmp_path, monkeypatch):
    """Newton is to come closer than round-off lets it, and gives up: the files stay readable, exit code 3."""
    monkeypatch.chdir(tmp_path)
    arguments = [word for value in HOPELESS for word in ("--set", value)]
    ended = CliRunner().invoke(main, ["run", "single_fold", "--quiet", "--out", "out", *arguments])
    print(ended.stderr)
    assert ended.exit_code == 3
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["status"] == "failed"
    assert summary["message"].startswith("stopped at ")
    assert summary["advice"]
    assert summary["message"] in ended.stderr and summary["advice"] in ended.stderr
    for name in ("history", "probes", "reactions"):
        with (tmp_path / "out" / f"{name}.csv").open() as file:
            rows = list(csv.reader(file))
        assert len(rows) == summary["steps_accepted"] + 2
        assert np.isfinite(np.array(rows[1:], dtype=float)).all()
    assert (tmp_path / "out" / "animation.usdc").stat().st_size > 0


def test_a_failed_run_from_python_raises_with_the_result():
    with pytest.raises(NumericalFailure, match=r"stopped at .* s: .*smaller steps") as caught:
        wo.simulate(wo.load_scene("single_fold", HOPELESS), device="cpu")
    result = caught.value.result
    assert result.summary["status"] == "failed"
    assert len(result.history["time"]) == result.summary["steps_accepted"] + 1


def test_a_run_that_crawls_ends_with_the_reason(monkeypatch):
    """Only steps a hundred-millionth of the run long are let pass: it ends after 200 of them, with why."""

    def passage(system, before, after):
        return Failure("layers would pass", "a stiffer contact") if np.abs(after - before).max() > 5e-9 else None

    monkeypatch.setattr(dynamic, "passage", passage)
    thrown = {"kind": "initial_velocity", "value": [0.0, 0.0, 1.0]}
    with pytest.raises(NumericalFailure, match="the last 200 steps have led nowhere: layers would pass") as caught:
        run(film(1.0, {"nx": 1, "ny": 1}, load=[thrown]))
    summary = caught.value.result.summary
    assert 200 <= summary["steps_accepted"] < 300
    assert summary["advice"] == "a stiffer contact"


def test_a_passage_halves_the_step_and_a_fixed_one_ends_the_run(monkeypatch):
    def passage(system, before, after):
        return Failure("layers would pass", "a stiffer contact") if np.abs(after - before).max() > 1e-3 else None

    monkeypatch.setattr(dynamic, "passage", passage)
    thrown = {"kind": "initial_velocity", "value": [0.0, 0.0, 1.0]}
    scene = film(0.1, {"nx": 1, "ny": 1}, load=[thrown])
    result = run(scene)
    assert result.summary["status"] == "done" and result.summary["steps_rejected"] > 0
    assert max(np.abs(b - a).max() for a, b in pairwise(result.q)) <= 1e-3
    with pytest.raises(NumericalFailure, match="layers would pass"):
        run(film(0.1, {"nx": 1, "ny": 1}, load=[thrown], integrator={"step": 0.01}))


def test_energy_is_created_by_no_more_than_the_control_allows():
    """Two sheets clapped together by steps far longer than their contact: shorter ones are taken where it matters."""
    scene = wo.load_scene("two_sheets", ["integrator.step=auto", "integrator.tolerance=1e-3"])
    summary = wo.simulate(scene, device="cpu").summary
    assert summary["status"] == "done"
    assert summary["energy_gain"] < dynamic.CREATED_SHARE + 10 * dynamic.SMALL_SHARE
