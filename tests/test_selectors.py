"""Selectors on refined and cut meshes, and the slopes that held edges prescribe."""

import numpy as np
import pytest

from warp_origami.errors import InputError
from warp_origami.model.generators.sheet import sheet
from warp_origami.model.mesh import BOUNDARY, build_mesh
from warp_origami.model.refine import refine
from warp_origami.model.selectors import held_directions, select

PLAIN = sheet(2.0, 1.0, 2, 1).mesh
FINE = refine(PLAIN, 3)


def disc(n, creases=()):
    """Regular polygon around the origin, in n triangles; spokes in `creases` are creases."""
    angles = 2 * np.pi * np.arange(n) / n
    points = np.concatenate([[[0, 0]], np.stack([np.cos(angles), np.sin(angles)], axis=1)])
    triangles = [(0, 1 + k, 1 + (k + 1) % n) for k in range(n)]
    return build_mesh(points, triangles, np.array([(0, 1 + k) for k in creases]).reshape(-1, 2), ["V"] * len(creases))


def points_of(mesh, at):
    return sorted(map(tuple, np.round(mesh.vertices[select(at, mesh).vertices], 9).tolist()))


def rows_at(mesh, at, point):
    """Held directions at a point of the flat sheet, as (element, direction)."""
    rows = held_directions(mesh, select(at, mesh))
    return [(e, along) for v, e, along in rows if np.linalg.norm(mesh.vertices[v] - point) < 1e-9]


def test_near_takes_the_closest_given_vertex_and_of_equals_the_first():
    assert select({"near": [0.9, 0.2]}, PLAIN).vertices.tolist() == [1]
    assert select({"near": [0.4, 0.0]}, FINE).vertices.tolist() == [0]  # a refined vertex is closer
    assert select({"near": [0.5, 0.5]}, PLAIN).vertices.tolist() == [0]
    assert select({"near": [0.5 + 1e-10, 0.5]}, PLAIN).vertices.tolist() == [0]
    assert select({"near": [0.5 + 1e-8, 0.5]}, PLAIN).vertices.tolist() == [1]


def test_boxes_are_closed_and_see_refined_vertices():
    assert points_of(PLAIN, {"box": [[0, 0], [0, 1]]}) == [(0, 0), (0, 1)]
    assert len(points_of(FINE, {"box": [[0, 0], [0, 1]]})) == 4
    assert len(points_of(FINE, {"box": [[0.1, 0.0], [1 / 3, 1 / 3]]})) == 2
    selection = select({"box": [[0, 0], [0, 1]]}, FINE)
    assert len(selection.edges) == 3
    assert not selection.whole


def test_boundary_and_all():
    rim = select({"boundary": True}, FINE)
    assert len(rim.vertices) == len(rim.edges) == 18
    everything = select({"all": True}, FINE)
    assert everything.whole
    assert len(everything.vertices) == len(FINE.vertices)
    assert len(everything.edges) == 18


def test_vertices_and_circle_add_what_refinement_puts_between_them():
    one_side = select({"vertices": [0, 1]}, FINE)
    assert np.allclose(points_of(FINE, {"vertices": [0, 1]}), [(0, 0), (1 / 3, 0), (2 / 3, 0), (1, 0)])
    assert len(one_side.edges) == 3
    assert select({"vertices": [0, 5]}, FINE).vertices.tolist() == [0, 5]  # no edge between them
    assert select({"vertices": [1, 4]}, FINE).vertices.tolist() == [1, 4]  # an edge, but inside the sheet
    fine_disc = refine(disc(12), 2)
    rim = select({"circle": [0, 0, 1]}, fine_disc)
    assert len(rim.vertices) == len(rim.edges) == 24
    assert len(select({"circle": [0, 0, 1 + 1e-7]}, fine_disc).vertices) == 24
    assert len(select({"circle": [0, 0, 1.01], "tol": 0.02}, fine_disc).vertices) == 24
    with pytest.raises(InputError):
        select({"circle": [0, 0, 1.01]}, fine_disc)


def test_file_numbers_select_all_copies_of_a_cut():
    mesh = build_mesh(PLAIN.vertices, PLAIN.triangles, [(1, 4)], ["C"])
    for m in (mesh, refine(mesh, 2)):
        selection = select({"vertices": [1, 4]}, m)
        assert len(selection.edges) == 2 * (1 if m is mesh else 2)
        assert len(selection.vertices) == (4 if m is mesh else 6)
    assert select({"near": [1, 0]}, mesh).vertices.tolist() == [1]


@pytest.mark.parametrize("at", [{"box": [[5, 5], [6, 6]]}, {"circle": [9, 9, 0.1]}, {"vertices": [0, 77]}])
def test_nothing_selected_is_an_error_that_names_the_key(at):
    with pytest.raises(InputError) as error:
        select(at, FINE, "support[0].at")
    assert error.value.key.startswith("support[0].at")


def test_straight_rims_hold_one_slope_and_corners_two():
    rows = held_directions(FINE, select({"boundary": True}, FINE))
    count = {}
    for v, e, along in rows:
        assert v in FINE.triangles[e]
        assert np.isclose(np.linalg.norm(along), 1, rtol=1e-14)
        count.setdefault(v, []).append(along)
    for v, directions in count.items():
        x, y = FINE.vertices[v]
        corner = x in (0, 2) and y in (0, 1)
        assert len(directions) == (2 if corner else 1)
        if not corner:
            assert np.allclose(np.abs(directions[0]), [1, 0] if y in (0, 1) else [0, 1], atol=1e-12)


def test_a_held_side_ends_with_its_own_slope():
    at = {"box": [[0, 0], [2, 0]]}
    for point in ((0, 0), (1, 0), (2, 0)):
        (row,) = rows_at(FINE, at, point)
        assert np.allclose(row[1], [1, 0])


def test_curved_rims_hold_the_mean_direction():
    mesh = disc(12)
    for v, _, along in held_directions(mesh, select({"boundary": True}, mesh)):
        assert abs(along @ mesh.vertices[v]) < 1e-12  # the tangent of the circle
    assert len(held_directions(mesh, select({"boundary": True}, mesh))) == 12
    octagon = disc(8)  # turns by 45 degrees exactly: corners
    assert len(held_directions(octagon, select({"boundary": True}, octagon))) == 16
    nonagon = disc(9)
    assert len(held_directions(nonagon, select({"boundary": True}, nonagon))) == 9


def test_a_crease_at_the_rim_gives_each_face_its_row():
    mesh = disc(12, creases=(0, 4, 8))
    rows = rows_at(mesh, {"boundary": True}, (1, 0))
    assert len(rows) == 2
    assert len({int(mesh.faces[e]) for e, _ in rows}) == 2
    assert all(np.allclose(along, [0, 1]) for _, along in rows)
    assert len(rows_at(mesh, {"boundary": True}, mesh.vertices[2])) == 1


def test_both_sides_of_a_cut_hold_one_slope_at_its_tip():
    grid = sheet(2.0, 2.0, 2, 2).mesh
    mesh = build_mesh(grid.vertices, grid.triangles, [(3, 4)], ["C"])
    (row,) = rows_at(mesh, {"box": [[0, 1], [1, 1]]}, (1, 1))
    assert np.allclose(np.abs(row[1]), [1, 0])
    assert (mesh.edge_kinds == BOUNDARY).sum() == 10
