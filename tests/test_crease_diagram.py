"""The crease diagram, and the commands that draw and write patterns."""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner
from warp_origami.scenes import bundled_scenes

from warp_origami.cli import main
from warp_origami.model.fold import read_fold
from warp_origami.model.generators import GENERATORS, build_pattern
from warp_origami.output.crease_diagram import STYLES, crease_diagram

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(main, [str(a) for a in arguments])


def groups(text):
    return {group.get("class"): group for group in ET.fromstring(text).iter(f"{SVG}g") if group.get("class")}


def test_kinds_of_lines_differ_in_colour_and_in_dashes():
    assert len({style.colour for style in STYLES.values()}) == len(STYLES)
    assert len({style.dashes for style in STYLES.values()}) == len(STYLES)


def test_drawing_has_every_line_at_its_place():
    """Leaf-out: a square, veins, midribs and medians; x to the right, y upwards."""
    mesh = build_pattern("leaf_out", {"side": 0.6, "strips": 3, "columns": 3}).mesh
    found = groups(crease_diagram(mesh, "leaf"))
    points = lambda kind: [  # noqa: E731
        [tuple(map(float, p.split(","))) for p in line.get("points").split()]
        for line in found[kind].iter(f"{SVG}polyline")
    ]
    assert len(points("B")) == 4
    # straight lines are one: two medians, the inner and the outer parts of the midribs, the veins
    assert len(points("M")) + len(points("V")) == 2 + 2 + 8 + 16
    corners = np.array([p for line in points("B") for p in line])
    assert np.allclose(np.ptp(corners, axis=0), 720.0, atol=0.02)
    names = {int(text.text): (float(text.get("x")), float(text.get("y"))) for text in found["names"]}
    assert sorted(names) == list(range(len(mesh.vertices)))
    upper, lower = (int(np.argmax(mesh.vertices @ [0.1, sign])) for sign in (1.0, -1.0))
    assert names[upper][1] < names[lower][1]


def test_text_is_escaped_and_scale_bar_is_round():
    text = crease_diagram(build_pattern("sheet", {"width": 1.0, "height": 0.1}).mesh, "a < b & c")
    texts = [element.text for element in ET.fromstring(text).iter(f"{SVG}text")]
    assert "a < b & c" in texts and "200 mm" in texts and "1 m x 100 mm" in texts


def test_cuts_are_drawn_once(tmp_path, command):
    content = {
        "file_spec": 1.2,
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
        "edges_vertices": [[1, 4]],
        "edges_assignment": ["C"],
        "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
    }
    (tmp_path / "cut.fold").write_text(json.dumps(content))
    assert command("draw", "cut.fold").exit_code == 0
    found = groups((tmp_path / "cut.svg").read_text())
    assert len(list(found["C"])) == 1 and len(list(found["B"])) == 6
    assert len(list(found["names"])) == 6


@pytest.mark.parametrize("name", sorted(GENERATORS))
def test_every_generator_is_drawn_and_written(command, tmp_path, name):
    for verb, suffix in (("draw", "svg"), ("fold", "fold")):
        ended = command(verb, name)
        assert ended.exit_code == 0, ended.output
        assert (tmp_path / f"{name}.{suffix}").stat().st_size < 200_000
    assert len(read_fold(tmp_path / f"{name}.fold").mesh.triangles)


def test_scenes_and_files_are_drawn(command, tmp_path):
    assert "two_sheets" in bundled_scenes()
    assert command("draw", "two_sheets").exit_code == 0
    assert command("draw", "hard/miura", "--out", "m.svg").exit_code == 0
    assert (
        command("fold", "leaf_out", "--set", "strips=5", "--set", "pattern.opening=0", "--out", "l.fold").exit_code == 0
    )
    assert len(read_fold(tmp_path / "l.fold").face_orders)
    assert command("draw", "l.fold").exit_code == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["l.fold", "l.svg", "m.svg", "two_sheets.svg"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("draw", "waterbomb"), "PATTERN: got 'waterbomb', wants a generator (annulus, cross_fold"),
        (("draw", "no.fold"), "pattern.file: got "),
        (("draw", "no.toml"), "scene: got 'no.toml'"),
        (("draw", "leaf_out", "--out", "x.png"), "--out: got 'x.png', wants a file name that ends in .svg"),
        (("draw", "leaf_out", "--out", "no/x.svg"), "--out: got 'no/x.svg', wants a file in a folder that exists"),
        (("draw", "leaf_out", "--set", "strips=0"), "pattern.strips: got 0, wants an integer from 1 to 200"),
        (("draw", "leaf_out", "--set", "rings=2"), "pattern.rings: got an unknown key"),
        (("fold", "leaf_out", "--out", "x.json"), "--out: got 'x.json', wants a file name that ends in .fold"),
        (("fold", "."), "SOURCE: got the folder '.' without scene.toml, wants the folder of a run"),
    ],
)
def test_wrong_input_is_told_in_a_line_and_nothing_is_written(command, tmp_path, arguments, message):
    ended = command(*arguments)
    assert ended.exit_code == 2
    assert ended.stderr.startswith(message)
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_not_replaced_by_what_is_read_from_it(command, tmp_path):
    command("fold", "leaf_out", "--out", "l.fold")
    before = (tmp_path / "l.fold").read_bytes()
    assert command("fold", "l.fold").exit_code == 2
    assert (tmp_path / "l.fold").read_bytes() == before


def test_the_pattern_of_a_scene_is_not_replaced_by_that_of_the_same_name(command, tmp_path):
    """The scene mine.toml has its pattern in mine.fold, where `fold mine.toml` would write."""
    command("fold", "z_fold", "--out", "mine.fold")
    before = (tmp_path / "mine.fold").read_bytes()
    (tmp_path / "mine.toml").write_text(
        'name = "mine"\nanalysis = { kind = "static" }\npattern = { kind = "fold", file = "mine.fold", refine = 2 }\n'
        "material = { density = 1.0, youngs_modulus = 1e9, poisson_ratio = 0.3, thickness = 1e-3 }\n"
    )
    ended = command("fold", "mine.toml")
    assert ended.exit_code == 2
    assert ended.stderr.startswith("--out: got 'mine.fold', which exists, wants the name of a new file")
    assert (tmp_path / "mine.fold").read_bytes() == before
    assert command("fold", "mine.toml", "--out", "other.fold").exit_code == 0
