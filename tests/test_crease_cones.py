"""Tangent cones along creases: what they are, and that they hold a fold open where no sub-mesh does."""

import ipctk
import numpy as np
import pytest

from contact_cases import EPS_N, settings
from contact_meshes import grid
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.generators import build_pattern
from warp_origami.model.mesh import CREASE, build_mesh
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.contact import Contact
from warp_origami.terms.contact.crease_cones import crease_cones
from warp_origami.terms.contact.facets import RANGE_SHARE, FacetContact
from warp_origami.terms.contact.features import submesh_features
from warp_origami.terms.contact.swept import SweptTest
from warp_origami.terms.contact.thickness import CREASE_RATIO
from warp_origami.terms.shapes import tabulate

DIVISIONS = 4
OPENING = 0.2
THICK = 0.1
"""So thick that the crease rule alone sets the range, m."""


class Fold:
    """Two squares of 0.1 m side by side, folded along their common side to an opening of 0.2 rad."""

    def __init__(self):
        strip = {"width": 0.2, "height": 0.1, "nx": 2, "ny": 1, "creases_x": (1,), "opening": OPENING}
        pattern = build_pattern("sheet", strip, None, 1)
        self.mesh, self.coordinates = pattern.mesh, number_coordinates(pattern.mesh)
        self.q = affine_coordinates(self.mesh, self.coordinates, pattern.stowed)
        self.cones = crease_cones(self.mesh, self.coordinates, DIVISIONS)

    def with_end(self, opening):
        """The sheet with another opening (rad) at one end of the crease, (0.1, 0): below zero it is through itself."""
        q = self.q.copy()
        for row in self.coordinates.sector_gradients[self.coordinates.sector_vertices == 1]:
            q[row] = [np.sin(0.5 * opening), 0.0, np.sign(q[row, 2]) * np.cos(0.5 * opening)]
        return q

    def folded_to(self, opening):
        """The sheet with another opening all along the crease."""
        q = self.q.copy()
        for row in self.coordinates.sector_gradients:
            q[row] = [np.sin(0.5 * opening), 0.0, np.sign(q[row, 2]) * np.cos(0.5 * opening)]
        at = self.coordinates.positions
        q[at, 0] = self.mesh.vertices[:, 0] * np.sin(0.5 * opening)
        q[at, 2] = -np.minimum(self.mesh.vertices[:, 0], 0.2 - self.mesh.vertices[:, 0]) * np.cos(0.5 * opening)
        return q

    def crosses(self, q, divisions):
        submesh = build_submesh(self.mesh, divisions)
        points = tabulate(self.mesh, submesh.elements, submesh.areas).interpolation(self.coordinates) @ q
        flat, triangles = np.pad(submesh.flat, ((0, 0), (0, 1))), submesh.triangles
        oracle = ipctk.CollisionMesh(flat, ipctk.edges(triangles), triangles)
        return ipctk.has_intersections(oracle, points)

    def submesh_test(self, divisions):
        features = submesh_features(self.mesh, self.coordinates, build_submesh(self.mesh, divisions))
        return SweptTest(self.mesh, features, "cpu")

    def contact(self, q):
        """Contact of the cones alone, from the state q on."""
        return FacetContact(self.mesh, self.cones, THICK, EPS_N, q)


@pytest.fixture(scope="module")
def fold():
    return Fold()


@pytest.fixture(scope="module")
def star():
    """Mesh and coordinates of a sheet with a vertex of four creases, a smooth vertex and creases that end inside."""
    vertices, triangles = grid(4, 4)
    lines, letters = [(6, 12), (12, 18), (7, 12), (12, 17), (17, 22)], list("MMMVV")
    mesh = build_mesh(vertices, triangles, lines, letters)
    return mesh, number_coordinates(mesh)


def test_rays_are_the_derivatives_of_the_surface(star):
    """x(P + s d) = x(P) + s ray + O(s^2) for any q, at vertices and along creases."""
    mesh, coordinates = star
    cones = crease_cones(mesh, coordinates, DIVISIONS)
    q = np.random.default_rng(1).normal(size=(coordinates.count, 3))
    rays = cones.interpolation @ q
    apex = np.zeros(len(cones.flat), dtype=int)
    apex[cones.triangles] = cones.triangles[:, :1]
    directions = cones.flat - cones.flat[apex]
    assert np.abs(rays[np.unique(cones.triangles[:, 0])]).max() < 1e-12
    assert np.count_nonzero(np.linalg.norm(directions, axis=1)) > 60
    corners = mesh.vertices[mesh.triangles[cones.elements]]
    errors = []
    for s in (1e-3, 1e-4):
        points = cones.flat[apex] + s * directions, cones.flat[apex]
        ends = []
        for flat in points:
            spans = corners[:, 1:] - corners[:, :1]
            inside = np.linalg.solve(spans.transpose(0, 2, 1), (flat - corners[:, 0])[:, :, None])[:, :, 0]
            areas = np.column_stack([1.0 - inside.sum(axis=1), inside])
            ends.append(tabulate(mesh, cones.elements, areas).interpolation(coordinates) @ q)
        errors.append(np.abs((ends[0] - ends[1]) / s - rays).max())
    assert errors[0] < 0.1 and errors[1] < 0.11 * errors[0]


def test_cones_stand_along_creases_only(star):
    """A cone at every vertex on a crease, made of all elements around it, and at the points inside each crease."""
    mesh, coordinates = star
    cones = crease_cones(mesh, coordinates, DIVISIONS)
    creases = mesh.edges[mesh.edge_kinds == CREASE]
    vertices = np.unique(creases)
    assert cones.islands.max() + 1 == len(vertices) + (DIVISIONS - 1) * len(creases)
    around = np.isin(mesh.triangles, vertices).sum()
    assert len(cones.triangles) == around + 4 * (DIVISIONS - 1) * len(creases)
    # all of a cone is in one island
    assert (cones.islands[cones.triangles] == cones.islands[cones.triangles[:, :1]]).all()


def test_lips_of_a_cut_are_one_ray():
    """At the tip of a cut that a crease goes on from."""
    vertices, triangles = grid(4, 4)
    mesh = build_mesh(vertices, triangles, [(2, 7), (7, 12), (12, 17)], ["C", "C", "V"])
    cones = crease_cones(mesh, number_coordinates(mesh), 1)
    doubled = len(cones.groups) - len(np.unique(cones.groups))
    assert doubled == 1
    flat = np.pad(cones.flat, ((0, 0), (0, 1)))
    (one,) = np.flatnonzero(cones.groups != np.arange(len(flat)))
    np.testing.assert_allclose(flat[one], flat[cones.groups[one]])


def test_closing_an_end_beyond_flat_is_seen_by_the_cones_and_not_by_the_sub_mesh(fold):
    """The corners of the elements do not move at all; the surface is through itself, the more the finer one looks."""
    before, after = fold.with_end(OPENING), fold.with_end(-0.05)
    assert fold.submesh_test(1).first_passage(before, after) is None
    assert [fold.crosses(after, divisions) for divisions in (1, 16)] == [False, True]
    passage = SweptTest(fold.mesh, fold.cones, "cpu").first_passage(before, after)
    # on the straight way of the gradients: sin is linear in t
    sines = np.sin([0.5 * OPENING, -0.025])
    assert passage.t == pytest.approx(sines[0] / (sines[0] - sines[1]), abs=1e-6)
    np.testing.assert_allclose(passage.flat, [[0.1, 0.0]] * 2, atol=0.1 / DIVISIONS + 1e-12)


def test_contact_refuses_the_step(fold):
    contact = Contact(fold.mesh, fold.coordinates, settings("mixed"), fold.q)
    assert contact.passage(fold.with_end(OPENING), fold.with_end(0.01)) is None
    assert contact.passage(fold.with_end(OPENING), fold.with_end(-0.05)) is not None
    assert not contact.is_free_way(fold.with_end(OPENING), fold.with_end(-0.05))


def test_force_begins_at_a_quarter_of_the_crease_rule(fold):
    """The left chord, s = l / sqrt(2) from the right diagonal, lies across its middle: l / 2 from the crease."""
    contact = fold.contact(fold.q)
    limit = np.sqrt(2.0) * RANGE_SHARE * CREASE_RATIO
    assert contact.gradient(fold.with_end(1.01 * limit))[0] == 0.0
    assert contact.gradient(fold.with_end(0.99 * limit))[0] > 0.0


@pytest.mark.parametrize("opening", [0.7, 0.2, -1.0])
def test_force_opens_the_fold_and_is_the_gradient_of_its_energy(fold, opening):
    """Also where an iterate is through; cones at vertices hold angles, so that nothing pulls at positions."""
    contact = fold.contact(fold.q)
    q = fold.with_end(opening * RANGE_SHARE * CREASE_RATIO)
    rng = np.random.default_rng(2)
    q += 1e-5 * rng.normal(size=q.shape)
    energy, gradient = contact.gradient(q)
    direction = 1e-9 * rng.normal(size=q.shape)
    change = 0.5 * (contact.gradient(q + direction)[0] - contact.gradient(q - direction)[0])
    assert energy > 0.0
    assert np.sum(gradient * direction) == pytest.approx(change, rel=1e-5)
    assert np.abs(gradient[fold.coordinates.positions]).max() < 1e-12 * np.abs(gradient).max()
    np.testing.assert_allclose(np.cross(q, gradient).sum(axis=0), 0.0, atol=1e-12 * np.abs(gradient).sum())
    opened = fold.with_end((opening + 0.01) * RANGE_SHARE * CREASE_RATIO) - fold.with_end(
        opening * RANGE_SHARE * CREASE_RATIO
    )
    assert np.sum(gradient * opened) < 0.0


def test_force_along_the_whole_crease_is_the_gradient_of_its_energy(fold):
    """Cones inside an edge hold it by what lies around them: forces on positions, which sum to zero."""
    contact = fold.contact(fold.q)
    rng = np.random.default_rng(3)
    q = fold.folded_to(0.3 * RANGE_SHARE * CREASE_RATIO)
    q += 1e-6 * rng.normal(size=q.shape)
    _, gradient = contact.gradient(q)
    direction = 1e-9 * rng.normal(size=q.shape)
    change = 0.5 * (contact.gradient(q + direction)[0] - contact.gradient(q - direction)[0])
    assert np.sum(gradient * direction) == pytest.approx(change, rel=1e-5)
    on_positions, scale = gradient[fold.coordinates.positions], np.abs(gradient).max()
    assert np.abs(on_positions).max() > 1e-3 * scale
    np.testing.assert_allclose(on_positions.sum(axis=0), 0.0, atol=1e-12 * scale)
    np.testing.assert_allclose(np.cross(q, gradient).sum(axis=0), 0.0, atol=1e-12 * np.abs(gradient).sum())


def test_cones_are_no_places_that_touch(fold):
    """They count in the tangent, and not in friction, pressure and numbers of pairs."""
    contact = Contact(fold.mesh, fold.coordinates, settings("mixed"), fold.q)
    q = fold.with_end(0.3 * RANGE_SHARE * CREASE_RATIO)
    _, _, rows, _ = contact.tangent(q)
    assert rows.shape[0] > len(contact.active_pairs().forces) == len(contact.flat_points())


def test_a_flat_sheet_with_creases_has_no_force(star):
    mesh, coordinates = star
    q = affine_coordinates(mesh, coordinates, np.pad(mesh.vertices, ((0, 0), (0, 1))))
    contact = FacetContact(mesh, crease_cones(mesh, coordinates, DIVISIONS), THICK, EPS_N, q)
    energy, gradient = contact.gradient(q)
    assert energy == 0.0 and not gradient.any()
