"""Files of a run: tables, animation, checkpoint; killed, resumed and replaced runs."""

import csv
import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdValidation

import feed
import warp_origami as wo
from warp_origami.output import run_directory
from warp_origami.output.colours import colour
from warp_origami.output.memory import Memory
from warp_origami.output.observers import Observers
from warp_origami.output.progress import Progress
from warp_origami.output.run_directory import RunDirectory, is_finished, read_run
from warp_origami.solve.records import HISTORY_COLUMNS, Frame
from warp_origami.solve.simulate import simulate


def table(path):
    with path.open(newline="") as file:
        heading, *rows = csv.reader(file)
    return heading, np.array([[float(value) for value in row] for row in rows])


def prims(path):
    stage = Usd.Stage.Open(str(path))
    return stage, {prim.GetName(): prim for prim in stage.Traverse(Usd.PrimAllPrimsPredicate)}


def errors(path):
    """What the core validators of USD find."""
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [error.GetErrorAsString() for error in UsdValidation.ValidationContext(validators).Validate(stage)]


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "out" / "run"
    feed.feed(RunDirectory(folder), feed.scene(), 1.0)
    return folder


def test_tables_hold_every_number_to_the_last_bit(run):
    heading, rows = table(run / "history.csv")
    assert tuple(heading) == HISTORY_COLUMNS
    assert np.array_equal(rows[:, 0], np.arange(41) / 40.0)
    assert np.array_equal(rows[:, heading.index("strain_energy")], np.pi * rows[:, 0])
    assert np.all(rows[:, heading.index("kinetic_energy")] == 1 / 3)
    heading, rows = table(run / "probes.csv")
    assert heading[:2] == ["time", "tip.x"]
    assert heading[-3:] == ["tip.von_mises", "tip.s1", "tip.s2"]
    assert np.array_equal(rows[7, 1:], np.sin(np.arange(9) + 7 / 40))
    heading, rows = table(run / "reactions.csv")
    assert heading == ["time", "root.fx", "root.fy", "root.fz", "root.mx", "root.my", "root.mz"]
    assert len(rows) == 41


def test_only_the_documented_files_are_left(run):
    names = {"scene.toml", "animation.usdc", "history.csv", "probes.csv", "reactions.csv", "summary.json"}
    assert {path.name for path in run.iterdir()} == names | {"checkpoint.npz", "report.html"}


def test_summary_is_plain_json(run):
    summary = json.loads((run / "summary.json").read_text(), parse_constant=pytest.fail)
    assert summary["status"] == "done"
    assert summary["energy_loss"] is None


def test_scene_file_of_the_run_is_the_scene(run):
    assert wo.load_scene(run / "scene.toml") == feed.scene()


def test_animation_passes_the_core_validators(run):
    assert errors(run / "animation.usdc") == []


def test_validators_are_at_work(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "bad.usda"))
    UsdGeom.Mesh.Define(stage, "/mesh")
    stage.Save()
    assert errors(tmp_path / "bad.usda") != []


def test_animation_holds_the_motion(run):
    stage, found = prims(run / "animation.usdc")
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    assert stage.GetTimeCodesPerSecond() == feed.FPS
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, 20.0)
    assert stage.GetDefaultPrim()
    sheet = UsdGeom.Mesh(found["sheet"])
    assert sheet.GetPointsAttr().GetTimeSamples() == list(range(21))
    assert sheet.GetFaceVertexIndicesAttr().GetNumTimeSamples() == 0
    assert np.array_equal(np.reshape(sheet.GetFaceVertexIndicesAttr().Get(), (-1, 3)), feed.SURFACE.triangles)
    assert sheet.GetSubdivisionSchemeAttr().Get() == "none"
    for code in (0, 13, 20):
        expected = feed.bent(feed.SURFACE.flat, code / feed.FPS)
        assert np.allclose(sheet.GetPointsAttr().Get(code), expected, rtol=0, atol=1e-7)
        nodes = UsdGeom.Points(found["nodes"]).GetPointsAttr().Get(code)
        assert np.allclose(nodes, feed.bent(feed.PATTERN.mesh.vertices, code / feed.FPS), rtol=0, atol=1e-7)
        curves = UsdGeom.BasisCurves(found["creases"])
        along = np.asarray(curves.GetPointsAttr().Get(code))
        assert np.allclose(along, expected[feed.SURFACE.creases.ravel()], rtol=0, atol=1e-7)
        assert list(curves.GetCurveVertexCountsAttr().Get()) == [5, 5]
        low, high = sheet.GetExtentAttr().Get(code)
        assert np.allclose([low, high], [expected.min(axis=0), expected.max(axis=0)], rtol=0, atol=1e-7)
    assert np.allclose(UsdGeom.PrimvarsAPI(sheet).GetPrimvar("st").Get(), feed.SURFACE.flat, rtol=0, atol=1e-7)


def test_normals_are_those_of_the_bent_sheet(run):
    _, found = prims(run / "animation.usdc")
    normals = np.asarray(UsdGeom.Mesh(found["sheet"]).GetNormalsAttr().Get(20))
    angle = 3.0 * feed.SURFACE.flat[:, 0]
    expected = np.stack([-np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)
    inside = (feed.SURFACE.flat[:, 0] > 0.0) & (feed.SURFACE.flat[:, 0] < 1.0)
    # triangles of one grid line turn by 3/16 rad, those around an inner point lie on both sides of it
    assert np.abs(normals - expected)[inside].max() < 0.25 * 3 / 16
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)


def test_normals_of_a_sheet_folded_flat_are_unit_vectors(tmp_path):
    directory = RunDirectory(tmp_path)
    directory.start(feed.scene(), feed.SURFACE, None)
    folded = np.column_stack(
        [0.5 - np.abs(feed.SURFACE.flat[:, 0] - 0.5), feed.SURFACE.flat[:, 1], 0 * feed.SURFACE.flat[:, 0]]
    )
    directory.frame(Frame(0.0, folded, feed.frame(0.0).nodes, feed.frame(0.0).fields))
    directory.save()
    directory.finish({"status": "done"})
    _, found = prims(tmp_path / "animation.usdc")
    normals = np.asarray(UsdGeom.Mesh(found["sheet"]).GetNormalsAttr().Get(0))
    assert np.allclose(np.abs(normals[:, 2]), 1.0, atol=1e-6)


def test_colours_show_the_first_field_over_one_range(run):
    _, found = prims(run / "animation.usdc")
    sheet = UsdGeom.Mesh(found["sheet"])
    shown = sheet.GetDisplayColorPrimvar()
    assert shown.GetInterpolation() == UsdGeom.Tokens.vertex
    limits = shown.GetAttr().GetCustomData()
    assert limits["field"] == "von_mises"
    assert limits["low"] == 0.0
    assert limits["high"] == pytest.approx(np.percentile(feed.frame(1.0).fields["von_mises"], 99), rel=1e-6)
    for code in (0, 10, 20):
        values = UsdGeom.PrimvarsAPI(sheet).GetPrimvar("von_mises").Get(code)
        assert np.allclose(values, feed.frame(code / feed.FPS).fields["von_mises"], rtol=1e-6)
        assert np.allclose(shown.Get(code), colour(np.asarray(values), limits["low"], limits["high"]), atol=1e-6)
    state = UsdGeom.PrimvarsAPI(sheet).GetPrimvar("state").Get(5)
    assert set(np.asarray(state)) == {0.0, 1.0, 2.0}


def test_colour_scale_brightens_steadily():
    luminance = colour(np.linspace(0.0, 1.0, 50), 0.0, 1.0) @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(luminance) > 0.0)


def test_camera_sees_every_point_of_every_frame(run):
    _, found = prims(run / "animation.usdc")
    frustum = UsdGeom.Camera(found["camera"]).GetCamera(Usd.TimeCode.Default()).frustum
    project = np.array(frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix())
    extremes = []
    for code in range(21):
        points = np.asarray(UsdGeom.Mesh(found["sheet"]).GetPointsAttr().Get(code))
        assert all(frustum.Intersects(Gf.Vec3d(*map(float, point))) for point in points)
        seen = np.column_stack([points, np.ones(len(points))]) @ project
        extremes.append(np.abs(seen[:, :2] / seen[:, 3:]).max())
    assert 0.85 < max(extremes) < 1.0  # near the edge of the picture (1), not lost in its middle


def test_frame_per_step_has_its_time_in_milliseconds(tmp_path):
    feed.feed(RunDirectory(tmp_path), feed.scene(output={"fps": "steps"}), 0.2)
    stage, found = prims(tmp_path / "animation.usdc")
    assert stage.GetTimeCodesPerSecond() == 1000.0
    assert UsdGeom.Mesh(found["sheet"]).GetPointsAttr().GetTimeSamples() == [0.0, 50.0, 100.0, 150.0, 200.0]


def test_animation_without_fields_is_valid(tmp_path):
    feed.feed(RunDirectory(tmp_path), feed.scene(output={"fps": 20, "fields": []}), 0.2)
    assert errors(tmp_path / "animation.usdc") == []


def same_results(one, other, but=""):
    for name in {"history.csv", "probes.csv", "reactions.csv", "scene.toml", "summary.json"} - {but}:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    layers = [Sdf.Layer.FindOrOpen(str(folder / "animation.usdc")) for folder in (one, other)]
    assert layers[0].ExportToString() == layers[1].ExportToString()


@pytest.mark.parametrize("killed", [True, False])
def test_resumed_run_leaves_the_files_of_an_uninterrupted_one(run, tmp_path, monkeypatch, killed):
    monkeypatch.setattr(run_directory, "SAVING_SHARE", np.inf)  # save at every checkpoint
    folder, scene = tmp_path / "again", feed.scene()
    # killed: rows up to 0.55 s, frames up to 0.55 s, the last checkpoint at 0.5 s
    feed.feed(RunDirectory(folder), scene, 0.575, status="interrupted", kill=killed)
    with (folder / "history.csv").open("a") as file:
        file.write("0.6,0.02")  # half a row
    checkpoint = read_run(folder, scene)
    assert checkpoint["number"] == (20 if killed else 23)
    assert np.array_equal(checkpoint["q"], feed.bent(feed.PATTERN.mesh.vertices, checkpoint["number"] / 40))
    feed.feed(RunDirectory(folder), scene, 1.0, start=int(checkpoint["number"]))
    same_results(folder, run)


def test_killed_run_leaves_readable_files(tmp_path):
    feed.feed(RunDirectory(tmp_path), feed.scene(), 0.575, kill=True)
    assert len(table(tmp_path / "history.csv")[1]) == 24
    assert errors(tmp_path / "animation.usdc") == []
    assert wo.load_scene(tmp_path / "scene.toml") == feed.scene()
    assert not (tmp_path / "summary.json").exists()
    assert not is_finished(tmp_path, 0.5)


def test_new_run_replaces_the_files_of_the_old_one(run):
    feed.feed(RunDirectory(run), feed.scene(duration=0.3), 0.3)
    assert len(table(run / "history.csv")[1]) == 13
    assert prims(run / "animation.usdc")[0].GetEndTimeCode() == 6.0
    assert wo.load_scene(run / "scene.toml").analysis.duration == 0.3


def test_a_run_is_finished_where_it_reached_the_end(run):
    assert is_finished(run, 1.0)
    assert is_finished(run, 0.5)
    assert not is_finished(run, 2.0)
    assert not is_finished(run / "nowhere", 1.0)


def test_run_of_another_scene_is_not_resumed(run):
    with pytest.raises(wo.InputError, match="another scene"):
        read_run(run, feed.scene(duration=2.0))
    assert read_run(run / "nowhere", feed.scene()) is None


def test_run_of_another_fold_file_is_not_resumed(tmp_path):
    fold = tmp_path / "x.fold"
    feed.write_fold(fold)
    values = feed.scene().model_dump(exclude_none=True) | {"pattern": {"kind": "fold", "file": str(fold)}}
    scene = wo.Scene(**values)
    feed.feed(RunDirectory(tmp_path / "run"), scene, 0.2)
    assert read_run(tmp_path / "run", scene) is not None
    feed.write_fold(fold, 90.0)
    with pytest.raises(wo.InputError, match="another pattern"):
        read_run(tmp_path / "run", scene)


def test_broken_checkpoint_is_wrong_input(run):
    (run / "checkpoint.npz").write_bytes(b"PK nothing")
    with pytest.raises(wo.InputError, match="cannot be read"):
        read_run(run, feed.scene())


def test_checkpoint_never_holds_what_is_not_finite(run):
    directory = RunDirectory(run)
    directory.start(feed.scene(), feed.SURFACE, 1.0)
    directory.checkpoint({"number": np.array(99), "q": np.array([1.0, np.nan])})
    directory.save()
    directory.finish({"status": "failed"})
    assert read_run(run, feed.scene())["number"] == 40


def test_saving_is_rare_where_it_is_slow(tmp_path, monkeypatch):
    now = [0.0]
    saves = []

    def slow_save(self):
        saves.append(now[0])
        now[0] += 1.0

    monkeypatch.setattr(run_directory.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(run_directory.Animation, "save", slow_save)
    directory = RunDirectory(tmp_path)
    directory.start(feed.scene(), feed.SURFACE, None)
    for k in range(1000):
        now[0] = max(now[0], float(k))
        directory.checkpoint({"number": np.array(k)})
    assert 15 <= len(saves) <= 0.021 * 1000 + 1


def test_memory_keeps_the_run(tmp_path):
    memory = Memory()
    feed.feed(Observers([RunDirectory(tmp_path), memory]), feed.scene(), 0.5)
    assert memory.history["time"].shape == (21,)
    assert memory.probes["tip"].shape == (21, 9)
    assert np.array_equal(memory.reactions["root"][3], np.cos(np.arange(6) + 3 / 40))
    assert [frame.time for frame in memory.frames] == [k / 20 for k in range(11)]
    assert memory.summary["status"] == "done"


class Terminal:
    """A stream that says whether it is a terminal and keeps what is written."""

    def __init__(self, terminal):
        self.terminal, self.text = terminal, ""

    def write(self, text):
        self.text += text

    def flush(self):
        pass

    def isatty(self):
        return self.terminal


def test_progress_shows_time_step_iterations_and_energy():
    for terminal in (True, False):
        stream = Terminal(terminal)
        feed.feed(Progress(1.0, stream), feed.scene(), 1.0)
        assert "compiling kernels" in stream.text
        assert "step 2.5e-02 s, Newton 3, energy balance +0 % of the largest energy" in stream.text or not terminal
        assert ("100%" in stream.text) == terminal
    assert stream.text.count("\n") < 8  # a log should not fill up


def test_progress_in_a_log_tells_the_balance_in_percent_and_the_time_left(monkeypatch):
    clock = iter([0.0, 20.0, 40.0])
    monkeypatch.setattr("warp_origami.output.progress.time.monotonic", lambda: next(clock))
    stream = Terminal(False)
    progress = Progress(1.0, stream)
    progress._unit = " s"
    for time, error in ((0.0, 0.0), (0.25, -0.0026), (1.0, 0.0)):
        record = feed.record(time, 0.25)
        record.history.update(kinetic_energy=1.0, strain_energy=0.0, energy_error=error)
        progress.step(record)
    first, second, last = stream.text.splitlines()
    assert first.startswith("0.0000 of 1 s: step")
    assert second.startswith("0.2500 of 1 s, 01:00 left: step")
    assert second.endswith("Newton 3, energy balance -0.26 % of the largest energy")
    assert last.startswith("1.0000 of 1 s: step")


class Killed(BaseException):
    """Ends a run as abruptly as a test can."""


class Killer(Memory):
    """Ends the run at its n-th accepted step, after everyone else was told of it."""

    def __init__(self, steps):
        super().__init__()
        self.steps = steps

    def checkpoint(self, arrays):
        """Counts steps: there is a checkpoint after each."""
        self.steps -= 1
        if self.steps == 0:
            raise Killed


def test_killed_simulation_goes_on_with_the_same_results(tmp_path):
    scene = feed.scene(
        duration=0.05,
        load=[{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
        output={"fps": 200},
    )
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    simulate(scene, RunDirectory(whole))
    with pytest.raises(Killed):
        simulate(scene, Observers([RunDirectory(broken), Killer(10)]))
    # the animation and the checkpoint may be some steps older than the tables: what is newer is computed again
    simulate(scene, RunDirectory(broken), resume=read_run(broken, scene))
    same_results(whole, broken, but="summary.json")
    first, second = (json.loads((folder / "summary.json").read_text()) for folder in (whole, broken))
    for key in ("status", "steps_accepted", "steps_rejected", "newton_iterations", "energy_gain", "energy_loss"):
        assert first[key] == second[key], key


def test_simulating_from_python_gives_the_rows_of_the_files(tmp_path):
    scene = feed.scene(duration=5e-3, load=[{"kind": "gravity", "acceleration": [0, 0, -9.81]}])
    result = wo.simulate(scene, device="cpu", observers=[RunDirectory(tmp_path)])
    heading, rows_of_file = table(tmp_path / "history.csv")
    assert np.array_equal(np.column_stack([result.history[column] for column in heading]), rows_of_file)
    assert np.array_equal(result.probes["tip"], table(tmp_path / "probes.csv")[1][:, 1:])
    assert np.array_equal(result.reactions["root"], table(tmp_path / "reactions.csv")[1][:, 1:])
    assert result.frames[0].points.shape == (len(result.surface.flat), 3)
    assert result.summary["status"] == "done"


@pytest.mark.parametrize("name", ["checkpoint.npz", "animation.usdc"])
def test_damaged_files_of_a_run_are_told(run, name):
    """An empty checkpoint, a checkpoint of another version, junk for an animation: one message, nothing deleted."""
    (run / name).write_bytes(b"")
    before = sorted(path.name for path in run.iterdir())
    with pytest.raises(wo.InputError, match="--resume"):
        read_run(run, feed.scene())
        RunDirectory(run).start(feed.scene(), feed.SURFACE, 0.5)
    assert sorted(path.name for path in run.iterdir()) == before


def test_damaged_summary_is_no_finished_run(run):
    (run / "summary.json").write_text("{")
    assert not is_finished(run, 1.0)
