"""The leaf-in square: counts, letters, stress-free and clear stowed state."""

import ipctk
import numpy as np
import pytest

from warp_origami.errors import InputError
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.generators.leaf_in import leaf_in
from warp_origami.model.mesh import BOUNDARY, CREASE, SMOOTH
from warp_origami.terms.contact.thickness import CREASE_RATIO

CONTACT_THICKNESS = 5e-4


def crosses(pattern):
    triangles = pattern.mesh.triangles
    mesh = ipctk.CollisionMesh(pattern.stowed, ipctk.edges(triangles), triangles)
    return ipctk.has_intersections(mesh, pattern.stowed)


def edge_at(pattern, a, b):
    """Edge of the mesh between two points of the flat sheet."""
    ends = {int(np.argmin(np.linalg.norm(pattern.mesh.vertices - p, axis=1))) for p in (a, b)}
    return next(d for d, edge in enumerate(pattern.mesh.edges.tolist()) if set(edge) == ends)


def point_triangle_distance(p, a, b, c):
    """(n,) distances of points (n, 3) from one triangle."""

    def to_segment(a, b):
        t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        return np.linalg.norm(p - a - t[:, None] * (b - a), axis=1)

    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    height = (p - a) @ normal
    foot = p - height[:, None] * normal
    inside = np.all([np.cross(v - u, foot - u) @ normal >= 0 for u, v in ((a, b), (b, c), (c, a))], axis=0)
    outline = np.min([to_segment(a, b), to_segment(b, c), to_segment(c, a)], axis=0)
    return np.where(inside, np.abs(height), outline)


def clearances(pattern, k=6):
    """Smallest distance between triangles without a common vertex, m, and smallest ratio of the distance of a point of
    a triangle from one that shares a vertex with it to the same distance in the flat sheet."""
    triangles = pattern.mesh.triangles
    bary = np.array([(i, j, k - i - j) for i in range(k + 1) for j in range(k + 1 - i)]) / k
    flat = np.pad(pattern.mesh.vertices, ((0, 0), (0, 1)))
    free, ratio = np.inf, np.inf
    for i in range(6):  # the eighths are alike
        for j in range(len(triangles)):
            if i == j or pattern.mesh.faces[i] == pattern.mesh.faces[j]:
                continue
            for one, two in ((triangles[i], triangles[j]), (triangles[j], triangles[i])):
                distance = point_triangle_distance(bary @ pattern.stowed[one], *pattern.stowed[two])
                if not set(triangles[i]) & set(triangles[j]):
                    free = min(free, distance.min())
                    continue
                in_sheet = point_triangle_distance(bary @ flat[one], *flat[two])
                off = in_sheet > 1e-9
                ratio = min(ratio, (distance[off] / in_sheet[off]).min())
    return free, ratio


def test_counts_and_size():
    mesh = leaf_in().mesh
    assert (len(mesh.triangles), len(mesh.vertices), len(np.unique(mesh.faces))) == (48, 29, 40)
    assert [(mesh.edge_kinds == kind).sum() for kind in (SMOOTH, CREASE, BOUNDARY)] == [8, 60, 8]
    assert np.isclose(mesh.areas.sum(), 0.36, rtol=1e-14)
    assert np.array_equal(np.ptp(mesh.vertices, axis=0), [0.6, 0.6])
    assert np.isclose(1420 * 5e-4 * mesh.areas.sum(), 0.2556, rtol=1e-12)


@pytest.mark.parametrize(("side", "inset", "corner"), [(0.6, None, None), (0.6, 0.012, 0.34), (7.0, None, None)])
def test_stowed_state_keeps_every_length(side, inset, corner):
    pattern = leaf_in(side, inset, corner)
    a, b = pattern.mesh.edges.T
    flat = np.linalg.norm(pattern.mesh.vertices[a] - pattern.mesh.vertices[b], axis=1)
    assert np.abs(np.linalg.norm(pattern.stowed[a] - pattern.stowed[b], axis=1) / flat - 1).max() < 1e-14
    angles = fold_angles(pattern.mesh, pattern.stowed)
    assert np.abs(angles[pattern.mesh.edge_kinds == SMOOTH]).max() < 1e-12


def test_stowed_state_is_mirror_symmetric_with_corners_at_height_zero():
    pattern = leaf_in()
    flat, stowed = pattern.mesh.vertices, pattern.stowed
    for mirror in (np.diag([-1.0, 1.0]), np.array([[0.0, 1.0], [1.0, 0.0]])):
        image = [int(np.argmin(np.linalg.norm(flat - x, axis=1))) for x in flat @ mirror.T]
        reflection = np.eye(3)
        reflection[:2, :2] = mirror
        assert np.abs(stowed @ reflection.T - stowed[image]).max() < 1e-15
    corners = np.abs(flat).min(axis=1) > 0.29
    assert corners.sum() == 4
    assert (stowed[corners, 2] == 0).all()
    assert np.allclose(np.linalg.norm(stowed[corners], axis=1), 0.312, rtol=1e-14)
    assert np.isclose(stowed[0, 2], -0.0945, atol=1e-4)


def test_mountains_and_valleys():
    pattern = leaf_in()
    letters = pattern.mesh.edge_assignments
    corner = [(0, 0), (0.1, 0.1), (0.2, 0.2), (0.3, 0.3)]
    middle = [(0, 0), (0.091, 0), (0.191, 0), (0.3, 0)]
    assert [letters[edge_at(pattern, *corner[k : k + 2])] for k in (1, 2)] == ["M", "V"]
    assert [letters[edge_at(pattern, x, (0.05, 0.05))] for x in (corner[0], corner[1])] == ["V", "V"]
    assert [letters[edge_at(pattern, *middle[k : k + 2])] for k in range(3)] == ["M", "V", "M"]
    assert [letters[edge_at(pattern, middle[k], corner[k])] for k in (1, 2, 3)] == ["M", "V", "B"]
    assert letters[edge_at(pattern, middle[1], (0.05, 0.05))] == "F"


def test_default_layers_are_clear_of_each_other():
    pattern = leaf_in()
    assert not crosses(pattern)
    free, ratio = clearances(pattern)
    assert free > 5 * CONTACT_THICKNESS
    assert ratio > 2 * CREASE_RATIO  # the crease rule of contact then leaves the start without force


def test_without_inset_the_path_is_the_strain_free_mechanism():
    """Centre heights against the corner, derived independently."""
    for corner, height in ((0.36215, -0.04455), (0.37982, -0.06079), (0.39759, -0.05571), (0.41528, -0.03582)):
        pattern = leaf_in(inset=0.0, corner_distance=corner)
        assert np.isclose(pattern.stowed[0, 2], height, atol=6e-6)
        assert not crosses(pattern)


def test_crossing_start_is_seen_by_the_oracle():
    assert crosses(leaf_in(corner_distance=0.304))


@pytest.mark.parametrize(
    ("parameters", "key"),
    [
        ({"side": 0.0}, "pattern.side"),
        ({"inset": 0.2}, "pattern.inset"),
        ({"corner_distance": 0.29}, "pattern.corner_distance"),
        ({"corner_distance": 0.43}, "pattern.corner_distance"),
    ],
)
def test_bad_parameters_are_named(parameters, key):
    with pytest.raises(InputError) as error:
        leaf_in(**parameters)
    assert error.value.key == key
