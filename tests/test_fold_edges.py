"""FOLD files without faces: the faces lie between the edges, or the file is refused in words."""

import json

import numpy as np
import pytest

from warp_origami.errors import InputError
from warp_origami.model.fold import read_fold
from warp_origami.model.generators.miura import miura
from warp_origami.model.mesh import BOUNDARY, CREASE
from warp_origami.output.fold_run import write_pattern

RIM = [[i, (i + 1) % 4] for i in range(4)]
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


@pytest.fixture
def read(tmp_path):
    """Reads a FOLD file of vertices, edges and letters."""

    def read(points, edges, letters=None, **more):
        path = tmp_path / "edges.fold"
        content = {"vertices_coords": points, "edges_vertices": edges} | more
        path.write_text(json.dumps(content if letters is None else content | {"edges_assignment": list(letters)}))
        return read_fold(path)

    return read


def shifted(points, by):
    return [[x + by, y + by] for x, y in points]


def ring(count, radius, turn=0.0):
    angles = turn + 2.0 * np.pi * np.arange(count) / count
    return (radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)).tolist()


@pytest.mark.parametrize("letters", [None, "BBBBMVMV", "UUUUMVMV"])
def test_square_with_diagonals(read, letters):
    spokes = [[4, i] for i in range(4)]
    mesh = read([*SQUARE, [0.5, 0.5]], [*spokes, *RIM], None if letters is None else letters[4:] + letters[:4]).mesh
    assert len(np.unique(mesh.faces)) == 4
    assert np.isclose(mesh.areas.sum(), 1.0)
    assert ((mesh.edge_kinds == BOUNDARY).sum(), (mesh.edge_kinds == CREASE).sum()) == (4, 4)
    creases = sorted(mesh.edge_assignments[mesh.edge_kinds == CREASE].tolist())
    assert creases == (list("UUUU") if letters is None else list("MMVV"))


def test_waterbomb(read):
    points = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1], [1, 1]]
    edges = [[i, (i + 1) % 8] for i in range(8)] + [[8, i] for i in (0, 2, 4, 6, 3, 7)]
    pattern = read(points, edges, "BBBBBBBBVVVVMM")
    mesh = pattern.mesh
    assert len(np.unique(pattern.pattern_faces)) == 6
    assert np.isclose(mesh.areas.sum(), 4.0)
    assert (mesh.edge_kinds == CREASE).sum() == 6


def test_miura_without_its_faces_is_the_same_mesh(tmp_path):
    pattern = miura(4, 3, 0.1, 0.1, 1.0, 0.3)
    path = tmp_path / "miura.fold"
    write_pattern(path, pattern, "miura")
    content = json.loads(path.read_text())
    frame = next(f for f in [content, *content["file_frames"]] if "faces_vertices" in f)
    del frame["faces_vertices"]
    path.write_text(json.dumps(content))
    found = read_fold(path)

    def named(mesh, stowed):
        """Triangles, edges with letters, and positions, by the places of their corners."""
        places = [tuple(p) for p in np.round(mesh.vertices, 12).tolist()]
        triangles = {frozenset(places[v] for v in t) for t in mesh.triangles.tolist()}
        letters = zip(mesh.edges.tolist(), mesh.edge_assignments.tolist(), strict=True)
        edges = {(frozenset(places[v] for v in e), letter) for e, letter in letters if letter not in "FJ"}
        return triangles, edges, dict(zip(places, stowed.tolist(), strict=True))

    assert named(found.mesh, found.stowed) == named(pattern.mesh, pattern.stowed)


def test_separate_sheets(read):
    pattern = read(SQUARE + shifted(SQUARE, 3.0), RIM + [[a + 4, b + 4] for a, b in RIM])
    assert len(np.unique(pattern.pattern_faces)) == 2
    assert (pattern.mesh.edge_kinds == BOUNDARY).sum() == 8


def annulus():
    """Hexagon with a hexagonal hole, six creases between them, and a triangle of its own in the hole."""
    rims = [[[k + i, k + (i + 1) % 6] for i in range(6)] for k in (0, 6)]
    own = [[12, 13], [13, 14], [14, 12]]
    points = ring(6, 2.0) + ring(6, 1.0) + ring(3, 0.3)
    return points, rims[0] + rims[1] + own + [[i, 6 + i] for i in range(6)]


def test_boundaries_around_holes_and_sheets_inside_holes(read):
    mesh = read(*annulus(), "B" * 15 + "MV" * 3).mesh
    hexagon, triangle = 1.5 * np.sqrt(3.0), 0.75 * np.sqrt(3.0)
    assert np.isclose(mesh.areas.sum(), 3.0 * hexagon + 0.09 * triangle)
    assert len(np.unique(mesh.faces)) == 7
    assert (mesh.edge_kinds == BOUNDARY).sum() == 15


def test_a_cut_stays_a_cut(read):
    pattern = read([*SQUARE, [0.5, 0.5]], [*RIM, *([4, i] for i in range(4))], "BBBBCVVV")
    assert pattern.mesh.sources.tolist() == [0, 1, 2, 3, 4, 0]
    assert np.isclose(pattern.mesh.areas.sum(), 1.0)


def test_faces_of_the_folded_form_count(read):
    """Its faceOrders count its own faces."""
    points = [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]]
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]]
    folded = {
        "frame_classes": ["foldedForm"],
        "vertices_coords": [[0, 0], [1, 0], [0, 0], [0, 1], [1, 1], [0, 1]],
        "faces_vertices": [[1, 2, 3, 4], [0, 1, 4, 5]],
        "faceOrders": [[0, 1, 1]],
    }
    pattern = read(points, edges, "BBBBBBV", file_frames=[folded])
    assert pattern.mesh.vertices[pattern.mesh.triangles[pattern.pattern_faces == 0], 0].mean() > 1.0
    assert pattern.face_orders[0].tolist() == [0, 1, 1]


ISLAND = [[4, 5], [5, 6], [6, 4]]
SPOKES = [[4, 0], [4, 1], [4, 2], [4, 3]]
REFUSED = [
    (SQUARE, [*RIM, [0, 2], [1, 3]], None, "edges_vertices[5]", "[1, 3] across edge 4, [0, 2]"),
    ([*SQUARE, [0.5, 0]], [*RIM, [4, 2]], None, "edges_vertices[0]", "[0, 1] with vertex 4 on it"),
    ([*SQUARE, [0.5, 0.5]], [*RIM, [4, 2]], None, "edges_vertices[4]", "[4, 2] with the same region on both sides"),
    (SQUARE, RIM[:3], None, "edges_vertices[0]", "same region"),
    (SQUARE, [], None, "edges_vertices", "no edge"),
    ([*SQUARE, [1, 1]], [*RIM, [4, 0]], None, "vertices_coords[4]", "the place of vertex 2"),
    (
        SQUARE + [[0.5 + x, 0.5 + y] for x, y in ring(3, 0.1)],
        [*RIM, *ISLAND],
        None,
        "edges_vertices",
        "part",
    ),
    ([*SQUARE, [0.2, 0.5], [0.4, 0.8]], [*RIM, [0, 4], [4, 5], [5, 0]], None, "edges_vertices", "itself in vertex 0"),
    ([*SQUARE, [0.5, 0.5]], [*RIM, *SPOKES], "BBBBBVVV", "edges_assignment[4]", '"B"'),
    (SQUARE, [*RIM, [0, 2]], "BBMBV", "edges_assignment[2]", '"M"'),
]


@pytest.mark.parametrize(("points", "edges", "letters", "key", "got"), REFUSED)
def test_what_bounds_no_faces_is_refused_by_name(read, points, edges, letters, key, got):
    with pytest.raises(InputError) as error:
        read(points, edges, letters)
    assert error.value.key.endswith(f"edges.fold: {key}")
    assert got in str(error.value.got)
