"""Edges, faces, cuts and refinement of triangulated patterns."""

import numpy as np
import pytest

from warp_origami.errors import InputError
from warp_origami.model.connectivity import ConnectivityError
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.generators import build_pattern
from warp_origami.model.generators.leaf_in import leaf_in
from warp_origami.model.generators.sheet import sheet
from warp_origami.model.mesh import BOUNDARY, CREASE, SMOOTH, build_mesh, signed_areas
from warp_origami.model.planar import find_collision
from warp_origami.model.refine import interpolation, refine, refine_pattern
from warp_origami.model.triangulate import polygon_area, triangulate

GRID = np.array([[i, j] for j in range(3) for i in range(4)], dtype=float)  # vertex i + 4 j
CELLS = np.array([(a, a + 1, a + 5) for a in (0, 1, 2, 4, 5, 6)] + [(a, a + 5, a + 4) for a in (0, 1, 2, 4, 5, 6)])


def euler(mesh):
    return len(mesh.vertices) - len(mesh.edges) + len(mesh.triangles)


def assert_consistent(mesh):
    """What every mesh promises."""
    assert (mesh.areas > 0).all()
    sides = [{(t[0], t[1]), (t[1], t[2]), (t[2], t[0])} for t in mesh.triangles.tolist()]
    for edge, (left, right), kind in zip(mesh.edges.tolist(), mesh.edge_triangles, mesh.edge_kinds, strict=True):
        assert tuple(edge) in sides[left]
        assert (right < 0) == (kind == BOUNDARY)
        if right >= 0:
            assert tuple(edge[::-1]) in sides[right]
            assert kind == CREASE or mesh.faces[left] == mesh.faces[right]
    assert np.bincount(mesh.edge_triangles[mesh.edge_triangles >= 0]).tolist() == [3] * len(mesh.triangles)
    letters = {SMOOTH: {"F"}, CREASE: {"M", "V", "U"}, BOUNDARY: {"B"}}
    assert all(letter in letters[kind] for kind, letter in zip(mesh.edge_kinds, mesh.edge_assignments, strict=True))


def test_clockwise_triangles_are_turned_and_unused_vertices_left_out():
    mesh = build_mesh(np.vstack([[9.0, 9.0], GRID]), CELLS[:, ::-1] + 1)
    assert_consistent(mesh)
    assert mesh.sources.tolist() == list(range(1, 13))
    assert len(np.unique(mesh.faces)) == 1


def test_creases_divide_faces():
    mesh = build_mesh(GRID, CELLS, [(5, 1), (5, 9)], ["M", "V"])
    assert_consistent(mesh)
    assert len(np.unique(mesh.faces)) == 2
    assert sorted(mesh.edge_assignments[mesh.edge_kinds == CREASE]) == ["M", "V"]


@pytest.mark.parametrize(
    ("cuts", "copies", "sheets"),
    [
        ([(5, 6)], [], 1),  # both ends are tips: a slit, whose two sides share them
        ([(4, 5), (5, 6)], [4, 5], 1),
        ([(4, 5), (5, 6), (6, 7)], [4, 5, 6, 7], 2),
        ([(1, 5), (5, 9), (4, 5), (5, 6)], [1, 4, 5, 5, 5, 9], 3),
    ],
)
def test_cuts_copy_vertices_where_they_part_the_sheet(cuts, copies, sheets):
    mesh = build_mesh(GRID, CELLS, cuts, ["C"] * len(cuts))
    assert_consistent(mesh)
    assert mesh.sources[12:].tolist() == copies
    assert np.array_equal(mesh.vertices[12:], GRID[copies])
    assert len(np.unique(mesh.faces)) == sheets
    assert (mesh.edge_kinds == BOUNDARY).sum() == 10 + 2 * len(cuts)
    fine = refine(refine(mesh, 2), 3)
    assert_consistent(fine)
    assert euler(fine) == euler(mesh)
    assert (fine.edge_kinds == BOUNDARY).sum() == 6 * (10 + 2 * len(cuts))


def test_impossible_edges_are_refused():
    with pytest.raises(ConnectivityError, match="3 triangles"):
        build_mesh(GRID, [(0, 1, 5), (0, 5, 4), (0, 5, 8)])
    with pytest.raises(ConnectivityError, match="same side"):
        build_mesh(GRID, [(0, 1, 5), (0, 1, 6)])
    with pytest.raises(ConnectivityError, match="no face"):
        build_mesh(GRID, CELLS, [(0, 11)], ["M"])
    with pytest.raises(ConnectivityError, match="boundary"):
        build_mesh(GRID, CELLS, [(5, 6)], ["B"])


@pytest.mark.parametrize("n", [2, 3, 5])
def test_refinement_splits_into_similar_triangles_and_inherits_edges(n):
    pattern = sheet(3.0, 2.0, 3, 2, diagonal="alternate", creases_x=(1, 2), opening=1.2)
    mesh, fine = pattern.mesh, refine(pattern.mesh, n)
    assert_consistent(fine)
    assert np.array_equal(fine.vertices[: len(mesh.vertices)], mesh.vertices)
    assert np.array_equal(fine.sources[: len(mesh.vertices)], mesh.sources)
    assert (fine.sources[len(mesh.vertices) :] == -1).all()
    assert np.allclose(fine.areas, np.repeat(mesh.areas, n * n) / n**2, rtol=1e-12)
    assert np.array_equal(fine.faces, np.repeat(mesh.faces, n * n))
    for kind in (CREASE, BOUNDARY):
        assert (fine.edge_kinds == kind).sum() == n * (mesh.edge_kinds == kind).sum()
    assert euler(fine) == euler(mesh)

    added = fine.boundary_parents[:, 0] >= 0
    assert added.sum() == (n - 1) * (mesh.edge_kinds == BOUNDARY).sum()
    a, b = (fine.vertices[fine.boundary_parents[added, k]] for k in (0, 1))
    x = fine.vertices[added]
    gap = np.linalg.norm(x - a, axis=1) + np.linalg.norm(b - x, axis=1) - np.linalg.norm(b - a, axis=1)
    assert np.abs(gap).max() < 1e-14


def test_refined_stowed_state_stays_isometric():
    pattern = refine_pattern(leaf_in(), 4)
    a, b = pattern.mesh.edges.T
    flat = np.linalg.norm(pattern.mesh.vertices[a] - pattern.mesh.vertices[b], axis=1)
    assert np.abs(np.linalg.norm(pattern.stowed[a] - pattern.stowed[b], axis=1) / flat - 1).max() < 1e-13
    assert np.array_equal(pattern.pattern_faces, np.repeat(np.arange(48), 16))
    assert np.allclose(interpolation(leaf_in().mesh, 4).sum(axis=1), 1, atol=1e-15)


def test_fan_has_the_opening_angle_and_valley_first():
    pattern = sheet(3.0, 1.0, 3, 1, origin=(1.0, 2.0), creases_x=(1, 2), opening=2.0)
    angles = fold_angles(pattern.mesh, pattern.stowed)
    letters = pattern.mesh.edge_assignments
    assert np.allclose(angles[letters == "V"], np.pi - 2.0, atol=1e-12)
    assert np.allclose(angles[letters == "M"], 2.0 - np.pi, atol=1e-12)
    assert np.allclose(angles[letters == "F"], 0.0, atol=1e-12)
    assert np.allclose(pattern.stowed[0], [1, 2, 0])
    upright = sheet(1.0, 3.0, 1, 3, creases_y=(1, 2), opening=2.0)
    assert sorted(np.round(fold_angles(upright.mesh, upright.stowed), 9)[upright.mesh.edge_kinds == CREASE]) == sorted(
        np.round([np.pi - 2.0, 2.0 - np.pi], 9)
    )


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"width": -1.0}, "pattern.width"),
        ({"nx": 0}, "pattern.nx"),
        ({"diagonal": "left"}, "pattern.diagonal"),
        ({"creases_x": (4,)}, "pattern.creases_x"),
        ({"opening": 1.0}, "pattern.opening"),
        ({"opening": 4.0, "creases_x": (1,)}, "pattern.opening"),
        ({"colour": 1}, "pattern"),
        ({"refine": 0}, "pattern.refine"),
    ],
)
def test_bad_sheet_parameters_are_named(changes, key):
    with pytest.raises(InputError) as error:
        build_pattern("sheet", {"width": 1.0, "height": 1.0, "nx": 4, "ny": 4} | changes)
    assert error.value.key == key


def test_polygons_lose_no_vertex():
    square = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    arrow = [(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)]
    needle = [(0, 0), *[(k / 9, 0) for k in range(1, 9)], (1, 0), (0.5, 1)]
    comb = [p for k in range(8) for p in ((k, 1), (k + 0.5, 9))] + [(8, 1), (8, 0), (0, 0)]
    for polygon in (square, arrow, needle, comb):
        for points in (np.array(polygon, float), np.array(polygon[::-1], float)):
            triangles = triangulate(points)
            areas = signed_areas(points, triangles)
            assert (areas > 1e-6).all()
            assert np.isclose(areas.sum(), abs(polygon_area(points.tolist())), rtol=1e-12)
            assert sorted(set(triangles.ravel().tolist())) == list(range(len(points)))


def test_triangulation_takes_the_better_diagonal():
    kite = np.array([(0.0, 0.0), (5.0, -1.0), (10.0, 0.0), (5.0, 1.0)])
    assert all({1, 3} <= set(t) for t in triangulate(kite).tolist())


@pytest.mark.parametrize(
    "polygon",
    [
        [(0, 0), (1, 1), (1, 0), (0, 1)],
        [(0, 0), (1, 0), (2, 0)],
        [(0, 0), (1, 0), (1, 0), (1, 1)],
        [(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)],
        [(0, 0), (1, 0), (1, 1e-12)],
    ],
)
def test_polygons_that_are_not_simple_have_no_triangles(polygon):
    assert triangulate(np.array(polygon, float)) is None


def test_collisions_are_found_whatever_the_sizes():
    mesh = sheet(1.0, 1.0, 30, 30).mesh
    assert find_collision(mesh.vertices, mesh.triangles, 1e-9) is None
    rng = np.random.default_rng(1)
    for _ in range(20):
        apart = rng.uniform(0.05, 0.95, 2)
        tiny = apart + 1e-4 * np.array([[0, 0], [1, 0], [0, 1]])
        points = np.concatenate([mesh.vertices, tiny])
        triangles = np.concatenate([mesh.triangles, len(mesh.vertices) + np.array([[0, 1, 2]])])
        collision = find_collision(points, triangles, 1e-9)
        assert collision is not None and len(mesh.triangles) in collision.triangles
    hanging = np.array([[0, 0], [2, 0], [0, 2], [0.5, 0], [0.7, -1], [1.2, 0]], float)
    collision = find_collision(hanging, np.array([[0, 1, 2], [3, 4, 5]]), 1e-9)
    assert collision.vertex in (3, 5)
