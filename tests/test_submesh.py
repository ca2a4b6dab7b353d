"""The split of elements into sub-triangles."""

import numpy as np
import pytest

from contact_meshes import grid, joined, mesh_of
from warp_origami.model.coordinates import number_coordinates
from warp_origami.model.mesh import BOUNDARY, CREASE
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.shapes import tabulate


def two_faces():
    """A rectangle of 4 x 2 cells with a crease along x = 0."""
    return mesh_of(*grid(4, 2, (2.0, 1.0)), lambda m: np.abs(m[:, 0]) < 1e-9)


@pytest.mark.parametrize("k", [1, 2, 3, 5])
def test_covers_the_sheet_once(k):
    mesh = two_faces()
    sub = build_submesh(mesh, k)
    assert len(sub.triangles) == k * k * len(mesh.triangles)
    np.testing.assert_allclose(sub.triangle_areas, np.repeat(mesh.areas / k**2, k * k), rtol=1e-12)
    # Euler's formula of a disc: no point is there twice and none is missing
    sides = np.sort(np.stack([sub.triangles, np.roll(sub.triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    assert len(sub.flat) - len(np.unique(sides, axis=0)) + len(sub.triangles) == 1
    assert len(np.unique(sub.flat.round(9), axis=0)) == len(sub.flat)


def test_points_are_where_their_area_coordinates_say():
    mesh = two_faces()
    sub = build_submesh(mesh, 3)
    np.testing.assert_allclose(
        np.einsum("pk,pkd->pd", sub.areas, mesh.vertices[mesh.triangles[sub.elements]]), sub.flat
    )
    corners = sub.flat[sub.triangles].mean(axis=1)
    centroid = mesh.vertices[mesh.triangles[sub.triangle_elements]].mean(axis=1)
    assert np.all(np.linalg.norm(corners - centroid, axis=1) < 0.5)


def test_mesh_vertices_come_first():
    mesh = two_faces()
    sub = build_submesh(mesh, 4)
    nv = len(mesh.vertices)
    np.testing.assert_array_equal(sub.flat[:nv], mesh.vertices)


def test_idle_vertices_are_left_out():
    vertices, triangles = grid(1, 1)
    mesh = mesh_of(np.vstack([[9.0, 9.0], vertices]), triangles + 1)
    sub = build_submesh(mesh, 2)
    np.testing.assert_array_equal(sub.flat[:4], vertices)
    assert sub.triangles.min() == 0


def test_positions_of_shared_points_agree_between_elements():
    """A point on a bent sheet is the same whichever of its elements interpolates it, also across a crease."""
    mesh = two_faces()
    coordinates = number_coordinates(mesh)
    q = np.random.default_rng(0).normal(size=(coordinates.count, 3))
    for v in np.flatnonzero(np.abs(mesh.vertices[:, 0]) < 1e-9):  # the fold condition along x = 0: one r_y
        r_y = coordinates.sector_gradients[coordinates.sector_vertices == v] + 1
        q[r_y] = q[r_y[0]]
    k = 4
    sub = build_submesh(mesh, k)
    positions = tabulate(mesh, sub.elements, sub.areas).interpolation(coordinates) @ q
    area = np.zeros((len(sub.triangles), 3, 3))
    corners = mesh.vertices[mesh.triangles[sub.triangle_elements]]
    system = np.concatenate([corners.transpose(0, 2, 1), np.ones((len(area), 1, 3))], axis=1)
    for m in range(3):
        right = np.concatenate([sub.flat[sub.triangles[:, m]], np.ones((len(area), 1))], axis=1)
        area[:, m] = np.linalg.solve(system, right[..., None])[..., 0]
    own = tabulate(mesh, np.repeat(sub.triangle_elements, 3), area.reshape(-1, 3)).interpolation(coordinates) @ q
    np.testing.assert_allclose(own, positions[sub.triangles.ravel()], atol=1e-11)


def test_creases_run_along_the_edges():
    mesh = two_faces()
    sub = build_submesh(mesh, 3)
    a, b = mesh.vertices[mesh.edges[mesh.edge_kinds == CREASE]].transpose(1, 0, 2)
    assert len(sub.creases) == len(a) == 2
    s = np.linspace(0, 1, 4)[None, :, None]
    np.testing.assert_allclose(sub.flat[sub.creases], a[:, None] * (1 - s) + b[:, None] * s, atol=1e-14)


def test_outer_boundary_of_faces():
    mesh = two_faces()
    sub = build_submesh(mesh, 3)
    x, y = np.abs(sub.flat).T
    rim, crease = (x > 1 - 1e-9) | (y > 0.5 - 1e-9), x < 1e-9
    np.testing.assert_array_equal(sub.outer_corners, (rim | crease)[sub.triangles])
    middle = 0.5 * (sub.flat[sub.triangles] + sub.flat[np.roll(sub.triangles, -1, axis=1)])
    x, y = np.abs(middle).transpose(2, 0, 1)
    np.testing.assert_array_equal(sub.outer_edges, (x > 1 - 1e-9) | (y > 0.5 - 1e-9) | (x < 1e-9))


def test_crease_ending_inside_a_face_is_no_outer_boundary():
    mesh = mesh_of(*grid(4, 4), lambda m: (np.abs(m[:, 0]) < 1e-9) & (m[:, 1] < 0))
    sub = build_submesh(mesh, 2)
    assert len(sub.creases) == 2 and len(np.unique(sub.triangle_faces)) == 1
    inside = np.abs(sub.flat[sub.triangles]).max(axis=2) < 0.5 - 1e-9
    assert not np.any(sub.outer_corners & inside)


def test_lips_of_a_slit_keep_their_own_points():
    """Two elements cut apart along their common edge, both ends of which stay joined to the rest."""
    vertices, triangles = grid(2, 2)
    mesh = mesh_of(vertices, triangles)
    d = int(np.flatnonzero(mesh.edge_triangles.min(axis=1) >= 0)[0])
    cut = mesh.edge_triangles[d]
    mesh.edge_kinds[d] = BOUNDARY
    lips = np.array([[cut[0], -1], [cut[1], -1]], dtype=np.int32)
    fields = {**mesh.__dict__}
    fields["edges"] = np.vstack([np.delete(mesh.edges, d, 0), mesh.edges[[d, d]]])
    fields["edge_triangles"] = np.vstack([np.delete(mesh.edge_triangles, d, 0), lips])
    fields["edge_kinds"] = np.append(np.delete(mesh.edge_kinds, d), [BOUNDARY, BOUNDARY]).astype(np.int8)
    slit = type(mesh)(**fields)
    k = 3
    sub = build_submesh(slit, k)
    assert len(sub.flat) == len(build_submesh(mesh_of(vertices, triangles), k).flat) + k - 1
    assert np.array_equal(np.unique(sub.triangles), np.arange(len(sub.flat)))


def test_large_mesh_is_split():
    mesh = mesh_of(*joined(grid(5, 5)))
    assert len(build_submesh(mesh, 4).triangles) == 16 * len(mesh.triangles)
    vertices, triangles = grid(160, 160)
    build_submesh(mesh_of(vertices, triangles), 4)
