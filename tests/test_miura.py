"""The Miura sheet: flat-foldable, and stowed without strain at any opening."""

import math

import ipctk
import numpy as np
import pytest

import warp_origami as wo
from warp_origami.errors import InputError
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.generators import build_pattern
from warp_origami.model.generators.miura import miura
from warp_origami.model.mesh import BOUNDARY, CREASE, SMOOTH

SHEETS = [(4, 3, 0.1, 0.08, 1.0), (3, 4, 0.05, 0.2, 0.6), (6, 2, 1.0, 1.0, 1.5)]
OPENINGS = [1e-3, 0.3, 1.2, 3.0, math.pi]


def creases_around(mesh, v):
    """Directions (rad, increasing) and letters of the creases that meet at a vertex."""
    at = np.flatnonzero((mesh.edges == v).any(axis=1) & (mesh.edge_kinds == CREASE))
    other = mesh.edges[at].sum(axis=1) - v
    step = mesh.vertices[other] - mesh.vertices[v]
    angle = np.arctan2(step[:, 1], step[:, 0])
    order = np.argsort(angle)
    return angle[order], mesh.edge_assignments[at][order]


def inner_vertices(mesh):
    rim = np.unique(mesh.edges[mesh.edge_kinds == BOUNDARY])
    return np.setdiff1d(np.arange(len(mesh.vertices)), rim)


@pytest.mark.parametrize("sheet", SHEETS)
def test_counts_and_area(sheet):
    nx, ny, a, b, angle = sheet
    mesh = miura(*sheet).mesh
    assert (len(mesh.vertices), len(mesh.triangles)) == ((nx + 1) * (ny + 1), 2 * nx * ny)
    counts = [int((mesh.edge_kinds == kind).sum()) for kind in (SMOOTH, CREASE, BOUNDARY)]
    assert counts == [nx * ny, (nx - 1) * ny + nx * (ny - 1), 2 * (nx + ny)]
    assert len(np.unique(mesh.faces)) == nx * ny
    assert np.isclose(mesh.areas.sum(), nx * ny * a * b * math.sin(angle), rtol=1e-13)


@pytest.mark.parametrize("sheet", SHEETS)
def test_every_vertex_is_flat_foldable(sheet):
    """Kawasaki: opposite sectors make a half turn; Maekawa: mountains and valleys differ by two."""
    mesh = miura(*sheet).mesh
    vertices = inner_vertices(mesh)
    assert len(vertices) == (sheet[0] - 1) * (sheet[1] - 1)
    for v in vertices:
        angles, letters = creases_around(mesh, v)
        sectors = np.diff(angles, append=angles[0] + 2 * np.pi)
        assert np.isclose(sectors[::2].sum(), np.pi, rtol=1e-13)
        assert abs((letters == "M").sum() - (letters == "V").sum()) == 2


@pytest.mark.parametrize("sheet", SHEETS)
@pytest.mark.parametrize("opening", OPENINGS)
def test_stowed_state_is_strain_free(sheet, opening):
    """Every length of every panel, diagonals included, and panels that stay plane."""
    pattern = miura(*sheet, opening=opening)
    mesh = pattern.mesh
    a, b = mesh.edges.T
    flat = np.linalg.norm(mesh.vertices[a] - mesh.vertices[b], axis=1)
    assert np.abs(np.linalg.norm(pattern.stowed[a] - pattern.stowed[b], axis=1) / flat - 1.0).max() < 1e-13
    angles = fold_angles(mesh, pattern.stowed)
    assert np.abs(angles[mesh.edge_kinds == SMOOTH]).max() < 1e-12
    zigzags = np.abs(np.diff(mesh.vertices[mesh.edges][:, :, 1], axis=1)[:, 0]) > 1e-9
    zigzags &= mesh.edge_kinds == CREASE
    assert np.allclose(np.pi - np.abs(angles[zigzags]), opening, atol=1e-9)


@pytest.mark.parametrize("sheet", SHEETS)
@pytest.mark.parametrize("opening", [0.05, 1.2, 3.0])
def test_letters_say_how_it_folds_and_layers_do_not_cross(sheet, opening):
    pattern = miura(*sheet, opening=opening)
    mesh = pattern.mesh
    creases = mesh.edge_kinds == CREASE
    angles = fold_angles(mesh, pattern.stowed)[creases]
    assert (np.where(angles > 0, "V", "M") == mesh.edge_assignments[creases]).all()
    oracle = ipctk.CollisionMesh(pattern.stowed, ipctk.edges(mesh.triangles), mesh.triangles)
    assert not ipctk.has_intersections(oracle, pattern.stowed)


def test_folded_sheet_is_one_stack_of_parallelograms():
    """In the limit all panels lie in one plane, and the zigzags are straight."""
    stowed = miura(4, 3, 0.1, 0.08, 1.0, opening=1e-9).stowed
    assert np.ptp(stowed[:, 1]) < 1e-8
    assert np.isclose(np.ptp(stowed[:, 2]), 0.1 * math.sin(1.0), rtol=1e-12)
    assert np.isclose(np.ptp(stowed[:, 0]), 4 * 0.1 * math.cos(1.0) + 0.08, rtol=1e-12)


def test_scene_starts_without_strain():
    table = {"kind": "miura", "nx": 2, "ny": 2, "a": 0.1, "b": 0.1, "sector_angle": 1.0, "opening": 0.4, "refine": 2}
    scene = wo.Scene(
        name="case",
        analysis={"kind": "dynamic", "duration": 1e-6},
        pattern=table,
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 1e-4},
    )
    assert scene.pattern.initial == "stowed"
    assert wo.simulate(scene).history["strain_energy"][0] < 1e-20
    flat = {key: value for key, value in table.items() if key != "opening"}
    assert wo.Scene(**scene.model_dump() | {"pattern": flat}).pattern.initial == "flat"
    with pytest.raises(InputError, match=r"pattern\.initial"):
        wo.Scene(**scene.model_dump() | {"pattern": flat | {"initial": "stowed"}})


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"nx": 0}, "pattern.nx"),
        ({"a": 0.0}, "pattern.a"),
        ({"b": math.nan}, "pattern.b"),
        ({"sector_angle": 1.6}, "pattern.sector_angle"),
        ({"opening": 3.2}, "pattern.opening"),
        ({"opening": -0.1}, "pattern.opening"),
    ],
)
def test_bad_parameters_are_named(change, key):
    with pytest.raises(InputError) as error:
        build_pattern("miura", {"nx": 2, "ny": 2, "a": 0.1, "b": 0.1, "sector_angle": 1.0} | change)
    assert error.value.key == key
