"""Discs and annuli: graded rings of well shaped triangles, refined onto true circles."""

import tomllib

import numpy as np
import pytest
from scipy.spatial import cKDTree

from warp_origami.errors import InputError
from warp_origami.model.generators import build_pattern
from warp_origami.model.generators.annulus import annulus
from warp_origami.model.generators.disc import disc
from warp_origami.model.mesh import BOUNDARY, SMOOTH
from warp_origami.model.refine import refine_pattern
from warp_origami.model.selectors import held_directions, select
from warp_origami.scene import Scene

DISC = {"kind": "disc", "radius": 0.6, "rings": 4}
ANNULUS = {"kind": "annulus", "inner_radius": 0.2, "outer_radius": 0.5, "rings": 4}


def angles(mesh):
    """(ne, 3) corners of the triangles, degrees."""
    corners = mesh.vertices[mesh.triangles]
    one, two = (np.roll(corners, -k, axis=1) - corners for k in (1, 2))
    cross = one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
    return np.degrees(np.arctan2(cross, np.sum(one * two, axis=-1)))


def radii(mesh, centre=(0.0, 0.0)):
    return np.linalg.norm(mesh.vertices - centre, axis=1)


def rim(mesh):
    return np.unique(mesh.edges[mesh.edge_kinds == BOUNDARY])


def is_symmetric(mesh, direction):
    """Whether mirroring across the line through the origin gives the same triangles."""
    along = np.array([np.cos(direction), np.sin(direction)])
    image = 2.0 * np.outer(mesh.vertices @ along, along) - mesh.vertices
    distance, number = cKDTree(mesh.vertices).query(image)
    return distance.max() < 1e-12 and triples(number[mesh.triangles]) == triples(mesh.triangles)


def triples(triangles):
    return {frozenset(t) for t in triangles.tolist()}


@pytest.mark.parametrize("pattern", [disc(0.6, 3, 12), disc(0.6, 8, 64, grading=0.3), annulus(0.2, 0.6, 3, 16)])
def test_area_converges_to_the_circles_with_order_two(pattern):
    exact = np.pi * (0.6**2 - min(radii(pattern.mesh)) ** 2)
    errors = [1.0 - refine_pattern(pattern, n).mesh.areas.sum() / exact for n in (2, 4, 8)]
    assert errors[-1] > 0
    assert np.log2(errors[:-1]) - np.log2(errors[1:]) == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_rims_lie_on_their_circles_and_their_edges_are_alike(n):
    centre = (3.0, -1.0)
    for pattern, circles in (
        (disc(0.6, 3, 20, centre=centre), [0.6]),
        (annulus(0.2, 0.6, 3, 20, 0.5, centre), [0.2, 0.6]),
    ):
        mesh = refine_pattern(pattern, n).mesh
        distance = radii(mesh, centre)
        assert np.abs(distance[rim(mesh), None] - circles).min(axis=1).max() < 2e-15
        for circle in circles:
            selected = select({"circle": [*centre, circle]}, mesh)
            assert len(selected.vertices) == len(selected.edges) == 20 * n
            assert np.abs(distance[selected.vertices] - circle).max() < 2e-15
            chords = np.linalg.norm(np.diff(mesh.vertices[mesh.edges[selected.edges]], axis=1), axis=-1)
            assert chords == pytest.approx(2.0 * circle * np.sin(np.pi / (20 * n)), rel=1e-12)
            for v, _, along in held_directions(mesh, selected):  # tangents of the circle
                assert abs(along @ (mesh.vertices[v] - centre)) < 1e-14
        assert len(select({"boundary": True}, mesh).vertices) == 20 * n * len(circles)


def test_refinement_keeps_the_vertices_and_divides_the_rings_smoothly():
    pattern = disc(1.0, 3, 24, grading=0.4)
    fine, twice = refine_pattern(pattern, 6).mesh, refine_pattern(refine_pattern(pattern, 2), 3).mesh
    assert np.array_equal(fine.vertices[: len(pattern.mesh.vertices)], pattern.mesh.vertices)
    assert len(fine.triangles) == 36 * len(pattern.mesh.triangles)
    assert len(fine.vertices) - len(fine.edges) + len(fine.triangles) == 1
    for mesh in (fine, twice):
        circles = np.unique(np.round(radii(mesh), 12))
        widths = np.diff(circles)
        assert len(widths) == 18
        assert widths[1:] / widths[:-1] == pytest.approx(0.4 ** (1 / 2 / 6), rel=1e-9)


def test_a_refined_disc_is_the_disc_of_more_rings():
    fine, direct = refine_pattern(disc(1.0, 2, 16), 4).mesh, disc(1.0, 8, 64).mesh
    distance, number = cKDTree(direct.vertices).query(fine.vertices)
    assert distance.max() < 1e-14
    assert triples(number[fine.triangles]) == triples(direct.triangles)


@pytest.mark.parametrize("grading", [0.2, 1.0, 5.0])
def test_widths_of_rings_are_a_geometric_sequence(grading):
    for pattern, inner in ((disc(0.6, 6, 32, grading), 0.0), (annulus(0.2, 0.6, 6, 32, grading), 0.2)):
        circles = np.unique(np.round(radii(pattern.mesh), 12))
        widths = np.diff(circles)
        assert len(widths) == 6
        assert circles[[0, -1]] == pytest.approx([inner, 0.6], abs=1e-12)
        assert widths[-1] / widths[0] == pytest.approx(grading, rel=1e-9)
        assert np.ptp(widths[1:] / widths[:-1]) < 1e-9


@pytest.mark.parametrize(
    ("pattern", "bound"),
    [
        (disc(1.0, 8, 64), 39),
        (disc(1.0, 8, 64, grading=0.25), 30),
        (disc(1.0, 8, 64, grading=3.0), 23),
        (disc(1.0, 6, 36), 45),
        (disc(1.0, 16, 64), 33),
        (disc(1.0, 7, 37), 40),
        (disc(1.0, 5, 42), 34),
        (disc(1.0, 40), 38),
        (annulus(0.4, 1.0, 6), 34),
        (annulus(0.2, 1.0, 8, 32, grading=5.0 ** (7 / 8)), 46),
    ],
)
def test_no_triangle_has_a_small_angle_and_refinement_makes_none(pattern, bound):
    assert angles(pattern.mesh).min() > bound
    for n in (2, 5):
        assert angles(refine_pattern(pattern, n).mesh).min() > 0.8 * bound
    assert set(pattern.mesh.edge_kinds) == {SMOOTH, BOUNDARY}


@pytest.mark.parametrize("n", [1, 2, 3])
def test_meshes_are_mirror_symmetric(n):
    for pattern, lines in (
        (disc(1.0, 8, 64, grading=0.5), 8),
        (disc(1.0, 3, 18), 6),
        (disc(1.0, 3, 15), 5),
        (annulus(0.4, 1.0, 3, 12), 12),
    ):
        mesh = refine_pattern(pattern, n).mesh
        assert all(is_symmetric(mesh, np.pi * k / lines) for k in range(lines))
        assert not is_symmetric(mesh, 0.1)


@pytest.mark.parametrize(("rings", "segments"), [(8, 64), (5, 20), (4, 64), (2, 4)])
def test_the_centre_and_four_points_of_the_rim_are_vertices(rings, segments):
    mesh = disc(0.6, rings, segments, centre=(1.0, 2.0)).mesh
    assert mesh.vertices[0].tolist() == [1.0, 2.0]
    for x, y in ((0.6, 0), (0, 0.6), (-0.6, 0), (0, -0.6)):
        assert np.linalg.norm(mesh.vertices - (1.0 + x, 2.0 + y), axis=1).min() < 1e-15


def test_numbers_of_edges_grow_with_the_circles():
    circle, edges = np.unique(np.round(radii(disc(1.0, 8, 64).mesh), 9), return_counts=True)
    assert edges.tolist() == [1, 8, 16, 24, 32, 40, 48, 56, 64]
    assert len(circle) == 9
    assert len(disc(1.0, 8).mesh.triangles) == 8 * 64
    assert len(annulus(0.4, 1.0, 8, 30).mesh.triangles) == 2 * 8 * 30


@pytest.mark.parametrize(
    ("kind", "changes", "key"),
    [
        ("disc", {"radius": -1.0}, "radius"),
        ("disc", {"rings": 0}, "rings"),
        ("disc", {"segments": 2}, "segments"),
        ("disc", {"grading": 0.0}, "grading"),
        ("disc", {"rings": 1, "grading": 2.0}, "grading"),
        ("disc", {"centre": (np.nan, 0.0)}, "centre"),
        ("disc", {"rings": 40, "segments": 8}, "segments"),
        ("annulus", {"inner_radius": 0.0}, "inner_radius"),
        ("annulus", {"inner_radius": 0.5}, "inner_radius"),
        ("annulus", {"outer_radius": np.inf}, "outer_radius"),
        ("annulus", {"rings": 20, "segments": 6}, "segments"),
    ],
)
def test_impossible_parameters_are_named(kind, changes, key):
    parameters = {name: value for name, value in (DISC if kind == "disc" else ANNULUS).items() if name != "kind"}
    with pytest.raises(InputError) as error:
        build_pattern(kind, parameters | changes)
    assert error.value.key == f"pattern.{key}"


def scene(pattern):
    material = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4}
    return Scene(name="round", analysis={"kind": "dynamic", "duration": 1.0}, pattern=pattern, material=material)


@pytest.mark.parametrize(
    ("pattern", "segments"),
    [
        (DISC, 32),
        (DISC | {"segments": 24, "grading": 0.5, "centre": [1.0, 2.0], "refine": 2}, 24),
        (ANNULUS, 32),
        (ANNULUS | {"initial": {"stretch": [1.001, 1.001]}}, 32),
    ],
)
def test_scenes_fill_in_defaults_and_survive_the_file(pattern, segments):
    made = scene(pattern)
    assert made.pattern.segments == segments
    again = Scene(**tomllib.loads(made.to_toml()))
    assert again == made
    built = build_pattern(again.pattern.kind, again.pattern.parameters())
    bare = build_pattern(pattern["kind"], {k: v for k, v in pattern.items() if k not in ("kind", "initial")})
    assert np.array_equal(built.mesh.vertices, bare.mesh.vertices)


@pytest.mark.parametrize(
    ("pattern", "key"),
    [
        (DISC | {"rings": 0}, "rings"),
        (DISC | {"segments": 2}, "segments"),
        (DISC | {"grading": 0.0}, "grading"),
        (DISC | {"grading": 1e9}, "grading"),
        (DISC | {"initial": "stowed"}, "initial"),
        ({"kind": "disc", "rings": 3}, "radius"),
        (ANNULUS | {"inner_radius": 0.5}, "inner_radius"),
    ],
)
def test_scenes_name_the_wrong_key(pattern, key):
    with pytest.raises(InputError) as error:
        scene(pattern)
    assert error.value.key == f"pattern.{key}"
