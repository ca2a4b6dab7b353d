"""FOLD files that are written: what FOLD 1.2 says, and the same pattern, start and states when read back."""

import json

import numpy as np
import pytest

import warp_origami as wo
from runs import system_of
from warp_origami.errors import InputError
from warp_origami.model.fold import read_fold
from warp_origami.model.fold_writer import State, fold_document
from warp_origami.model.generators import build_pattern
from warp_origami.model.refine import refine_pattern
from warp_origami.output.fold_run import write_pattern, write_run
from warp_origami.output.run_directory import RunDirectory
from warp_origami.scene import Scene

PATTERNS = [
    ("leaf_in", {}),
    ("leaf_out", {"opening": 0.0}),
    ("miura", {"nx": 3, "ny": 2, "a": 0.1, "b": 0.08, "sector_angle": 1.0, "opening": 0.0}),
    ("z_fold", {"opening": 0.0}),
    ("cross_fold", {"strips": 3, "side": 2.0, "hub": 0.3}),
    ("square_twist", {"assignment": "classic", "nx": 2}),
    ("sheet", {"width": 1.0, "height": 0.5}),
]
CUT = {
    "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1], [1, 2], [2, 2], [0, 2]],
    "edges_vertices": [[1, 4], [4, 6], [3, 4], [4, 5]],
    "edges_assignment": ["C", "M", "V", "F"],
    "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4], [4, 3, 7, 6], [5, 4, 6, 8]],
}


def same(one, two):
    names = ("vertices", "triangles", "edges", "edge_triangles", "edge_kinds", "edge_assignments", "faces")
    return all(np.array_equal(getattr(one.mesh, name), getattr(two.mesh, name)) for name in names)


@pytest.mark.parametrize(("kind", "parameters"), PATTERNS)
@pytest.mark.parametrize("refine", [1, 2])
def test_pattern_reads_back_bit_by_bit(tmp_path, kind, parameters, refine):
    pattern = refine_pattern(build_pattern(kind, parameters), refine)
    write_pattern(tmp_path / "x.fold", pattern, kind)
    read = read_fold(tmp_path / "x.fold")
    assert same(pattern, read)
    assert (pattern.stowed is None) == (read.stowed is None)
    assert pattern.stowed is None or np.array_equal(pattern.stowed, read.stowed)
    assert bool(len(pattern.face_orders)) == bool(len(read.face_orders))


def test_document_is_fold_1_2():
    pattern = build_pattern("leaf_out", {"opening": 0.0})
    document = json.loads(json.dumps(fold_document(pattern, "leaf", "me")))
    assert document["file_spec"] == 1.2 and document["frame_unit"] == "m"
    assert document["file_classes"] == ["singleModel"] and document["frame_classes"] == ["creasePattern"]
    assert {len(point) for point in document["vertices_coords"]} == {2}
    edges = len(document["edges_vertices"])
    assert len(document["edges_assignment"]) == edges and set(document["edges_assignment"]) <= set("MVBJ")
    (stowed,) = document["file_frames"]
    assert stowed["frame_classes"] == ["foldedForm"] and stowed["frame_inherit"] is True and stowed["frame_parent"] == 0
    assert {len(point) for point in stowed["vertices_coords"]} == {3}
    assert len(stowed["vertices_coords"]) == len(document["vertices_coords"])
    angles = dict(zip(map(tuple, document["edges_vertices"]), stowed["edges_foldAngle"], strict=True))
    letters = dict(zip(angles, document["edges_assignment"], strict=True))
    assert all(-180 <= angles[e] <= 180 for e in angles)
    assert all((angles[e] > 0) - (angles[e] < 0) == {"M": -1, "V": 1}.get(letters[e], 0) for e in angles)
    faces = len(document["faces_vertices"])
    assert all(f != g and max(f, g) < faces and s in (-1, 1) for f, g, s in stowed["faceOrders"])


def test_faces_are_counter_clockwise_and_orders_are_about_their_normals():
    """Of a closed fan the second panel lies below the first one, which is not turned over: see the generator."""
    document = fold_document(build_pattern("z_fold", {"strips": 2, "opening": 0.0, "columns": 1}), "fan", "me")
    points = np.array(document["vertices_coords"])
    for face in document["faces_vertices"]:
        u, v = points[face[1]] - points[face[0]], points[face[2]] - points[face[0]]
        assert u[0] * v[1] - u[1] * v[0] > 0
    (line,) = [k for k, letter in enumerate(document["edges_assignment"]) if letter in "MV"]
    orders = document["file_frames"][0]["faceOrders"]
    # a valley brings the upper sides together: each face lies on the side of the other's normal, a mountain not
    wanted = 1 if document["edges_assignment"][line] == "V" else -1
    assert {s for _, _, s in orders} == {wanted}


def test_scene_from_the_file_starts_where_the_generator_does(tmp_path):
    """Layers that coincide are opened in the same way: the same bits, also refined."""
    write_pattern(tmp_path / "x.fold", build_pattern("leaf_out", {"opening": 0.0, "strips": 2}), "x")
    given = {
        "name": "x",
        "analysis": {"kind": "dynamic", "duration": 1.0},
        "material": {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 1e-4},
        "contact": {"method": "mixed"},
    }
    own = system_of(Scene(**given, pattern={"kind": "leaf_out", "opening": 0.0, "strips": 2, "refine": 2}))
    read = system_of(Scene(**given, pattern={"kind": "fold", "file": str(tmp_path / "x.fold"), "refine": 2}))
    assert np.abs(own.q0 - read.q0).max() < 1e-15
    assert np.abs(own.q0[own.coordinates.positions] - own.pattern.stowed).max() > 1e-5


@pytest.fixture
def run_folder(tmp_path):
    scene = wo.Scene(
        name="opens",
        analysis={"kind": "dynamic", "duration": 2e-3},
        pattern={"kind": "square_twist", "refine": 2},
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 1e-4},
        load=[{"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}],
        output={"fps": 2000},
    )
    result = wo.simulate(scene, observers=[RunDirectory(tmp_path / "run")])
    return tmp_path / "run", scene, result


def test_run_becomes_frames_that_inherit_the_pattern(run_folder):
    folder, scene, result = run_folder
    count = write_run(folder / "animation.fold", folder)
    document = json.loads((folder / "animation.fold").read_text())
    assert document["file_classes"] == ["singleModel", "animation"]
    stowed, *states = document["file_frames"]
    assert count == 2 + len(states) and len(states) == len(result.frames)
    assert "warp_origami:time" not in stowed
    for state, frame in zip(states, result.frames, strict=True):
        assert np.isclose(state["warp_origami:time"], frame.time, rtol=0, atol=1e-9)
        assert np.abs(np.array(state["vertices_coords"]) - frame.nodes).max() < 1e-7
        assert state["frame_inherit"] and state["frame_parent"] == 0 and "faces_vertices" not in state
    own = build_pattern(scene.pattern.kind, scene.pattern.parameters())
    read = read_fold(folder / "animation.fold")
    assert same(own, read) and np.array_equal(own.stowed, read.stowed)


def test_killed_run_gives_what_was_saved(run_folder):
    """No summary, no checkpoint: the animation alone is needed. Without it the message says so."""
    folder, _, _ = run_folder
    for name in ("summary.json", "checkpoint.npz", "history.csv"):
        (folder / name).unlink()
    assert write_run(folder / "x.fold", folder) > 3
    (folder / "animation.usdc").unlink()
    with pytest.raises(InputError, match=r"without animation\.usdc"):
        write_run(folder / "y.fold", folder)
    assert not (folder / "y.fold").exists()


def test_states_of_a_flat_start_are_no_stowed_state():
    pattern = build_pattern("sheet", {"width": 1.0, "height": 1.0})
    states = [State(0.0, np.column_stack([1.1 * pattern.mesh.vertices, np.zeros(4)]))]
    document = fold_document(pattern, "sheet", "me", states)
    assert document["file_frames"][0]["frame_classes"] == ["foldedForm", "warp_origami:state"]


def test_cuts_are_one_line_of_the_pattern_and_open_in_states(tmp_path):
    (tmp_path / "cut.fold").write_text(json.dumps({"file_spec": 1.2} | CUT))
    pattern = read_fold(tmp_path / "cut.fold")
    apart = np.column_stack([pattern.mesh.vertices, np.linspace(0.0, 1.0, len(pattern.mesh.vertices))])
    document = fold_document(pattern, "cut", "me", [State(0.5, apart)])
    assert document["edges_assignment"].count("C") == 1
    opened, state = document["file_frames"]
    assert opened["edges_assignment"].count("C") == 0 and len(opened["vertices_coords"]) == len(apart)
    assert state["frame_parent"] == 1 and state["vertices_coords"] == apart.tolist()
    (tmp_path / "again.fold").write_text(json.dumps(document))
    again = read_fold(tmp_path / "again.fold")
    assert same(pattern, again) and again.stowed is None
