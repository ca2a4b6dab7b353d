"""Any input is refused in words or run, scene and FOLD files that have been tampered with among them."""

import os
import tempfile
from pathlib import Path

import fuzz_input
import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import feed
import warp_origami as wo
from warp_origami.cli import main
from warp_origami.errors import InputError
from warp_origami.model.fold import read_fold
from warp_origami.model.generators import build_pattern
from warp_origami.model.limits import MOST_CORNERS, MOST_ELEMENTS
from warp_origami.output.run_directory import RunDirectory
from warp_origami.scene.toml import LARGEST_FILE

HEALTH = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example]


@settings(max_examples=120, deadline=None, derandomize=True, database=None, suppress_health_check=HEALTH)
@given(st.randoms(use_true_random=False))
def test_an_input_that_has_been_tampered_with_is_refused_or_run(chance):
    with tempfile.TemporaryDirectory() as place:
        path = fuzz_input.write_input(Path(place), chance)
        kind, said = fuzz_input.tried(Path(place), path)
        assert kind in ("refused", "run", "numerics failed"), said


@pytest.mark.slow
def test_two_thousand_inputs(capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["fuzz_input.py", "--inputs", "2000", "--seed", "3"])
    assert fuzz_input.main() == 0


def refused(tmp_path, text):
    """The message for a scene file with this content, given to the command line."""
    path = tmp_path / "s.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    ended = CliRunner().invoke(main, ["run", str(path), "--out", str(tmp_path / "out"), "--quiet"])
    assert ended.exit_code == 2, ended.output
    assert not (tmp_path / "out").exists()
    return ended.stderr


def scene_with(**tables):
    return wo.Scene(**(feed.scene().model_dump(exclude_none=True) | tables)).to_toml()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (b"x = 1\n" * LARGEST_FILE, f"at most {LARGEST_FILE} bytes"),
        ("x = " + "[" * 5000, "nested"),
        ("x = " + "[" * 40 + "]" * 40, "nested too deeply"),
        ("a" + ".a" * 100_000 + " = 1", "more than 16 parts"),
        ("x = " + "9" * 5000, "4300 digits"),
        (b"\xff\xfe", "UTF-8"),
        ("at = [" + "[1]," * 100_000 + "]", "name: got nothing"),
    ],
    ids=["large", "open", "deep", "long key", "digits", "bytes", "faults"],
)
def test_files_beyond_the_limits_are_refused_at_once(tmp_path, text, says):
    assert says in refused(tmp_path, text)


@pytest.mark.parametrize(
    ("override", "key", "says"),
    [
        ("material.thickness=1e-300", "material.thickness", "1e-30 to 1e+30"),
        ("material.density=1e300", "material.density", "1e-30 to 1e+30"),
        ("material.youngs_modulus=1e20", "material.youngs_modulus", "<= 1e15"),
        ("analysis.duration=1e29", "output.fps", "frames"),
        ("output.fps=1e12", "output.fps", "1000000 frames"),
        ("integrator.step=1e-20", "integrator.step", "100000000 steps"),
        ("analysis={kind='static',load_steps=1000001}", "analysis.load_steps", "<= 100000"),
        ("analysis={kind='modal',count=10001}", "analysis.count", "<= 10000"),
        ("pattern.nx=1000000000", "pattern.nx", "at most 10000000"),
        (f"pattern.nx={10**400}", "pattern.nx", "integer of 1329 bits"),
        (f'name="{"x" * 101}"', "name", "100 characters"),
        (f'probe.0.name="{"x" * 101}"', "probe.0.name", "100 characters"),
        ('support.0.name="../x"', "support.0.name", "letters"),
        ('pattern={kind="fold",file="a\\u0000b"}', "pattern.file", "no file is"),
        (f'pattern={{kind="fold",file="{"x" * 5000}"}}', "pattern.file", "no file is"),
        ('pattern={kind="fold",file="/dev/zero"}', "pattern.file", "no file is"),
    ],
    ids=lambda value: value[:30],
)
def test_numbers_and_names_beyond_the_limits_are_refused_in_words(tmp_path, override, key, says):
    path = tmp_path / "s.toml"
    path.write_text(scene_with())
    with pytest.raises(wo.InputError) as caught:
        wo.load_scene(path, [override])
    assert caught.value.key == key
    assert says in f"{caught.value.got} {caught.value.wants}"
    assert len(str(caught.value)) < 700


@pytest.mark.parametrize(
    "pattern",
    [
        {"kind": "sheet", "nx": 5000, "ny": 5000},
        {"kind": "sheet", "nx": 10, "ny": 10, "refine": 1000},
        {"kind": "miura", "nx": 5000, "ny": 5000, "a": 1.0, "b": 1.0, "sector_angle": 1.0},
        {"kind": "disc", "rings": 100_000, "radius": 1.0},
        {"kind": "annulus", "rings": 1000, "inner_radius": 1.0, "outer_radius": 1.0001},
        {"kind": "leaf_in", "refine": 10_000_000},
    ],
    ids=lambda pattern: pattern["kind"],
)
def test_sheets_that_would_eat_the_memory_are_refused_before(tmp_path, pattern):
    said = refused(tmp_path, scene_with(pattern=pattern, support=[], probe=[]))
    assert str(MOST_ELEMENTS) in said and said.startswith("pattern.")


def test_fold_files_beyond_the_limits_are_refused(tmp_path):
    path = tmp_path / "x.fold"
    corners = MOST_CORNERS + 1
    path.write_text(
        f'{{"vertices_coords": {[[i, i * i] for i in range(corners)]}, "faces_vertices": [{list(range(corners))}]}}'
    )
    with pytest.raises(wo.InputError, match=f"3 to {MOST_CORNERS} vertices"):
        read_fold(path)
    path.write_text('{"file_frames": [' + ", ".join(["{}"] * 2000) + "]}")
    with pytest.raises(wo.InputError, match="2000 frames, wants at most 1000"):
        read_fold(path)
    os.mkfifo(tmp_path / "pipe.fold")
    with pytest.raises(wo.InputError, match="no regular file"):
        read_fold(tmp_path / "pipe.fold")


def test_a_pipe_is_no_scene(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(wo.InputError, match="regular file"):
        wo.load_scene(tmp_path / "pipe.toml")


RESULTS = (
    "scene.toml",
    "animation.usdc",
    "history.csv",
    "probes.csv",
    "reactions.csv",
    "summary.json",
    "report.html",
    "checkpoint.npz",
)


@pytest.mark.parametrize("resumed", [False, True])
def test_links_in_the_folder_of_a_run_are_replaced_and_never_followed(tmp_path, resumed):
    """Whatever lies there, nothing outside of the folder is written to."""
    folder, outside = tmp_path / "run", tmp_path / "outside"
    folder.mkdir()
    outside.mkdir()
    scene = feed.scene()
    if resumed:
        feed.feed(RunDirectory(folder), scene, 0.5, status="interrupted")
    for name in RESULTS:
        stem, _, ending = name.partition(".")
        target = outside / name
        if resumed:
            (folder / name).rename(target)
        else:
            target.write_text("precious")
        (folder / name).symlink_to(target)
        (folder / f".{stem}.partial.{ending}").symlink_to(target)
    before = {path.name: path.read_bytes() for path in outside.iterdir()}
    feed.feed(RunDirectory(folder), scene, 1.0, start=20 if resumed else 0)
    assert {path.name: path.read_bytes() for path in outside.iterdir()} == before
    assert sorted(path.name for path in folder.iterdir()) == sorted(RESULTS)
    assert not any(path.is_symlink() for path in folder.iterdir())


def test_parameters_that_leave_no_room_for_a_face_are_refused():
    with pytest.raises(InputError, match=r"pattern: got a square_twist with faces that have no area"):
        build_pattern("square_twist", {"angle": 8e-10})
