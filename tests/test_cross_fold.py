"""The cross fold of a spinning sail: two states without strain, flat and stowed around the hub."""

import ipctk
import numpy as np
import pytest

from warp_origami.errors import InputError
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.generators import build_pattern
from warp_origami.model.generators.cross_fold import cross_fold
from warp_origami.model.mesh import BOUNDARY, CREASE, SMOOTH

SAILS = [
    {},
    {"hub": 0.0, "strips": 5},
    {"side": 2.0, "hub": 0.6, "strips": 2, "columns": 1},
    {"strips": 4, "opening": 1.2, "columns": 7},
    {"strips": 3, "hub": 2.0, "slits": 0.6},
]


@pytest.mark.parametrize("sail", SAILS)
def test_stowed_sail_is_free_of_strain_and_does_not_cross(sail):
    pattern = cross_fold(**sail)
    mesh = pattern.mesh
    a, b = mesh.edges.T
    flat = np.linalg.norm(mesh.vertices[a] - mesh.vertices[b], axis=1)
    assert np.abs(np.linalg.norm(pattern.stowed[a] - pattern.stowed[b], axis=1) / flat - 1.0).max() < 1e-13
    angles = fold_angles(mesh, pattern.stowed)
    assert np.abs(angles[mesh.edge_kinds == SMOOTH]).max() < 1e-12
    oracle = ipctk.CollisionMesh(pattern.stowed, ipctk.edges(mesh.triangles), mesh.triangles)
    assert not ipctk.has_intersections(oracle, pattern.stowed)
    creases = mesh.edge_kinds == CREASE
    assert (np.where(angles > 0, "V", "M") == mesh.edge_assignments)[creases].all()


@pytest.mark.parametrize("sail", SAILS)
def test_flat_sail_is_a_square_with_a_square_opening(sail):
    pattern = cross_fold(**sail)
    side, hub, strips = (sail.get(key, value) for key, value in (("side", 14.0), ("hub", 1.2), ("strips", 10)))
    slits = 2e-2 if sail.get("slits") else 0.0  # they take less than that of the area away
    assert 0.0 <= 1.0 - pattern.mesh.areas.sum() / (side**2 - hub**2) + 1e-14 <= slits + 2e-14
    assert pattern.mesh.areas.min() > 0.0
    assert len(np.unique(pattern.mesh.faces)) == strips * (12 if hub else 8)
    assert pattern.mesh.areas.min() > 1e-3 * pattern.mesh.areas.max()


def test_edge_around_the_hub_stays_where_it_is():
    """What is fastened to the hub is so in both states."""
    pattern = cross_fold(side=14.0, hub=1.2, strips=10)
    mesh = pattern.mesh
    rim = np.unique(mesh.edges[mesh.edge_kinds == BOUNDARY])
    hub = rim[np.abs(mesh.vertices[rim]).max(axis=1) < 0.61]
    assert len(hub) >= 8
    assert np.abs(pattern.stowed[hub, :2] - mesh.vertices[hub]).max() < 1e-14
    assert np.abs(pattern.stowed[hub, 2]).max() == 0.0
    assert np.abs(pattern.stowed[:, :2]).max(axis=1).min() > 0.6 - 1e-14


def test_slits_leave_bridges_at_the_fold_lines():
    """Their edges do not touch, in either state."""
    pattern = cross_fold(side=14.0, hub=2.0, strips=3, slits=0.6)
    mesh = pattern.mesh
    x, y = np.abs(mesh.vertices).T
    tips = np.flatnonzero(np.isclose(x, y) & (x > 1.0) & (x < 7.0))
    width = (7.0 - 1.0) / 3
    ends = [1.0 + width * (k + 0.5 + side) for k in range(3) for side in (-0.3, 0.3)]
    assert np.allclose(np.unique(np.round(x[tips], 9)), sorted([*ends, 3.0, 5.0]))
    middles = np.unique(mesh.edges[mesh.edge_kinds == BOUNDARY])
    middles = middles[(np.abs(x - y)[middles] < 0.1) & ~np.isclose(x, y)[middles]]
    assert len(middles) == 4 * 3 * 2
    for points in (mesh.vertices, pattern.stowed):
        gaps = np.linalg.norm(points[middles][:, None] - points[middles], axis=2)
        assert gaps[~np.eye(len(middles), dtype=bool)].min() > 1e-3


@pytest.mark.parametrize("opening", [0.02, 0.1, 0.5])
def test_opening_is_the_angle_between_strips(opening):
    pattern = cross_fold(opening=opening)
    mesh = pattern.mesh
    middle = np.abs(mesh.vertices - [3.0, 0.6]).sum(axis=1)
    vertex = int(np.argmin(middle))  # on the fold line y = b / 2
    around = (mesh.edges == vertex).any(axis=1) & (mesh.edge_kinds == CREASE)
    lengthwise = around & (np.abs(np.diff(mesh.vertices[mesh.edges][:, :, 1], axis=1)[:, 0]) < 1e-12)
    ends = mesh.edges[lengthwise].sum(axis=1) - vertex
    one, two = pattern.stowed[ends] - pattern.stowed[vertex]
    assert np.isclose(np.arccos(one @ two / np.linalg.norm(one) / np.linalg.norm(two)), opening, rtol=1e-9)


def test_closed_pack_is_a_cross_of_arms_one_strip_high():
    pattern = cross_fold(side=14.0, hub=1.2, strips=10, opening=0.0)
    flat, stowed = pattern.mesh.vertices, pattern.stowed
    assert np.isclose(np.ptp(stowed[:, 2]), 0.64, rtol=1e-12)
    tips = np.abs(flat).min(axis=1) == 7.0
    assert tips.sum() == 4
    assert np.allclose(np.abs(stowed[tips, :2]), 0.6 + 6.4 / np.sqrt(2.0), rtol=1e-13)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"side": -1.0}, "pattern.side"),
        ({"hub": 14.0}, "pattern.hub"),
        ({"strips": 1}, "pattern.strips"),
        ({"opening": 2.0}, "pattern.opening"),
        ({"columns": 0}, "pattern.columns"),
        ({"slits": 1.0}, "pattern.slits"),
    ],
)
def test_bad_parameters_are_named(change, key):
    with pytest.raises(InputError) as error:
        build_pattern("cross_fold", change)
    assert error.value.key == key
