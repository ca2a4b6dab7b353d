"""Exact contact: layers that never come closer than their thickness, held off by an energy."""

import numpy as np
import pytest

import warp_origami as wo
from contact_cases import EPS_S, THICKNESS, TwoSheets, settings, wavy
from contact_meshes import grid
from flying_sheets import corner_over_sheet
from runs import system_of
from warp_origami.terms.contact import Contact
from warp_origami.terms.contact.law import LEFT, RANGE, Barrier, Penalty, StiffeningPenalty, contact_law

RANGE_HERE = RANGE * THICKNESS


@pytest.mark.parametrize("begins", [1.1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("law", [Penalty(), StiffeningPenalty(thickness=THICKNESS), Barrier(THICKNESS)])
def test_force_and_stiffness_are_the_derivatives_of_the_energy(law, begins):
    """Also where the barrier goes over into its parabola, and for pairs too close to a crease to have a barrier."""
    gaps = -begins * np.linspace(1e-3, 0.15, 2000)
    given = np.full(len(gaps), 3e6), np.full(len(gaps), begins)
    e = 1e-7 * begins
    for function, derivative in ((law.energy, law.slope), (law.slope, law.curvature)):
        difference = (function(gaps + e, *given) - function(gaps - e, *given)) / (2 * e)
        np.testing.assert_allclose(difference, derivative(gaps, *given), rtol=1e-4)


def test_mixed_contact_stiffens_beyond_half_of_the_thickness():
    """The penalty until there; beyond, force and stiffness still are derivatives, also of what is through."""
    law, begins = StiffeningPenalty(thickness=1e-3), 1e-3
    gaps = -begins * np.linspace(1e-3, 1.5, 3001)
    given = np.full(len(gaps), 3e6), np.full(len(gaps), begins)
    shallow = gaps >= -0.5 * begins
    for function in ("energy", "slope", "curvature"):
        soft = getattr(Penalty(), function)(gaps, *given)[shallow]
        np.testing.assert_allclose(getattr(law, function)(gaps, *given)[shallow], soft, rtol=1e-12)
    e = 1e-6 * begins
    for function, derivative in ((law.energy, law.slope), (law.slope, law.curvature)):
        difference = (function(gaps + e, *given) - function(gaps - e, *given)) / (2 * e)
        np.testing.assert_allclose(difference, derivative(gaps, *given), rtol=1e-4)
    through = law.slope(np.array([-begins]), *(g[:1] for g in given))[0]
    assert -through > 50 * 3e6 * begins


def test_barrier_begins_as_the_penalty_and_ends_far_stiffer():
    law, one = Barrier(THICKNESS), np.ones(1)
    begins = law.outset * THICKNESS * one
    shallow, hard = -1e-3 * RANGE_HERE * one, -RANGE_HERE * one
    assert law.slope(shallow, one, begins) == pytest.approx(Penalty().slope(shallow, one, begins), rel=2e-3)
    assert -law.slope(hard, one, begins)[0] == pytest.approx(149.5 * RANGE_HERE)
    assert law.energy(hard, one, begins)[0] == pytest.approx(14.0 * RANGE_HERE**2)
    assert law.curvature(hard, one, begins)[0] == pytest.approx(LEFT**-3)
    assert law.penetration(hard, begins)[0] == pytest.approx(0.0, abs=1e-18)
    laws = [type(contact_law(method, False, THICKNESS)) for method in ("sts", "nts", "mixed")]
    assert laws == [Penalty, Penalty, StiffeningPenalty]
    assert isinstance(contact_law("mixed", True, THICKNESS), Barrier)


@pytest.mark.parametrize("method", ["sts", "mixed"])
def test_force_is_the_gradient_of_the_energy(method):
    sheets = TwoSheets(grid(4, 4), grid(2, 2, (0.6, 0.6), angle=0.37))
    contact = Contact(sheets.mesh, sheets.coordinates, settings(method, exact=True), sheets.at(0.01))
    for seed in range(3):
        q = wavy(sheets.coordinates, sheets.at(1.05 * THICKNESS), seed, position=1e-5, slope=2e-4)
        energy, gradient = contact.gradient(q)
        assert energy > 0 and contact.statistics().max_penetration == 0.0
        direction = np.random.default_rng(seed + 100).normal(size=q.shape)
        e = 1e-9
        slope = (contact.gradient(q + e * direction)[0] - contact.gradient(q - e * direction)[0]) / (2 * e)
        assert np.vdot(gradient, direction) == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_sheets_are_pressed_apart_before_the_thickness(share):
    """Per area eps g (1 - y / 2) / (1 - y)^2 at y = g / z of the range, and its energy and tangent."""
    sheets = TwoSheets(grid(2, 2, (0.5, 0.3)), grid(2, 2, (0.5, 0.3)))
    contact = Contact(sheets.mesh, sheets.coordinates, settings(exact=True), sheets.at(0.01))
    g = share * RANGE_HERE
    q = sheets.at(THICKNESS + RANGE_HERE - g)
    force = EPS_S * 0.15 * g * (1 - 0.5 * share) / (1 - share) ** 2
    np.testing.assert_allclose(sheets.force(contact, q), [0, 0, force], rtol=1e-9, atol=1e-9 * force)
    energy, _, rows, weights = contact.tangent(q)
    assert energy == pytest.approx(0.5 * EPS_S * 0.15 * g**2 / (1 - share), rel=1e-9)
    up = (sheets.at(1.0) - sheets.at(0.0)).ravel()
    assert weights @ (rows @ up) ** 2 == pytest.approx(EPS_S * 0.15 / (1 - share) ** 3, rel=1e-9)
    np.testing.assert_allclose(contact.active_pairs().forces.sum(), force, rtol=1e-9)


@pytest.mark.parametrize("name", ["leaf_in", "single_fold"])
def test_the_start_is_free_of_force(name):
    """Although the barrier begins outside of the thickness."""
    system = system_of(wo.load_scene(name, ["contact.exact=true", 'contact.method="mixed"']))
    assert system.evaluate(system.q0).contact_energy == 0.0


def test_a_thousandth_of_the_thickness_takes_a_pressure_that_no_film_sees():
    """What presses two layers together by 1e-3 of the thickness of 1 mm at the default stiffness: 1.6 MPa."""
    sheets = TwoSheets(grid(2, 2, (0.5, 0.3)), grid(2, 2, (0.5, 0.3)))
    contact = Contact(sheets.mesh, sheets.coordinates, settings(exact=True), sheets.at(0.01))
    assert sheets.force(contact, sheets.at(0.999 * THICKNESS))[2] / 0.15 == pytest.approx(1.6e6, rel=0.01)


@pytest.mark.parametrize("speed", [10.0, 50.0])
def test_a_poked_corner_does_not_reach_the_thickness(tmp_path, speed):
    """Whatever the stiffness: that of the paper is far too soft here, with the penalty it gives way by 3 to 20 %."""
    depths = {}
    for exact in (False, True):
        contact = {"sts_stiffness": 1e8, "nts_stiffness": 3e6, "exact": exact}
        scene = corner_over_sheet(tmp_path, contact, 4e-4 / speed, speed)
        result = wo.simulate(scene, device="cpu")
        depths[exact] = result.summary["max_penetration"] / scene.contact.thickness
        assert result.summary["energy_gain"] < 5e-3
    assert depths[False] > 0.02 and depths[True] < 1e-3
