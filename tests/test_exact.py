"""The exact solutions that other tests hold the program against: printed numbers, limits, virtual work."""

import numpy as np
import pytest
from scipy.integrate import simpson

from exact_annulus import tension_field_annulus, twisted_annulus
from exact_membranes import clamped_disc, drum, drum_deflection, mylar_balloon, pillow
from exact_strips import bent_rectangle, uniaxial

PILLOW = 5e3 * 0.6 / (588e6 * 6e-4)
"""p a / (E h) of a pillow of polyimide-like film."""


def printed(value, digits):
    """Equal to a number printed with that many decimals."""
    return pytest.approx(value, abs=0.501 * 10.0**-digits)


# Drum ----------------------------------------------------------------------------------------------------------------


def test_drum_frequencies():
    modes = drum(0.6, 1e6, 1420.0, 6)
    assert [(mode.m, mode.n) for mode in modes] == [(1, 1), (1, 2), (2, 1), (2, 2), (1, 3), (3, 1)]
    expected = [31.2744, 49.4492, 49.4492, 62.5489, 69.9318, 69.9318]
    assert [mode.frequency for mode in modes] == [printed(value, 4) for value in expected]
    assert [(mode.m, mode.n) for mode in drum(3.0, 1.0, 1.0, 3, b=1.0)] == [(1, 1), (2, 1), (3, 1)]


def test_drum_deflection():
    assert drum_deflection() == printed(0.0736714, 7)
    assert drum_deflection(0.3, 0.0) == pytest.approx(0.0, abs=1e-12)
    # a rectangle is the same one turned
    assert drum_deflection(0.3, 0.4, 0.5) == pytest.approx(drum_deflection(0.4, 0.3, 2.0) / 4.0, rel=1e-10)
    # far from the short sides it is a strip
    assert drum_deflection(0.3, 0.5, 50.0) == pytest.approx(0.5 * 0.3 * 0.7, rel=1e-12)


# Disc and pillow under pressure --------------------------------------------------------------------------------------


def test_clamped_disc_under_follower_pressure():
    disc = clamped_disc(0.01, 0.34)
    assert disc.w0 == printed(0.1390906, 7)
    assert disc.stress_pole == printed(0.0206175, 7)
    assert disc.stress_rim == printed(0.0158528, 7)
    assert disc.rim_radius == pytest.approx(1.0, abs=1e-10)
    assert disc.wrinkled_from is None
    assert disc.S2.min() > 0.0


def test_clamped_disc_under_dead_load():
    assert clamped_disc(0.01, 0.34, follower=False).w0 == printed(0.1385122, 7)


@pytest.mark.parametrize(
    ("s", "w0", "rim", "volume"), [(1e-4, 0.466670, 0.766001, 1.234766), (1e-2, 0.445367, 0.786180, 1.233025)]
)
def test_pillow(s, w0, rim, volume):
    sheet = pillow(PILLOW, 0.4, s)
    assert sheet.w0 == printed(w0, 6)
    assert sheet.rim_radius == printed(rim, 6)
    assert 2.0 * sheet.volume == printed(volume, 6)


def test_pillow_wrinkles_outside():
    sheet = pillow(PILLOW, 0.4, 1e-4)
    assert 588.0 * sheet.stress_pole == printed(5.316, 3)
    assert sheet.wrinkled_from == printed(0.387, 3)
    assert np.all((sheet.S2 > 0.0) == (sheet.R < sheet.wrinkled_from))


def test_weakly_inflated_pillow_is_the_mylar_balloon():
    w0, rim, volume = mylar_balloon()
    assert w0 == printed(0.4569466, 7)
    assert rim == printed(0.7627598, 7)
    sheet = pillow(1e-7, 0.4, 0.0)
    assert sheet.w0 == pytest.approx(w0, rel=3e-5)
    assert sheet.rim_radius == pytest.approx(rim, rel=1e-6)
    assert 2.0 * sheet.volume == pytest.approx(volume, rel=1e-6)


def test_weakly_loaded_disc_follows_hencky():
    """w0 / a = 0.6536 q^(1/3) and S_pole / E = 0.4310 q^(2/3) for nu = 0.3 (Hencky 1915)."""
    disc = clamped_disc(1e-7, 0.3)
    assert disc.w0 / 1e-7 ** (1 / 3) == pytest.approx(0.6536, abs=2e-4)
    assert disc.stress_pole / 1e-7 ** (2 / 3) == pytest.approx(0.4310, abs=2e-4)


@pytest.mark.parametrize("solution", [lambda q: clamped_disc(q, 0.2), lambda q: pillow(q, 0.35, 1e-3)])
def test_pressure_does_the_work_that_is_stored(solution):
    below, above = solution(0.0099), solution(0.0101)
    assert above.energy - below.energy == pytest.approx(0.01 * (above.volume - below.volume), rel=3e-5)


def test_dead_load_does_the_work_that_is_stored():
    below, above = clamped_disc(0.0099, 0.2, follower=False), clamped_disc(0.0101, 0.2, follower=False)
    lift = simpson(2.0 * np.pi * above.R * (above.z - below.z), x=above.R)
    assert above.energy - below.energy == pytest.approx(0.01 * lift, rel=3e-5)


def test_pressure_below_zero_is_refused():
    with pytest.raises(ValueError, match="pressure"):
        pillow(-1e-3, 0.3, 0.0)


# Annulus -------------------------------------------------------------------------------------------------------------


def test_tension_field_of_the_annulus():
    found = tension_field_annulus(2.5, 0.3, wrinkled_to=1.5)
    assert found.torque == printed(2.75551, 5)
    assert found.rotation == printed(4.24936, 5)
    first = tension_field_annulus(2.5, 0.3, wrinkled_to=1.0 + 1e-9)
    assert (first.torque, first.rotation) == (pytest.approx(1.0, abs=1e-8), pytest.approx(1.092, abs=1e-8))
    again = tension_field_annulus(2.5, 0.3, angle=found.rotation)
    assert (again.torque, again.wrinkled_to) == (pytest.approx(found.torque), pytest.approx(1.5))


def test_annulus_at_small_strain_is_the_tension_field():
    field = tension_field_annulus(2.2, 0.25, wrinkled_to=1.4)
    sheet = twisted_annulus(2.2, 0.25, 1e-9, wrinkled_to=1.4)
    assert sheet.torque == pytest.approx(field.torque, rel=1e-7)
    assert sheet.rotation == pytest.approx(field.rotation, rel=1e-7)
    assert sheet.energy == pytest.approx(field.energy, rel=1e-7)


def test_prestress_and_residual_stiffness_change_the_annulus_little():
    """At s0 / E = 1e-4 finite strain shows at 1e-3, a residual stiffness of 1e-4 at 3e-4."""
    field, sheet = (
        solve(2.5, 0.3, *at, wrinkled_to=1.5) for solve, at in ((tension_field_annulus, ()), (twisted_annulus, (1e-4,)))
    )
    stiff = twisted_annulus(2.5, 0.3, 1e-4, wrinkled_to=1.5, s=1e-4)
    assert sheet.rotation / field.rotation - 1.0 == pytest.approx(-7.34e-4, abs=1e-6)
    assert stiff.rotation / sheet.rotation - 1.0 == pytest.approx(-2.50e-4, abs=1e-6)


@pytest.mark.parametrize("angle", [0.8, 3.0])
@pytest.mark.parametrize(
    "solution", [tension_field_annulus, lambda b, nu, angle: twisted_annulus(b, nu, 1e-2, angle=angle, s=1e-3)]
)
def test_torque_does_the_work_that_is_stored(solution, angle):
    below, middle, above = (solution(2.5, 0.3, angle=angle + step) for step in (-1e-3, 0.0, 1e-3))
    assert (above.energy - below.energy) / 2e-3 == pytest.approx(2.0 * np.pi * middle.torque, rel=1e-7)


def test_unreachable_wrinkles_are_refused():
    with pytest.raises(ValueError, match="finite rotation"):
        tension_field_annulus(2.5, 0.3, wrinkled_to=2.4)
    with pytest.raises(ValueError, match="one of"):
        twisted_annulus(2.5, 0.3, 1e-4)


# Strips --------------------------------------------------------------------------------------------------------------


def test_bent_rectangle_wrinkles():
    bent = bent_rectangle(4.0)
    assert (bent.moment, bent.wrinkled) == (pytest.approx(2 / 3, rel=1e-14), pytest.approx(0.5, rel=1e-14))
    assert bent.strain == pytest.approx(0.0, abs=1e-18)
    assert bent_rectangle(0.6).moment == pytest.approx(0.2, rel=1e-14)


@pytest.mark.parametrize(("k", "s"), [(0.7, 0.0), (4.0, 0.0), (4.0, 1e-4), (9.0, 0.3)])
def test_bent_rectangle_carries_force_and_moment(k, s):
    """The stress of the strains it says, integrated over the height."""
    bent = bent_rectangle(k, load=1e-5, s=s)
    y = np.linspace(-0.5, 0.5, 400001)
    strain = bent.strain + bent.curvature * y
    stress = np.where(strain > 0.0, strain, s * strain)
    assert simpson(stress, x=y) == pytest.approx(1e-5, rel=1e-9)
    assert 2.0 * simpson(stress * y, x=y) == pytest.approx(1e-5 * bent.moment, rel=1e-9)
    assert np.mean(strain < 0.0) == pytest.approx(bent.wrinkled, abs=1e-5)


def test_uniaxial_force_is_the_slope_of_the_energy():
    strip = uniaxial(2.5e9, 0.34, 2e-4, width=0.2, thickness=5e-4)
    assert strip.force == printed(50.0150, 4)
    below, above = (uniaxial(2.5e9, 0.34, strain).energy for strain in (0.02 - 1e-6, 0.02 + 1e-6))
    assert (above - below) / 2e-6 == pytest.approx(uniaxial(2.5e9, 0.34, 0.02).force, rel=1e-9)
    assert uniaxial(2.5e9, 0.34, 1e-6).width == pytest.approx(1.0 - 0.34e-6, rel=1e-12)
