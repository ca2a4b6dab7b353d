"""report.html from the files of a run: what it holds, what it says of what is missing, what it never does."""

import base64
import json
import re
import sys
import types
import zlib

import numpy as np
import pytest
from click.testing import CliRunner

import feed
from warp_origami.cli import main
from warp_origami.errors import InputError
from warp_origami.output import run_directory
from warp_origami.output.animation_file import AnimationFile
from warp_origami.output.report.charts import charts, thinned
from warp_origami.output.report.coding import Blob
from warp_origami.output.report.drawn_sheet import draw_sheet, rim, segments, split_at_creases
from warp_origami.output.report.page import build_report
from warp_origami.output.report.run_files import Table, read_run_files
from warp_origami.output.report.tables import energy_put_in, model_rows, result_rows, settings
from warp_origami.output.run_directory import RunDirectory

FILES = ("scene.toml", "summary.json", "animation.usdc", "history.csv", "probes.csv", "reactions.csv")


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "run"
    feed.feed(RunDirectory(folder), feed.scene(), 1.0)
    return folder


def described(path):
    """The description of the run in a page."""
    found = re.search(r'<script type="application/json" id="run">(.*?)</script>', path.read_text(encoding="utf-8"))
    return json.loads(found[1])


def test_page_names_no_other_place(run):
    text = (run / "report.html").read_text(encoding="utf-8")
    assert re.search(r"Content-Security-Policy\" content=\"default-src 'none'", text)
    assert not re.search(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", text)
    assert not re.search(r"@import|url\(", text)
    for licence in ("three.js authors", "Leon Sorokin", "Permission is hereby granted"):
        assert licence in text
    assert "{{" not in re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)


def test_same_files_same_page(run):
    first = (run / "report.html").read_bytes()
    build_report(run)
    assert (run / "report.html").read_bytes() == first


def test_file_that_was_replaced_is_read_anew(run):
    before = AnimationFile(run / "animation.usdc")
    feed.feed(RunDirectory(run), feed.scene(), 0.5)
    assert (len(before.times), len(AnimationFile(run / "animation.usdc").times)) == (21, 11)


def test_settings_are_all_of_the_scene(run):
    rows = {(row.table, row.key): row for row in settings(read_run_files(run))}
    assert rows["material", "youngs_modulus"].value == "2.5e9"
    assert "Pa" in rows["material", "youngs_modulus"].meaning
    assert rows["integrator", "spectral_radius"].default
    assert not rows["output", "fps"].default
    assert rows["support.0", "name"].value == "root"
    told = feed.scene().model_dump(exclude_none=True)
    for table in ("analysis", "pattern", "material", "integrator", "output"):
        assert {key for place, key in rows if place == table} == {k for k, v in told[table].items() if v != ()}


def test_long_lists_are_cut_in_the_table_of_settings(tmp_path):
    scene = feed.scene(load=[{"kind": "force", "at": {"vertices": list(range(15)) * 20}, "value": [1.0, 0.0, 0.0]}])
    feed.feed(RunDirectory(tmp_path), scene, 0.5)
    rows = {(row.table, row.key): row.value for row in settings(read_run_files(tmp_path))}
    assert rows["load.0.at", "vertices"].endswith("8, 9, … 300 in all]")


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("left", [None, 0, 40, 0.6])
def test_each_file_may_be_missing_or_cut_off(run, name, left):
    path = run / name
    content = path.read_bytes()
    path.unlink()
    if left is not None:
        path.write_bytes(content[: left if isinstance(left, int) else int(left * len(content))])
    _, remarks = build_report(run)
    whole_rows = name.endswith(".csv") and left == 0.6  # a row that is cut off is what a killed run leaves
    assert any(name in remark for remark in remarks) or whole_rows
    found = described(run / "report.html")
    assert (found["sheet"] is None) == (name == "animation.usdc")


def test_damaged_row_ends_the_table(run):
    path = run / "history.csv"
    lines = path.read_text().split("\n")
    lines[11] = lines[11].replace("0.25", "0.2x", 1)
    path.write_text("\n".join(lines))
    _, remarks = build_report(run)
    assert "history.csv is damaged after 10 rows; what follows is left out." in remarks
    assert described(run / "report.html")["tables"]["history"]["rows"] == 10


def test_scene_that_this_version_does_not_take_is_shown_as_it_is(run):
    path = run / "scene.toml"
    path.write_text(path.read_text().replace("spectral_radius", "spectral_radio"))
    _, remarks = build_report(run)
    assert any("scene.toml" in remark and "spectral_radio" in remark for remark in remarks)
    rows = {(row.table, row.key): row.value for row in settings(read_run_files(run))}
    assert rows["integrator", "spectral_radio"] == "0.3" and rows["probe.0", "name"] == "tip"


def test_killed_run_gets_a_page(tmp_path):
    feed.feed(RunDirectory(tmp_path), feed.scene(), 0.5, kill=True)
    assert not (tmp_path / "report.html").exists()
    done = CliRunner().invoke(main, ["report", str(tmp_path)])
    assert done.exit_code == 0 and str(tmp_path / "report.html") in done.output
    assert "the run was killed or goes on" in done.output
    assert described(tmp_path / "report.html")["tables"]["history"]["rows"] == 21


def test_page_elsewhere(run, tmp_path):
    (run / "report.html").unlink()
    done = CliRunner().invoke(main, ["report", str(run), "--out", str(tmp_path / "page.html")])
    assert done.exit_code == 0
    assert (tmp_path / "page.html").exists() and not (run / "report.html").exists()


def test_folder_without_a_run_is_wrong_input(tmp_path):
    for folder in (tmp_path, tmp_path / "none"):
        done = CliRunner().invoke(main, ["report", str(folder)])
        assert done.exit_code == 2 and "DIR" in done.output
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match="folder of a run"):
        build_report(tmp_path)


@pytest.mark.parametrize("error", [OSError("No space left"), MemoryError(), ValueError("bug"), KeyboardInterrupt()])
def test_a_run_does_not_fail_by_its_page(tmp_path, monkeypatch, error):
    def broken(folder):
        raise error

    monkeypatch.setattr(run_directory, "build_report", broken)
    directory = RunDirectory(tmp_path)
    feed.feed(directory, feed.scene(), 0.5)
    assert directory.report_failure
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "done"


def test_full_disk_leaves_a_page_where_there_is_room_for_it(tmp_path, monkeypatch):
    def simulate(scene, observer, **options):
        feed.feed(observer, scene, 0.5, kill=True)
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(sys.modules, "warp_origami.solve.simulate", types.SimpleNamespace(simulate=simulate))
    (tmp_path / "bending.toml").write_text(feed.scene().to_toml())
    done = CliRunner().invoke(main, ["run", str(tmp_path / "bending.toml"), "--out", str(tmp_path / "out"), "--quiet"])
    assert done.exit_code == 3 and "No space left" in done.output
    assert described(tmp_path / "out" / "report.html")["tables"]["history"]["rows"] == 21


def test_message_and_advice_of_a_failed_run(tmp_path):
    feed.feed(
        RunDirectory(tmp_path), feed.scene(), 0.5, status="failed", message="stopped at 0.5 s", advice="a <finer> mesh"
    )
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "stopped at 0.5 s" in text and "a &lt;finer&gt; mesh" in text
    assert 'class="status failed"' in text and "reached 0.5 s" in text


def test_old_page_does_not_outlive_its_run(run):
    directory = RunDirectory(run)
    directory.start(feed.scene(), feed.SURFACE, None)
    assert not (run / "report.html").exists()


def test_points_on_creases_are_split_between_their_sides():
    surface = feed.SURFACE
    vertices, triangles = split_at_creases(surface.triangles, surface.creases)
    assert np.array_equal(vertices[triangles], surface.triangles)
    on_crease = np.unique(surface.creases)
    assert len(vertices) == len(surface.flat) + len(on_crease)
    left = surface.flat[surface.triangles].mean(axis=1)[:, 0] < 0.5
    assert not set(triangles[left].ravel()) & set(triangles[~left].ravel())


def test_rim_is_the_outline():
    x, y = feed.SURFACE.flat[rim(feed.SURFACE.triangles)].transpose(2, 0, 1)
    assert np.all(((x == 0) | (x == 1)).all(axis=1) | ((y == 0) | np.isclose(y, 0.6)).all(axis=1))
    assert len(x) == 2 * (4 * 4 + 2 * 4)
    assert segments(np.array([[3, 5, 4]])).tolist() == [[3, 5], [5, 4]]


def unpacked(blob, name):
    """What the page does, in Python: an array of a blob."""
    number, entry = next((k, entry) for k, entry in enumerate(blob.index) if entry["name"] == name)
    planes = np.frombuffer(zlib.decompress(base64.b64decode(blob.text()[number])), dtype=np.uint8)
    size = int(entry["kind"][1:])
    values = np.ascontiguousarray(planes.reshape(size, -1).T).view("<" + entry["kind"]).reshape(entry["shape"])
    return np.cumsum(values, axis=0, dtype=values.dtype) if entry["differences"] else values


def test_arrays_come_back():
    rng = np.random.default_rng(1)
    blob = Blob()
    whole = rng.integers(0, 65536, (5, 7, 3)).astype(np.uint16)
    blob.add("whole", whole, differences=True)
    blob.add("real", np.array([1.5, -np.pi, np.nan, np.inf]))
    assert np.array_equal(unpacked(blob, "whole"), whole)
    assert np.array_equal(unpacked(blob, "real"), [1.5, -np.pi, np.nan, np.inf], equal_nan=True)


def test_positions_and_fields_keep_their_precision(run):
    sheet = draw_sheet(AnimationFile(run / "animation.usdc"))
    points = sheet.origin + sheet.step * unpacked(sheet.blob, "positions")
    for frame in (0, 7, 20):
        assert np.abs(points[frame] - feed.bent(feed.SURFACE.flat, frame / feed.FPS)).max() < 0.51 * 1.0 / 65535 + 1e-7
    stress = unpacked(sheet.blob, "field von_mises").view(np.float16).astype(float) * sheet.ranges["von_mises"].scale
    assert np.allclose(stress[20], 1e6 * feed.SURFACE.flat[:, 0], rtol=1 / 2048)
    found = sheet.ranges["von_mises"]
    assert (found.least, found.largest) == (0.0, pytest.approx(1e6))
    assert found.low == 0.0 and 0.5e6 < found.high < 1e6
    assert (sheet.ranges["state"].low, sheet.ranges["state"].high) == (0.0, 2.0)


def test_large_runs_leave_out_frames(run, monkeypatch):
    whole = draw_sheet(AnimationFile(run / "animation.usdc"))
    monkeypatch.setattr("warp_origami.output.report.drawn_sheet.LARGEST_UNPACKED", 10_000)
    unpacked_limit = draw_sheet(AnimationFile(run / "animation.usdc"))
    assert unpacked_limit.stride > 1
    monkeypatch.undo()
    fewer = draw_sheet(AnimationFile(run / "animation.usdc"), largest=whole.blob.size // 3)
    assert fewer.stride >= 4 and fewer.blob.size <= whole.blob.size // 3 and fewer.in_file == 21
    times = unpacked(fewer.blob, "times")
    assert (times[0], times[-1]) == (0.0, 1.0) and len(times) == fewer.frames
    monkeypatch.setattr("warp_origami.output.report.page.draw_sheet", lambda animation: fewer)
    _, remarks = build_report(run)
    assert any(f"{fewer.frames} of 21 frames" in remark for remark in remarks)


def test_thinned_tables_lose_no_peak():
    rng = np.random.default_rng(2)
    values = np.column_stack([np.arange(1001.0), rng.normal(size=1001), np.zeros(1001)])
    values[617, 1], values[618, 1] = 50.0, -60.0
    short = thinned(Table(("time", "a", "b"), values), most=100)
    assert len(short) == 100 and np.all(np.diff(short.values[:, 0]) >= 0)
    assert (short.values[:, 1].max(), short.values[:, 1].min()) == (50.0, -60.0)
    assert (short.values[0, 0], short.values[-1, 0]) == (0.0, 1000.0)
    assert thinned(short, most=100) is short


def test_columns_that_are_not_known_are_plotted_too(run):
    path = run / "history.csv"
    heading, *rows = path.read_text().split("\n")
    path.write_text("\n".join([heading + ",spin_rate,hinge_energy", *(row + ",3.5,1.0" for row in rows[:-1]), ""]))
    found = {chart.title: chart for chart in charts(read_run_files(run))}
    assert [curve.label for curve in found["spin rate"].curves] == ["spin_rate"]
    assert [curve.label for curve in found["Energies"].curves] == ["kinetic", "strain", "hinge"]
    assert "Contacts" not in found  # zero throughout
    assert {chart.group for chart in found.values() if chart.section == "probes"} == {"tip"}


def lead(folder):
    """The line below the heading of the page, without its date."""
    build_report(folder)
    text = (folder / "report.html").read_text(encoding="utf-8")
    return re.search(r'<p class="lead">(.*?) · files of', text)[1]


def test_run_that_was_to_end_early_says_so(run, tmp_path):
    assert lead(run) == "Motion in time · 1 s"
    feed.feed(RunDirectory(tmp_path / "short"), feed.scene(duration=6.0), 0.5)
    assert lead(tmp_path / "short") == "Motion in time · 0.5 of 6 s (--until)"
    scene = tmp_path / "short" / "scene.toml"
    scene.write_text(scene.read_text().replace('kind = "dynamic"\nduration = 6.0', 'kind = "static"'))
    assert lead(tmp_path / "short") == "Equilibrium · load factor 0.5 of 1 (--until)"


def test_spin_is_plotted_and_told_with_units(run):
    columns = "time,rate,moment_of_inertia,angular_momentum.x,angular_momentum.y,angular_momentum.z"
    (run / "spin.csv").write_text(f"{columns}\n0.0,0.5,234.0,0.0,0.0,117.0\n1.0,0.45,260.0,0.0,0.0,117.0\n")
    found = [chart for chart in charts(read_run_files(run)) if chart.table == "spin"]
    assert [(chart.title, chart.unit, [curve.label for curve in chart.curves]) for chart in found] == [
        ("Rate of spin", "rad/s", ["rate"]),
        ("Moment of inertia about the axis", "kg m²", ["moment of inertia"]),
        ("Angular momentum", "N m s", ["z"]),
    ]
    momentum = {"angular_momentum": [1.68e-17, -4.0772538579232126e-16, 121.67307703650295]}
    assert result_rows({"mass": 294.072064, "angular_momentum_change": -5.5789e-5} | momentum) == [
        ("Mass", "294.1 kg"),
        ("Angular momentum (x, y, z), end", "(0, 0, 121.7) N m s"),
        ("Its change about the axis", "-0.00558 % of the first value"),
    ]


def test_energy_lost_is_told_against_what_was_put_in():
    columns = ("time", "kinetic_energy", "strain_energy", "contact_energy", "external_work", "energy_error")
    rows = np.array([[0.0, 1.0, 1.0, 0.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0, 6.0, -3.0], [2.0, 2.0, 1.0, 0.0, 4.0, -2.0]])
    energy = energy_put_in(Table(columns, rows))
    assert (energy.supplied, energy.lost) == (8.0, 3.0)
    told = dict(result_rows({"energy_loss": 1.0}, energy))
    assert told == {"Energy lost": "100 % of the largest energy at one time, 37.5 % of the energy put in"}
    assert energy_put_in(Table(columns[:-1], rows[:, :-1])) is None


def test_page_says_where_lost_energy_goes(run):
    path = run / "summary.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"energy_loss": 0.1}))
    build_report(run)
    assert "algorithmic damping" in (run / "report.html").read_text(encoding="utf-8")


def test_summary_in_words():
    rows = dict(
        result_rows(
            {
                "elements": 12345,
                "max_penetration": 2.5e-6,
                "energy_gain": 0.001,
                "status": "done",
                "new": 3,
                "gone": None,
            }
        )
    )
    assert rows == {
        "Elements": "12 345",
        "Largest penetration": "2.5 µm",
        "Energy created": "0.1 % of the largest energy at one time",
        "new": "3",
    }
    assert model_rows({"nts_stiffness": 3e6, "terms": ["inertia", "drivers"], "elements": 3}) == [
        ("Modelled", "inertia, drivers"),
        ("Contact stiffness, node to surface", "3e6 N/m"),
    ]
