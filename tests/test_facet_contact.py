"""Contact of the plane sub-triangles: an energy, on the right side, out of the way of usual contact, and strong."""

from itertools import pairwise

import numpy as np
import pytest

from contact_cases import EPS_N, THICKNESS, TwoSheets, wavy
from contact_meshes import grid, mesh_of
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.generators import build_pattern
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.contact.facets import RANGE_SHARE, FacetContact
from warp_origami.terms.contact.features import submesh_features
from warp_origami.terms.contact.swept import SweptTest

RANGE = RANGE_SHARE * THICKNESS


@pytest.fixture(scope="module")
def sheets():
    return TwoSheets(grid(3, 2), grid(2, 3))


def facets(sheets, start=0.01):
    """Facet contact of the two sheets, which do not match, the upper one shifted."""
    submesh = build_submesh(sheets.mesh, 2)
    return FacetContact(
        sheets.mesh, submesh_features(sheets.mesh, sheets.coordinates, submesh), THICKNESS, EPS_N, at(sheets, start)
    )


def at(sheets, height):
    return sheets.at(height, 0.03, 0.02)


def rough(sheets, height, seed):
    """Two uneven sheets at a distance."""
    return wavy(sheets.coordinates, at(sheets, height), seed, position=0.1 * RANGE, slope=5e-4)


@pytest.mark.parametrize("height", [0.8, 0.3, 0.05, -0.5])
@pytest.mark.parametrize("seed", [1, 2])
def test_force_is_the_gradient_of_the_energy(sheets, height, seed):
    """Also where iterates are through."""
    contact = facets(sheets)
    q = rough(sheets, height * RANGE, seed)
    contact.gradient(q)  # the search is done here, not between the two energies
    energy, gradient = contact.gradient(q)
    direction = 1e-9 * np.random.default_rng(seed).normal(size=q.shape)
    change = 0.5 * (contact.gradient(q + direction)[0] - contact.gradient(q - direction)[0])
    assert energy > 0.0 and min(contact.counts()) > 10
    assert np.sum(gradient * direction) == pytest.approx(change, rel=1e-6)


def test_forces_and_moments_sum_to_zero(sheets):
    contact = facets(sheets)
    q = rough(sheets, 0.5 * RANGE, 3)
    _, gradient = contact.gradient(q)
    positions = sheets.coordinates.positions
    scale = np.abs(gradient[positions]).sum()
    np.testing.assert_allclose(gradient[positions].sum(axis=0), 0.0, atol=1e-12 * scale)
    np.testing.assert_allclose(np.cross(q, gradient).sum(axis=0), 0.0, atol=1e-12 * scale)


def test_active_pairs_give_the_tangent_up_to_a_term_that_vanishes_with_the_gap(sheets):
    contact = facets(sheets)
    q, errors = at(sheets, 0.0), []
    direction = np.random.default_rng(0).normal(size=q.shape)
    for gap in (1e-2, 1e-3):
        q = at(sheets, (1.0 - gap) * RANGE)
        contact.gradient(q)
        pairs = contact.active_pairs()
        rows = pairs.gap_rows()
        main = rows.T @ (pairs.stiffness * (rows @ direction.ravel()))
        e = 1e-2 * gap * RANGE
        change = (contact.gradient(q + e * direction)[1] - contact.gradient(q - e * direction)[1]) / (2.0 * e)
        errors.append(np.linalg.norm(main - change.ravel()) / np.linalg.norm(change))
    assert errors[1] < 0.02 and errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_is_through_is_pushed_back_to_the_side_of_the_last_accepted_state(sheets, side):
    contact = facets(sheets, start=side * 0.01)
    contact.accept(at(sheets, side * 2.0 * THICKNESS))
    for height in (0.5, 0.1, -0.1, -1.0, -2.0):
        _, gradient = contact.gradient(at(sheets, side * height * RANGE))
        force = -gradient[sheets.coordinates.positions[sheets.above], 2].sum()
        assert side * force > 0.0


def test_layers_that_press_on_each_other_as_usual_do_not_meet_it(sheets):
    contact = facets(sheets)
    assert contact.gradient(at(sheets, 1.01 * RANGE))[0] == 0.0
    assert contact.counts() == (0, 0)


def test_the_press_grows_like_a_barrier(sheets):
    """Force of a vertex on a facet at distance d: k a (a^2 - d^2) / (2 d^2), many of them."""
    contact = facets(sheets)
    forces = []
    for share in (0.5, 0.25, 0.125):
        _, gradient = contact.gradient(at(sheets, share * RANGE))
        forces.append(-gradient[sheets.coordinates.positions[sheets.above], 2].sum())
        per_pair = 0.5 * EPS_N * RANGE * (1.0 / share**2 - 1.0)
        pairs = contact.active_pairs()
        full = pairs.forces > 0.999 * per_pair
        assert forces[-1] == pytest.approx(pairs.forces.sum(), rel=1e-9) and full.sum() > 20
        assert pairs.forces.max() == pytest.approx(per_pair, rel=1e-9)


def test_the_start_is_free_of_force_however_close_layers_are():
    folded = {"width": 1.0, "height": 0.5, "nx": 3, "ny": 1, "creases_x": [1, 2], "opening": 1e-3}
    pattern = build_pattern("sheet", folded)
    coordinates = number_coordinates(pattern.mesh)
    q = affine_coordinates(pattern.mesh, coordinates, pattern.stowed)
    features = submesh_features(pattern.mesh, coordinates, build_submesh(pattern.mesh, 4))
    contact = FacetContact(pattern.mesh, features, 5e-3, EPS_N, q)
    assert contact.gradient(q)[0] == 0.0 and contact.counts() == (0, 0)
    flat = affine_coordinates(pattern.mesh, coordinates, np.pad(pattern.mesh.vertices, ((0, 0), (0, 1))))
    assert contact.gradient(flat)[0] == 0.0


def test_what_has_been_pushed_through_comes_back_without_a_passage():
    """Newton's method on the energy and a weak pull to where it was pushed to."""
    sheets = TwoSheets(grid(2, 1), grid(2, 1))
    contact = facets(sheets)
    swept = SweptTest(
        sheets.mesh, submesh_features(sheets.mesh, sheets.coordinates, build_submesh(sheets.mesh, 2)), "cpu"
    )
    q = rough(sheets, 0.9 * RANGE, 5)
    contact.accept(q)
    pushed = q.copy()
    pushed[sheets.coordinates.positions[sheets.above], 2] -= 2.0 * RANGE
    assert swept.first_passage(q, pushed) is not None
    target = pushed.copy()
    for _ in range(200):
        _, gradient = contact.gradient(pushed)
        pairs = contact.active_pairs()
        rows = pairs.gap_rows()
        matrix = (rows.T @ rows.multiply(pairs.stiffness[:, None])).toarray() + 1e3 * np.eye(q.size)
        pull = gradient.ravel() + 1e3 * (pushed - target).ravel()
        pushed = pushed - np.linalg.solve(matrix, pull).reshape(q.shape)
        if np.linalg.norm(pull) < 1e-9:
            break
    assert swept.first_passage(q, pushed) is None


def test_path_work_equals_the_change_of_energy(sheets):
    """Slid over many facets that do not cross, also where edges are parallel."""
    contact = facets(sheets)

    def state(s):
        height = RANGE * (1.0 - 0.5 * np.sin(np.pi * s))
        q = sheets.at(height, 0.03 * s, 0.02)
        return wavy(sheets.coordinates, q, 2, position=0.02 * RANGE, slope=1e-4)

    contact.accept(state(0.0))
    work, path = 0.0, np.linspace(0.0, 0.7, 801)
    nodes, weights = np.polynomial.legendre.leggauss(2)
    for a, b in pairwise(path):
        step = state(b) - state(a)
        for x, w in zip(nodes, weights, strict=True):
            work += 0.5 * w * np.vdot(contact.gradient(state(a) + 0.5 * (1 + x) * step)[1], step)
    change = contact.gradient(state(0.7))[0] - contact.gradient(state(0.0))[0]
    assert change > 0.0
    assert work == pytest.approx(change, rel=1e-4)


def test_restore_continues_bitwise(sheets):
    one, other = facets(sheets), facets(sheets)
    one.accept(rough(sheets, 0.4 * RANGE, 7))
    other.restore(one.state())
    q = rough(sheets, 0.3 * RANGE, 8)
    (e1, g1), (e2, g2) = one.gradient(q), other.gradient(q)
    assert e1 == e2 > 0.0 and np.array_equal(g1, g2)


def test_separate_sheets_may_overlap_in_the_flat_plane():
    """Their distance there says nothing about them."""
    v, t = grid(2, 2)
    mesh = mesh_of(np.concatenate([v, v]), np.concatenate([t, t + len(v)]))
    coordinates = number_coordinates(mesh)
    points = np.pad(mesh.vertices, ((0, 0), (0, 1)))
    points[len(v) :, 2] = 0.01
    q = affine_coordinates(mesh, coordinates, points)
    contact = FacetContact(mesh, submesh_features(mesh, coordinates, build_submesh(mesh, 2)), THICKNESS, EPS_N, q)
    points[len(v) :, 2] = 0.5 * RANGE
    assert contact.gradient(affine_coordinates(mesh, coordinates, points))[0] > 0.0
