"""Generated patterns: stowed states without strain that do not cross, the order of their layers, refused parameters."""

import ipctk
import numpy as np
import pytest

from runs import system_of
from warp_origami.errors import InputError
from warp_origami.model.flat_foldability import flat_folded_vertices, vertex_folds
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.generators import build_pattern
from warp_origami.model.mesh import CREASE, SMOOTH
from warp_origami.model.opening import opened
from warp_origami.scene import Scene, load_scene

APART = [
    ("leaf_in", {"rings": 2}),
    ("leaf_in", {"rings": 5}),
    ("leaf_in", {"widths": [1.0, 2.0, 3.0], "side": 2.0}),
    ("leaf_out", {}),
    ("leaf_out", {"strips": 5, "columns": 3, "opening": 0.02}),
    ("leaf_out", {"opening": 2.5}),
    ("z_fold", {}),
    ("z_fold", {"strips": 3, "columns": 4, "opening": 1.0}),
    ("square_twist", {}),
    ("square_twist", {"nx": 2, "ny": 3, "opening": 0.05}),
    ("square_twist", {"angle": 1.2, "opening": 1.5}),
]
CLOSED = [
    ("leaf_out", {"strips": 3}),
    ("z_fold", {"strips": 5}),
    ("miura", {"nx": 3, "ny": 3, "a": 0.1, "b": 0.1, "sector_angle": 1.0}),
    ("square_twist", {}),
    ("square_twist", {"nx": 2, "ny": 2}),
]


def scene_of(kind, **parameters):
    return Scene(
        name="case",
        analysis={"kind": "dynamic", "duration": 1e-3},
        pattern={"kind": kind} | parameters,
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 1e-4},
        contact={"method": "mixed"},
    )


def crosses(mesh, points):
    oracle = ipctk.CollisionMesh(points, ipctk.edges(mesh.triangles), mesh.triangles)
    return ipctk.has_intersections(oracle, points)


def strain(pattern):
    a, b = pattern.mesh.edges.T
    flat = np.linalg.norm(pattern.mesh.vertices[a] - pattern.mesh.vertices[b], axis=1)
    return np.abs(np.linalg.norm(pattern.stowed[a] - pattern.stowed[b], axis=1) / flat - 1.0).max()


@pytest.mark.parametrize(("kind", "parameters"), APART)
def test_stowed_state_is_free_of_strain_and_does_not_cross(kind, parameters):
    pattern = build_pattern(kind, parameters)
    mesh = pattern.mesh
    assert strain(pattern) < 2e-14
    angles = fold_angles(mesh, pattern.stowed)
    assert np.abs(angles[mesh.edge_kinds == SMOOTH]).max(initial=0.0) < 1e-12
    creases = mesh.edge_kinds == CREASE
    assert (np.where(angles > 0, "V", "M") == mesh.edge_assignments)[creases].all()
    assert not crosses(mesh, pattern.stowed)


@pytest.mark.parametrize(("kind", "parameters"), CLOSED)
def test_layers_of_a_closed_pack_open_in_the_order_that_comes_with_it(kind, parameters):
    pattern = build_pattern(kind, parameters | {"opening": 0.0})
    mesh = pattern.mesh
    assert strain(pattern) < 2e-14
    points = opened(mesh, pattern.pattern_faces, pattern.face_orders, pattern.stowed)
    assert 1e-6 < np.abs(points - pattern.stowed).max() < 1e-2 * mesh.size
    assert not crosses(mesh, points)
    folded = flat_folded_vertices(mesh, pattern.stowed)
    assert folded.flat_foldable.all()
    assert kind == "z_fold" or len(folded.vertices)


def test_contact_starts_from_the_layer_order():
    system = system_of(scene_of("leaf_out", opening=0.0, strips=2))
    start = system.evaluate(system.q0)
    assert start.contact_energy < 1e-25
    assert start.strain_energy < 1e-15


def test_leaf_in_of_three_equal_rings_is_the_default():
    one, two = build_pattern("leaf_in", {}), build_pattern("leaf_in", {"rings": 3, "widths": [2.0, 2.0, 2.0]})
    assert np.array_equal(one.mesh.vertices, two.mesh.vertices)
    assert np.array_equal(one.stowed, two.stowed)


def test_rings_have_their_widths():
    mesh = build_pattern("leaf_in", {"side": 1.2, "widths": [1.0, 2.0, 3.0], "inset": 0.0}).mesh
    diagonal = np.unique(np.round(mesh.vertices[np.isclose(mesh.vertices[:, 0], mesh.vertices[:, 1]), 0], 12))
    assert np.allclose(diagonal[diagonal > 0], [0.05, 0.1, 0.3, 0.6])  # the first is the middle of O-P1


@pytest.mark.parametrize("opening", [0.1, 0.7, 2.0])
def test_leaf_out_keeps_its_opening_between_all_strips(opening):
    pattern = build_pattern("leaf_out", {"strips": 4, "opening": opening})
    mesh, angles = pattern.mesh, fold_angles(pattern.mesh, pattern.stowed)
    ends = mesh.vertices[mesh.edges]
    veins = (mesh.edge_kinds == CREASE) & np.isclose(ends[:, 0, 1], ends[:, 1, 1]) & (np.abs(ends[:, 0, 1]) > 1e-9)
    assert veins.sum() == 2 * 2 * 3
    assert np.allclose(np.pi - np.abs(angles[veins]), opening, atol=1e-12)


def test_square_twists_turn_by_twice_their_angle():
    pattern = build_pattern("square_twist", {"angle": 0.6, "opening": 0.0})
    mesh = pattern.mesh
    own = pattern.stowed[:4, :2] - pattern.stowed[:4, :2].mean(axis=0)
    corner = int(np.argmax(mesh.vertices.sum(axis=1)))  # of the sheet
    panel = next(t for t in mesh.triangles if corner in t)
    turns = []
    for flat, folded in ((mesh.vertices[:4], own), (mesh.vertices[panel], pattern.stowed[panel, :2])):
        a, b = flat[1] - flat[0], folded[1] - folded[0]
        turns.append(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
    assert np.isclose(abs((turns[1] - turns[0] + np.pi) % (2 * np.pi) - np.pi), 2 * 0.6, atol=1e-9)


def test_classic_twist_is_flat_foldable_everywhere_and_starts_folded():
    pattern = build_pattern("square_twist", {"assignment": "classic", "nx": 2, "ny": 2})
    assert strain(pattern) < 2e-14
    assert vertex_folds(pattern.mesh).flat_foldable.all()
    above = {(f, g): s for f, g, s in pattern.face_orders.tolist()}
    assert all(above[g, f] == above[f, g] * -1 for f, g in above if (g, f) in above)
    assert len(pattern.face_orders) >= 4 * 20


@pytest.mark.parametrize(
    ("kind", "change", "key"),
    [
        ("leaf_in", {"rings": 1}, "pattern.rings"),
        ("leaf_in", {"widths": [1.0, 2.0]}, "pattern.widths"),
        ("leaf_in", {"widths": [1.0, -2.0, 1.0]}, "pattern.widths.1"),
        ("leaf_out", {"side": 0.0}, "pattern.side"),
        ("leaf_out", {"strips": 0}, "pattern.strips"),
        ("leaf_out", {"opening": 4.0}, "pattern.opening"),
        ("z_fold", {"length": np.nan}, "pattern.length"),
        ("z_fold", {"strips": 1}, "pattern.strips"),
        ("z_fold", {"columns": 0}, "pattern.columns"),
        ("square_twist", {"nx": 0}, "pattern.nx"),
        ("square_twist", {"cell": -1.0}, "pattern.cell"),
        ("square_twist", {"angle": 1.6}, "pattern.angle"),
        ("square_twist", {"twist": 0.2}, "pattern.twist"),
        ("square_twist", {"assignment": "MVMV"}, "pattern.assignment"),
        ("square_twist", {"assignment": "classic", "opening": 0.1}, "pattern.opening"),
    ],
)
def test_bad_parameters_are_named(kind, change, key):
    with pytest.raises(InputError) as error:
        build_pattern(kind, change)
    assert error.value.key == key


def test_scene_fills_the_parameters_in():
    assert scene_of("square_twist").pattern.opening == 0.3
    assert scene_of("square_twist", assignment="classic").pattern.opening == 0.0
    assert scene_of("leaf_in", rings=5).pattern.corner_distance > 0.3
    with pytest.raises(InputError, match=r"pattern\.widths"):
        scene_of("leaf_in", widths=[1.0])


@pytest.mark.parametrize(
    ("name", "mass", "height"),
    [
        ("z_fold", 0.0284, 0.1),
        ("leaf_out", 0.2556, 0.2990),
        ("square_twist", 0.0639, 0.1366),
        ("cross_fold", 2.7264, 0.3003),
    ],
)
def test_bundled_scene_starts_at_rest_without_strain(name, mass, height):
    """Mass and height of the stowed pack, and nothing presses: what the scenes say of their start."""
    scene = load_scene(name)
    system = system_of(scene)
    assert np.isclose(scene.material.density * scene.material.thickness * system.mesh.areas.sum(), mass, rtol=1e-12)
    assert np.isclose(np.ptp(system.pattern.stowed[:, 2]), height, rtol=2e-2)
    start = system.evaluate(system.q0)
    assert start.strain_energy < 1e-12
    assert start.contact_energy < 1e-25
