"""FOLD files: what is read, and what is refused with a message that names key and index."""

import copy
import json

import numpy as np
import pytest

from warp_origami.errors import InputError
from warp_origami.model.fold import read_fold
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.mesh import BOUNDARY, CREASE
from warp_origami.model.pattern_report import describe_pattern

FOLDED = [[0, 0, 0], [1, 0, 0], [1.6, 0, 0.8], [1.6, 1, 0.8], [1, 1, 0], [0, 1, 0]]
BOOK = {
    "file_spec": 1.2,
    "frame_classes": ["creasePattern"],
    "frame_unit": "cm",
    "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
    "faces_vertices": [[0, 1, 4, 5], [1, 4, 3, 2]],  # the second one clockwise
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
    "edges_assignment": list("BBBBBBV"),
    "faceOrders": [[0, 1, 1], [1, 0, 1]],
    "file_frames": [{"frame_classes": ["foldedForm"], "frame_inherit": True, "vertices_coords": FOLDED}],
}
VALLEY = float(np.degrees(np.arctan2(0.8, 0.6)))


@pytest.fixture
def read(tmp_path):
    """Reads a FOLD file with the given content."""

    def read(content):
        path = tmp_path / "pattern.fold"
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            path.write_text(content if isinstance(content, str) else json.dumps(content))
        return read_fold(path)

    return read


def changed(**entries):
    """The book with entries replaced, or left out where the value is ...; `a__2` is element 2 of a."""
    book = copy.deepcopy(BOOK)
    for path, value in entries.items():
        *way, last = [int(step) if step.isdigit() else step for step in path.split("__")]
        owner = book
        for step in way:
            owner = owner[step]
        if value is ...:
            del owner[last]
        else:
            owner[last] = value
    return book


def test_pattern_and_folded_form(read):
    pattern = read(BOOK)
    mesh = pattern.mesh
    assert np.allclose(mesh.vertices, 0.01 * np.array(BOOK["vertices_coords"]), rtol=1e-15)
    assert np.allclose(pattern.stowed, 0.01 * np.array(FOLDED), rtol=1e-15)
    assert (mesh.areas > 0).all()
    assert pattern.pattern_faces.tolist() == [0, 0, 1, 1]
    assert mesh.edge_assignments[mesh.edge_kinds == CREASE].tolist() == ["V"]
    # Face 1 has been turned, so what lies over its normal in the file lies under it now; face 0 has not.
    assert pattern.face_orders.tolist() == [[0, 1, -1], [1, 0, 1]]


def test_folded_key_frame_with_the_crease_pattern_in_file_frames(read):
    content = changed(frame_classes=["foldedForm"], vertices_coords=FOLDED)
    content["file_frames"] = [
        {"frame_classes": ["creasePattern"], "frame_inherit": True, "vertices_coords": BOOK["vertices_coords"]}
    ]
    pattern = read(content)
    assert np.allclose(pattern.stowed, 0.01 * np.array(FOLDED))
    assert np.allclose(pattern.mesh.vertices, 0.01 * np.array(BOOK["vertices_coords"]))


def test_frames_inherit_through_their_parents(read):
    frames = [
        {"frame_inherit": True, "frame_parent": 0, "frame_title": "between", "vertices_coords": FOLDED},
        {"frame_classes": ["foldedForm"], "frame_inherit": True, "frame_parent": 1, "vertices_coords": FOLDED},
    ]
    assert np.allclose(read(changed(file_frames=frames)).stowed, 0.01 * np.array(FOLDED))


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("m", 1), ("mm", 1e-3), ("um", 1e-6), ("nm", 1e-9), ("in", 0.0254), ("pt", 0.0254 / 72), ("unit", 1), (..., 1)],
)
def test_units(read, unit, metres):
    pattern = read(changed(frame_unit=unit))
    assert np.isclose(np.ptp(pattern.mesh.vertices[:, 0]), 2 * metres, rtol=1e-15)
    assert np.isclose(pattern.stowed[2, 2], 0.8 * metres, rtol=1e-15)


def test_fold_angles_give_the_stowed_state(read):
    content = changed(file_frames=..., edges_foldAngle=[0, None, 0, 0, 0, 0, VALLEY])
    assert np.allclose(read(content).stowed, 0.01 * np.array(FOLDED), atol=1e-15)
    assert read(changed(file_frames=..., edges_foldAngle=[0] * 7)).stowed is None
    assert read(changed(file_frames=...)).stowed is None


def test_rounded_coordinates_are_a_stowed_state(read):
    """What lengths change by is the strain the run starts with: `check` says how much."""
    rounded = [[*point[:2], point[2] + 1e-5] if point[2] else point for point in FOLDED]
    pattern = read(changed(file_frames__0__vertices_coords=rounded))
    assert np.array_equal(pattern.stowed, 0.01 * np.array(rounded))
    assert "strain 8e-06" in dict(describe_pattern(pattern))["stowed state"]


def degree_four(angle):
    """Square with four perpendicular creases from the middle: rigid only if folded along one line at a time."""
    corners = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1], [1, 1]]
    rim = [[i, (i + 1) % 8] for i in range(8)]
    spokes = [[8, 1], [8, 3], [8, 5], [8, 7]]
    return {
        "vertices_coords": corners,
        "faces_vertices": [[8, 7, 0, 1], [8, 1, 2, 3], [8, 3, 4, 5], [8, 5, 6, 7]],
        "edges_vertices": rim + spokes,
        "edges_assignment": list("BBBBBBBBUUUU"),
        "edges_foldAngle": [0] * 8 + angle,
    }


def test_fold_angles_must_close_around_vertices(read):
    pattern = read(degree_four([50.0, 0.0, 50.0, 0.0]))
    angles = np.degrees(fold_angles(pattern.mesh, pattern.stowed))
    assert sorted(np.round(angles[np.abs(angles) > 1e-6], 9)) == [50, 50]
    read(degree_four([180.0, 90.0, 180.0, -90.0]))  # folded in half, then again
    with pytest.raises(InputError, match=r"edges_foldAngle: got panels that miss .* vertex \d"):
        read(degree_four([50.0, 30.0, 50.0, 0.0]))


def test_cuts_separate_and_numbers_are_those_of_the_file(read):
    mesh = read(changed(edges_assignment=list("BBBBBBC"))).mesh
    assert mesh.sources.tolist() == [0, 1, 2, 3, 4, 5, 1, 4]
    assert (mesh.edge_kinds == BOUNDARY).sum() == 8
    assert len(np.unique(mesh.faces)) == 2


def test_vertices_without_faces_are_ignored(read):
    content = changed(vertices_coords=[[9, 9], *BOOK["vertices_coords"]], file_frames=..., edges_assignment=...)
    for key in ("faces_vertices", "edges_vertices"):
        content[key] = [[v + 1 for v in row] for row in content[key]]
    mesh = read(content).mesh
    assert mesh.sources.tolist() == [1, 2, 3, 4, 5, 6]
    assert sorted(mesh.edge_assignments.tolist()) == ["B"] * 6 + ["F", "F", "U"]


def test_separate_sheets(read):
    far = [[x + 5, y] for x, y in BOOK["vertices_coords"]]
    content = {
        "vertices_coords": BOOK["vertices_coords"] + far,
        "faces_vertices": [*BOOK["faces_vertices"], [6, 7, 10, 11], [7, 8, 9, 10]],
    }
    mesh = read(content).mesh
    assert len(mesh.vertices) - len(mesh.edges) + len(mesh.triangles) == 2


def test_faces_with_straight_corners_and_bays_are_triangulated(read):
    """A frame around a window, in two C-shaped faces; the left face has a vertex in the middle of a side."""
    points = [[0, 0], [2, 0], [4, 0], [4, 4], [2, 4], [0, 4], [0, 2], [1, 1], [2, 1], [3, 1], [3, 3], [2, 3], [1, 3]]
    faces = [[0, 1, 8, 7, 12, 11, 4, 5, 6], [1, 2, 3, 4, 11, 10, 9, 8]]
    mesh = read({"vertices_coords": points, "faces_vertices": faces}).mesh
    assert np.isclose(mesh.areas.sum(), 12.0)
    assert len(mesh.vertices) == 13
    assert (mesh.edge_kinds == BOUNDARY).sum() == 13
    assert (mesh.edge_kinds == CREASE).sum() == 2
    assert len(np.unique(mesh.faces)) == 2


BENT = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 0.5, np.sqrt(0.5)]]

REFUSED = [
    ({"vertices_coords__2": [2, 0, 0.1]}, "vertices_coords[2][2]", "0.1"),
    ({"vertices_coords__2": [2, "a"]}, "vertices_coords[2][1]", '"a"'),
    ({"vertices_coords__2": [2, float("nan")]}, "vertices_coords[2][1]", "NaN"),
    ({"vertices_coords__2": [True, 0]}, "vertices_coords[2][0]", "true"),
    ({"vertices_coords__2": [2]}, "vertices_coords[2]", "[2]"),
    ({"vertices_coords": []}, "vertices_coords", "[]"),
    ({"vertices_coords": "x"}, "vertices_coords", '"x"'),
    ({"vertices_coords__2": [0.5, 0.5]}, "faces_vertices[1]", "[1, 4, 3, 2]"),
    ({"faces_vertices": ...}, "faces_vertices", "nothing"),  # and faceOrders
    ({"faces_vertices": ..., "faceOrders": ..., "edges_vertices": ...}, "faces_vertices", "nothing"),
    ({"faces_vertices": []}, "faces_vertices", "[]"),
    ({"faces_vertices__0": [0, 1]}, "faces_vertices[0]", "[0, 1]"),
    ({"faces_vertices__0": [0, 1, 9]}, "faces_vertices[0][2]", "9"),
    ({"faces_vertices__0": [0, 1, 1.0]}, "faces_vertices[0][2]", "1.0"),
    ({"faces_vertices__0": [0, 1, 4, 4]}, "faces_vertices[0]", "[0, 1, 4, 4]"),
    ({"faces_vertices": [[0, 1, 4, 5], [1, 4, 3, 2], [1, 4, 3]]}, "faces_vertices[2]", "[1, 4, 3]"),
    ({"edges_vertices": ..., "edges_assignment": ..., "faces_vertices": [[0, 1, 4, 5]] * 2}, "faces_vertices[1]", ""),
    ({"edges_vertices": ...}, "edges_vertices", "nothing"),
    ({"edges_vertices__6": [0, 4]}, "edges_vertices[6]", "[0, 4]"),
    ({"edges_vertices__6": [1, 1]}, "edges_vertices[6]", "[1, 1]"),
    ({"edges_vertices__6": [1, 0]}, "edges_vertices[6]", "[1, 0]"),
    ({"edges_vertices__6": ..., "edges_assignment__6": ...}, "faces_vertices[1]", "side [1, 4]"),
    ({"edges_assignment__6": "B"}, "edges_assignment[6]", '"B"'),
    ({"edges_assignment__1": "M"}, "edges_assignment[1]", '"M"'),
    ({"edges_assignment__6": "X"}, "edges_assignment[6]", '"X"'),
    ({"edges_assignment__6": ...}, "edges_assignment", "6 entries"),
    ({"edges_assignment__6": "J"}, "file_frames[0].vertices_coords", "edge 6"),
    ({"edges_foldAngle": [0] * 6 + [-30]}, "edges_foldAngle[6]", "-30"),
    ({"edges_foldAngle": [30] * 6 + [30]}, "edges_foldAngle[0]", "30"),
    ({"edges_foldAngle": [0] * 6 + [200]}, "edges_foldAngle[6]", "200"),
    ({"edges_foldAngle": [0]}, "edges_foldAngle", "1 entries"),
    ({"frame_unit": "furlong"}, "frame_unit", '"furlong"'),
    ({"faceOrders": [[0, 5, 1]]}, "faceOrders[0]", "[0, 5, 1]"),
    ({"faceOrders": [[0, 1, 2]]}, "faceOrders[0]", "[0, 1, 2]"),
    ({"frame_classes": ["foldedForm"]}, "vertices_coords", "no frame"),
    ({"file_frames": 3}, "file_frames", "3"),
    ({"file_frames": [3]}, "file_frames[0]", "3"),
    ({"file_frames__0__frame_parent": 5}, "file_frames[0].frame_parent", "5"),
    ({"file_frames__0__frame_parent": 1}, "file_frames[0].frame_parent", "1"),
    ({"file_frames__0__frame_classes": "foldedForm"}, "file_frames[0].frame_classes", '"foldedForm"'),
    ({"file_frames__0__vertices_coords": [[0, 0]]}, "file_frames[0].vertices_coords", "1 points"),
    ({"file_frames__0__vertices_coords__2": [1.6, 0, 0.8002]}, "file_frames[0].vertices_coords", "edge 1"),
]


@pytest.mark.parametrize(("entries", "key", "got"), REFUSED)
def test_wrong_files_are_refused_by_name(read, entries, key, got):
    with pytest.raises(InputError) as error:
        read(changed(**entries))
    assert error.value.key.endswith(f"pattern.fold: {key}")
    assert got in str(error.value.got)


@pytest.mark.parametrize(
    ("content", "got"),
    [
        ("{", "property name"),
        ("", "Expecting value"),
        ("[1]", "[1]"),
        ("{}", "no frame"),
        ("[" * 100_000, "nested"),
        ('{"vertices_coords": ' + "9" * 5000 + "}", "4300"),
        (b"\xff\xfe{}", "UTF-8"),
    ],
)
def test_what_is_no_fold_file_is_refused(read, content, got):
    with pytest.raises(InputError) as error:
        read(content)
    assert got in str(error.value.got)


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.fold: got No such file"):
        read_fold(tmp_path / "nowhere.fold")


@pytest.mark.parametrize(
    ("points", "faces", "key", "got"),
    [
        ([[0, 0], [2, 0], [0, 2], [0.5, 0.5], [2, 3], [0.4, 3]], [[0, 1, 2], [3, 4, 5]], "faces_vertices", "overlap"),
        ([[0, 0], [9, 0], [0, 9], [1, 1], [2, 1], [1, 2]], [[0, 1, 2], [3, 4, 5]], "faces_vertices", "overlap"),
        ([[0, 0], [2, 0], [0, 2], [1, 0], [2, -1], [1, -1]], [[0, 1, 2], [3, 4, 5]], "faces_vertices", "vertex 3"),
        ([[0, 0], [1, 0], [0, 1], [1, 0], [2, 0], [2, 1]], [[0, 1, 2], [3, 4, 5]], "vertices_coords[3]", "vertex 1"),
    ],
)
def test_flat_faces_lie_side_by_side(read, points, faces, key, got):
    with pytest.raises(InputError) as error:
        read({"vertices_coords": points, "faces_vertices": faces})
    assert key in error.value.key
    assert got in error.value.got


def test_bent_faces_are_no_stowed_state(read):
    square = {
        "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]],
        "faces_vertices": [[0, 1, 2, 3]],
        "file_frames": [{"frame_classes": ["foldedForm"], "vertices_coords": BENT}],
    }
    with pytest.raises(InputError, match=r"vertices_coords: got the line between vertices"):
        read(square)
