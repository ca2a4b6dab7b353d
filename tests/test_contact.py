"""Contact forces: gradient of an energy, balanced, on the right side, in the right amount."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from contact_cases import EPS_N, EPS_S, THICKNESS, TwoSheets, settings, wavy
from contact_meshes import grid, mesh_of
from warp_origami.errors import InputError
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.terms.contact import Contact

METHODS = ("sts", "nts", "mixed")


def small_over_large(n=2):
    return TwoSheets(grid(4, 4), grid(n, n, (0.6, 0.6), angle=0.37))


def small_over_rim():
    """The upper sheet is slightly beside the rim of the lower: closest points are on the outer boundary."""
    return TwoSheets(grid(4, 4, (0.1, 0.1)), grid(4, 4, (0.1, 0.1), (0.0985, 0.003)))


# --- amount -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 5])
def test_equal_sheets_are_pressed_apart_by_stiffness_times_area(n):
    """Two passes carry half the stiffness each; the amount does not depend on how many elements a sheet has."""
    sheets = TwoSheets(grid(n, n, (0.5, 0.3)), grid(n, n, (0.5, 0.3)))
    contact = sheets.contact()
    g = 1.3e-4
    q = sheets.at(THICKNESS - g)
    np.testing.assert_allclose(sheets.force(contact, q), [0, 0, EPS_S * g * 0.15], rtol=1e-9, atol=1e-6)
    assert contact.gradient(q)[0] == pytest.approx(0.5 * EPS_S * g * g * 0.15, rel=1e-9)
    assert contact.statistics().max_penetration == pytest.approx(g, rel=1e-9)


def test_non_matching_meshes_converge_under_subdivision():
    """A turned sheet over another: only the pass whose points hang over the rim has an integration error."""
    errors = {}
    for k in (1, 2, 4, 8):
        worst = 0.0
        for angle in (0.1, 0.37, 0.7):
            sheets = TwoSheets(grid(3, 3), grid(2, 2, (0.5, 0.5), (0.02, 0.01), angle))
            contact = sheets.contact(divisions=k)
            expected = EPS_S * 1e-4 * 0.25
            worst = max(worst, abs(sheets.force(contact, sheets.at(THICKNESS - 1e-4))[2] / expected - 1.0))
        errors[k] = worst
    assert errors[4] < 0.01 and errors[8] < 0.003 and errors[8] < 0.3 * errors[2], errors


def test_nodes_count_once_per_layer():
    """Nodes above nodes and edges of a layer of many elements: one gap each."""
    sheets = TwoSheets(grid(4, 4), grid(2, 2, (0.5, 0.5)))
    contact = sheets.contact("nts", divisions=2)
    g = 2e-4
    energy, _ = contact.gradient(sheets.at(THICKNESS - g))
    upper = 5 * 5  # corners of the sub-triangles, inside of elements too
    lower = 5 * 5  # those of the lower sheet below the upper one
    assert contact.statistics().contacts_nts == upper + lower
    assert energy == pytest.approx((upper + lower) * 0.5 * EPS_N * g * g, rel=1e-9)


def test_mixed_is_the_sum():
    sheets = small_over_large()
    q = wavy(sheets.coordinates, sheets.at(0.9 * THICKNESS), 5, position=1e-4, slope=1e-3)
    parts = [sheets.contact(m).gradient(q) for m in METHODS]
    assert parts[0][0] + parts[1][0] == pytest.approx(parts[2][0], rel=1e-12)
    np.testing.assert_allclose(parts[0][1] + parts[1][1], parts[2][1], atol=1e-8)


def test_impact_of_rigid_sheets():
    """Duration pi sqrt(m / (2 eps)) and deepest gap v sqrt(m / (2 eps)): the half sine of two equal free sheets."""
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(3, 3, (0.3, 0.3)))
    contact = sheets.contact()
    m, v, area = 0.71, 1.0, 0.09
    duration, deepest = np.pi * np.sqrt(m / (2 * EPS_S)), v * np.sqrt(m / (2 * EPS_S))
    steps = 200
    h = duration / steps
    height, speed, least, time = THICKNESS, -v, 0.0, 0.0
    while height <= THICKNESS + 1e-12 and time < 2 * duration:
        speed += 0.5 * h * 2 * sheets.force(contact, sheets.at(height))[2] / (m * area)
        height += h * speed
        speed += 0.5 * h * 2 * sheets.force(contact, sheets.at(height))[2] / (m * area)
        least, time = max(least, THICKNESS - height), time + h
    assert time == pytest.approx(duration, rel=0.01)
    assert least == pytest.approx(deepest, rel=1e-3)
    assert speed == pytest.approx(v, rel=1e-3)


# --- gradient of an energy --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sheets", [small_over_large(), small_over_rim()], ids=["inside", "rim"])
def test_force_is_the_gradient_of_the_energy(method, sheets):
    """Over sub-triangles, their edges and vertices, and over the outer boundary."""
    contact = sheets.contact(method)
    for seed in range(4):
        q = wavy(sheets.coordinates, sheets.at(0.6 * THICKNESS), seed)
        contact.accept(wavy(sheets.coordinates, sheets.at(4 * THICKNESS), seed))
        energy, gradient = contact.gradient(q)
        assert energy > 0
        direction = np.random.default_rng(seed + 100).normal(size=q.shape)
        e = 1e-8
        slope = (contact.gradient(q + e * direction)[0] - contact.gradient(q - e * direction)[0]) / (2 * e)
        assert np.vdot(gradient, direction) == pytest.approx(slope, rel=3e-6)


def ridge(angle):
    """One face of two planes that meet at an angle, along edges of the mesh and sub-mesh, and a small sheet over it."""
    sheets = TwoSheets(grid(2, 2, (0.4, 0.4)), grid(1, 1, (0.1, 0.1)))

    def at(height, dx=0.0):
        q = sheets.at(height, dx)
        low = sheets.coordinates.positions[~sheets.above]
        q[low, 2] -= np.tan(angle) * np.abs(q[low, 0])
        return q

    return sheets, at


@pytest.mark.parametrize("angle", [0.3, -0.3])
def test_force_is_the_gradient_over_ridge_and_valley(angle):
    sheets, at = ridge(angle)
    for dx in (-0.0371, 0.0, 0.0123):
        contact = Contact(sheets.mesh, sheets.coordinates, settings("mixed"), at(0.08))
        for height in np.arange(0.07, -0.01, -3e-4):  # lowered until it lies on
            q = wavy(sheets.coordinates, at(height, dx), 3, slope=1e-3)
            contact.accept(q)
            if contact.statistics().max_penetration > 0.3 * THICKNESS:
                break
        energy, gradient = contact.gradient(q)
        assert energy > 0 and contact.statistics().max_penetration < THICKNESS
        direction = np.random.default_rng(1).normal(size=q.shape)
        e = 1e-8
        slope = (contact.gradient(q + e * direction)[0] - contact.gradient(q - e * direction)[0]) / (2 * e)
        assert np.vdot(gradient, direction) == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize(
    ("method", "depth"), [("sts", 0.3), ("sts", 0.9), ("nts", 0.3), ("nts", 0.9), ("mixed", 0.3), ("mixed", 0.7)]
)
def test_path_work_equals_the_change_of_energy(method, depth):
    """Pressed in and slid over many sub-triangles at up to 90 % penetration; in mixed contact to where facets meet.

    The force has kinks where a point comes into contact or changes its sub-triangle; what is left, 1e-6 to 4e-5, is the
    error of integrating over them and falls with the step.
    """
    sheets = TwoSheets(grid(2, 2, (0.4, 0.4)), grid(1, 1, (0.1, 0.1), angle=0.2))
    contact = sheets.contact(method, divisions=2)

    def state(s):
        q = sheets.at(THICKNESS * (1.0 - depth * np.sin(np.pi * min(s, 0.5))), 0.05 * s)
        return wavy(sheets.coordinates, q, 2, position=2e-5, slope=2e-3)

    contact.accept(state(0.0))
    s = np.linspace(0.0, 1.0, 3001)
    values = [contact.gradient(state(t)) for t in s]
    work = 0.0
    nodes, weights = np.polynomial.legendre.leggauss(2)
    for a, b in pairwise(s):
        step = state(b) - state(a)
        for x, w in zip(nodes, weights, strict=True):
            work += 0.5 * w * np.vdot(contact.gradient(state(a) + 0.5 * (1 + x) * step)[1], step)
    change = values[-1][0] - values[0][0]
    assert change > 0
    assert work == pytest.approx(change, rel=6e-5)


@pytest.mark.parametrize("method", METHODS)
def test_forces_and_moments_balance(method):
    sheets = small_over_rim()
    contact = sheets.contact(method)
    q = wavy(sheets.coordinates, sheets.at(0.5 * THICKNESS), 8)
    _, gradient = contact.gradient(q)
    scale = np.abs(gradient).sum()
    assert np.abs(gradient[sheets.coordinates.positions].sum(axis=0)).max() < 1e-12 * scale
    assert np.abs(np.cross(q, gradient).sum(axis=0)).max() < 1e-12 * scale


@pytest.mark.parametrize("method", METHODS)
def test_tangent_is_the_derivative_up_to_a_term_proportional_to_the_gap(method):
    """(38), (45) neglect g d(A^T n)/dx: against differences of the force the error falls with the penetration."""
    sheets = small_over_large()
    contact = sheets.contact(method)
    rng = np.random.default_rng(0)
    direction = rng.normal(size=sheets.at(0.0).shape)
    errors = []
    for g in (1e-4, 1e-5, 1e-6):
        q = sheets.at(THICKNESS - g)
        energy, gradient, matrix, weights = contact.tangent(q)
        again = contact.gradient(q)
        assert energy == again[0] and np.array_equal(gradient, again[1])
        assert matrix.shape == (len(weights), q.size)
        e = 1e-4 * g
        change = (contact.gradient(q + e * direction)[1] - contact.gradient(q - e * direction)[1]) / (2 * e)
        main = matrix.T @ (weights * (matrix @ direction.ravel()))
        errors.append(np.linalg.norm(main - change.ravel()) / np.linalg.norm(change))
    assert errors[0] < 1e-2 and errors[2] < 0.02 * errors[0], errors


def test_tangent_is_exact_for_an_approach_of_plane_sheets():
    """Along the normal the neglected term vanishes."""
    sheets = TwoSheets(grid(2, 2), grid(3, 3))
    contact = sheets.contact("mixed")
    q = sheets.at(0.7 * THICKNESS)
    direction = sheets.at(1.0) - sheets.at(0.0)
    _, _, matrix, weights = contact.tangent(q)
    e = 1e-6
    change = (contact.gradient(q + e * direction)[1] - contact.gradient(q - e * direction)[1]) / (2 * e)
    main = matrix.T @ (weights * (matrix @ direction.ravel()))
    np.testing.assert_allclose(main, change.ravel(), atol=1e-6 * np.abs(change).max())


# --- sides ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("above", [1, -1])
def test_points_are_pushed_back_to_their_own_side(method, above):
    """Also from iterates beyond the layer; only accepted states decide."""
    sheets = small_over_large()
    contact = sheets.contact(method, start=above * 0.004)
    last = 0.0
    for depth in (0.1, 0.5, 0.9, 1.0, 1.5, 2.5):
        force = above * sheets.force(contact, sheets.at(above * THICKNESS * (1.0 - depth)))[2]
        assert force > (last if method != "mixed" else 0.0)  # facets push harder, but not as far
        last = force
    if method == "mixed":  # which accepts no such step
        return
    contact.accept(sheets.at(above * 0.1 * THICKNESS))
    contact.accept(sheets.at(-above * 0.1 * THICKNESS))
    assert above * sheets.force(contact, sheets.at(-above * 0.1 * THICKNESS))[2] > 0


def test_side_of_pairs_that_meet_within_one_step_comes_from_the_last_accepted_state():
    sheets = small_over_large()
    contact = sheets.contact("mixed", start=0.3)
    assert contact.summary().pairs == 0
    assert contact.gradient(sheets.at(0.3))[0] == 0.0
    assert sheets.force(contact, sheets.at(-0.3 * THICKNESS))[2] > 0
    contact.accept(sheets.at(-0.3))
    assert sheets.force(contact, sheets.at(-0.3 * THICKNESS))[2] < 0
    assert sheets.force(contact, sheets.at(0.3 * THICKNESS))[2] < 0


def test_result_depends_on_the_state_alone_not_on_the_way_there():
    sheets = small_over_large()
    q = wavy(sheets.coordinates, sheets.at(0.5 * THICKNESS), 11)
    one, other = sheets.contact("mixed"), sheets.contact("mixed")
    for height in (0.03, -0.002, 0.0, 0.2):
        other.gradient(sheets.at(height, dx=height))
    a, b = one.gradient(q), other.gradient(q)
    assert a[0] > 0 and a[0] == b[0] and np.array_equal(a[1], b[1])


def test_a_restored_state_continues_bitwise():
    sheets = small_over_large()
    one = sheets.contact("mixed")
    path = [wavy(sheets.coordinates, sheets.at(z), 4) for z in (0.004, 0.0008, 0.0004, -0.0003, 0.0005)]
    for q in path[:3]:
        one.accept(q)
    other = sheets.contact("mixed")
    other.restore({k: np.array(v) for k, v in one.state().items()})
    for q in path[3:]:
        a, b = one.tangent(q), other.tangent(q)
        assert a[0] > 0 and a[0] == b[0] and np.array_equal(a[1], b[1])
        assert np.array_equal(a[2].toarray(), b[2].toarray()) and np.array_equal(a[3], b[3])
        one.accept(q)
        other.accept(q)


def test_a_sheet_that_slides_in_under_the_rim_is_not_thrown_through():
    """Edge on, a point has no side yet: once it is under the layer it stays there."""
    sheets = TwoSheets(grid(2, 2, (0.4, 0.4)), grid(2, 2, (0.1, 0.1), (0.2525, 0.0)))
    contact = Contact(sheets.mesh, sheets.coordinates, settings("mixed"), sheets.at(1e-5))
    for s in np.linspace(0.0, 1.0, 60):
        q = sheets.at(1e-5 - 0.98e-3 * s, dx=-0.006 * s)
        contact.accept(q)
        assert contact.statistics().max_penetration < THICKNESS
    assert sheets.force(contact, q)[2] < 0


# --- one face that curls back on itself -------------------------------------------------------------------------------


def test_one_face_touches_itself():
    mesh = mesh_of(*grid(24, 2, (0.6, 0.05)))
    coordinates = number_coordinates(mesh)
    radius = 0.02
    quarter = np.pi * radius

    def rolled(gap):
        """A strip laid back over itself by a bend of radius 20 mm, its ends pressed to a distance `gap`."""
        x, y = mesh.vertices.T
        angle = np.clip((x + quarter / 2) / radius, 0.0, np.pi)
        along = np.where(x < -quarter / 2, x + quarter / 2, np.where(x > quarter / 2, quarter / 2 - x, 0.0))
        z = radius * (1 - np.cos(angle))
        z = np.where(along < -0.05, np.where(x > 0, gap / 2 + radius, radius - gap / 2), z)
        return affine_coordinates(mesh, coordinates, np.stack([along + radius * np.sin(angle), y, z], axis=1))

    contact = Contact(mesh, coordinates, settings("mixed"), rolled(0.04), divisions=2)
    assert contact.gradient(rolled(0.04))[0] == 0.0
    contact.accept(rolled(2 * THICKNESS))
    energy, gradient = contact.gradient(rolled(0.8 * THICKNESS))
    above = coordinates.positions[mesh.vertices[:, 0] > 0.1]
    assert energy > 0 and -gradient[above, 2].sum() > 0
    assert gradient[coordinates.positions].sum(axis=0) == pytest.approx([0, 0, 0], abs=1e-9 * np.abs(gradient).sum())


# --- what is compiled -------------------------------------------------------------------------------------------------


def test_kernel_modules_are_named():
    sheets = small_over_large()
    assert [m.rsplit(".")[-1] for m in sheets.contact("mixed").kernel_modules] == [
        "broadphase",
        "point_contact",
        "facet_error",
        "edge_search",
        "edge_edge",
        "facet_pairs",
        "swept",
        "swept_search",
    ]
    of_paper = ["broadphase", "point_contact", "facet_error"]
    assert [m.rsplit(".")[-1] for m in sheets.contact("nts").kernel_modules] == of_paper


def test_unknown_method_is_named():
    sheets = small_over_large()
    with pytest.raises(InputError, match=r"contact\.method"):
        sheets.contact("ets")


# --- what an accepted state may not be --------------------------------------------------------------------------------


def test_points_that_have_gone_through_a_layer_are_named():
    sheets = small_over_large()
    contact = sheets.contact("mixed")
    contact.accept(sheets.at(0.1 * THICKNESS))
    assert contact.passage(sheets.at(0.1 * THICKNESS), sheets.at(0.05 * THICKNESS)) is None
    elements, flat = contact._surfaces.through(sheets.at(-0.05 * THICKNESS))
    assert len(elements) == len(flat) > 10
    above = sheets.above[sheets.mesh.triangles[:, 0]]
    assert np.all(above[elements[:, 0]] != above[elements[:, 1]])
    found = contact.passage(sheets.at(0.1 * THICKNESS), sheets.at(-0.05 * THICKNESS))
    assert found is not None and found.faces[0] != found.faces[1]
    # nothing is forgotten: it is pushed back to where it was
    assert sheets.force(contact, sheets.at(-0.05 * THICKNESS))[2] > 0.0


@pytest.mark.parametrize("reaches", [0.5, 1.2, 10.0])
def test_what_goes_through_from_afar_is_not_taken_for_a_layer_that_is_turned_over(reaches):
    sheets = small_over_large()
    contact = sheets.contact("mixed")
    contact.accept(sheets.at(reaches * contact.reach))
    before = contact.state()
    elements, _ = contact._surfaces.through(sheets.at(-0.3 * THICKNESS))
    assert len(elements) > 10
    assert sheets.force(contact, sheets.at(-0.3 * THICKNESS))[2] > 0.0
    assert all(np.array_equal(before[name], value) for name, value in contact.state().items())


def test_a_side_that_changes_without_motion_is_forgotten():
    """As when a part of a crumpled layer that is turned over becomes the nearest."""
    sheets = small_over_large()
    contact = sheets.contact("nts")._surfaces
    contact.accept(sheets.at(0.5 * THICKNESS))
    contact._accepted = replace(contact._accepted, sides=-contact._accepted.sides)
    contact._searches.forget()
    q = sheets.at(0.49 * THICKNESS)
    energy, _ = contact.gradient(q)
    assert len(contact.through(q)[0]) > 10
    assert contact.gradient(q)[0] < 0.2 * energy
    assert len(contact.through(q)[0]) == 0
