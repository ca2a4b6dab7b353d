"""Added masses: inertia and weight of points, rods and patches, a pendulum that swings with its exact period."""

import numpy as np
import pytest
from scipy.special import ellipk

import warp_origami as wo
from runs import system_of
from warp_origami.errors import InputError

SHEET = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.3, "thickness": 1e-5}
AREAL = 1420.0 * 1e-5


def scene(**tables):
    base = {"analysis": {"kind": "dynamic", "duration": 1.0}, "material": SHEET}
    base["pattern"] = {"kind": "sheet", "width": 2.0, "height": 1.0, "nx": 2, "ny": 1, "refine": 2, "creases_x": [1]}
    return wo.Scene(name="weighted", **(base | tables))


def inertia_about(system, point):
    """Of everything about the z axis through a point, by turning it with 1 rad/s."""
    turning = np.cross([0.0, 0.0, 1.0], system.q0 - np.outer(system.translation, [*point, 0.0]))
    return 2.0 * system.kinetic_energy(turning)


OF_SHEET = AREAL * 2.0 * (2.0**2 + 1.0**2) / 3.0
"""About a corner, kg m^2."""


@pytest.mark.parametrize(
    ("at", "inertia"),
    [
        ({"near": [2.0, 1.0]}, 2.0**2 + 1.0**2),  # a point
        ({"vertices": [0, 2]}, 0.5 * 2.0**2),  # two points in equal shares: one at the corner itself
        ({"box": [[2.0, 0.0], [2.0, 1.0]]}, 2.0**2 + 1.0 / 3.0),  # a rod along an edge
        ({"box": [[1.0, 0.0], [1.0, 1.0]]}, 1.0**2 + 1.0 / 3.0),  # along a crease
        ({"box": [[0.0, 0.0], [1.0, 1.0]]}, 2.0 / 3.0),  # a patch
        ({"all": True}, 5.0 / 3.0),
    ],
    ids=["point", "points", "rod", "rod on a crease", "patch", "sheet"],
)
def test_mass_and_moment_of_inertia_are_exact(at, inertia):
    system = system_of(scene(mass=[{"at": at, "value": 3.0}]))
    assert system.total_mass == pytest.approx(2.0 * AREAL + 3.0, rel=1e-12)
    assert inertia_about(system, (0.0, 0.0)) == pytest.approx(OF_SHEET + 3.0 * inertia, rel=1e-12)


def test_masses_weigh_and_add_up():
    masses = [{"at": {"near": [2.0, 1.0]}, "value": 3.0}, {"at": {"near": [2.0, 1.0]}, "value": 0.5}]
    system = system_of(scene(mass=masses, load=[{"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}]))
    force = system.external_force(system.q0, system.external.at(0.0))
    weight = force[system.translation > 0].sum(axis=0)
    np.testing.assert_allclose(weight, [0.0, 0.0, -9.81 * (2.0 * AREAL + 3.5)], atol=1e-12)
    moment = np.cross(system.q0, force).sum(axis=0)
    expected = np.cross([1.0, 0.5, 0.0], [0, 0, -9.81 * 2.0 * AREAL]) + np.cross([2.0, 1.0, 0.0], [0, 0, -9.81 * 3.5])
    np.testing.assert_allclose(moment, expected, atol=1e-12)
    assert "added masses" in system.terms
    assert "added masses" not in system_of(scene()).terms


def test_a_pendulum_swings_with_its_exact_period():
    """A rigid plate on an axis with a rod at its end, released level, stands still again after 2 K sqrt(I / D)."""
    rod = {"at": {"box": [[2.0, 0.0], [2.0, 1.0]]}, "value": 0.5}
    hub = {"at": {"all": True}, "mass": 1.0, "axial_inertia": 0.02, "axis": [0, 1, 0], "centre": [0, 0.5, 0]}
    inertia = 0.02 + AREAL * 2.0 * 4.0 / 3.0 + 0.5 * 4.0
    directing = 9.81 * (AREAL * 2.0 * 1.0 + 0.5 * 2.0)
    half = 2.0 * ellipk(0.5) * np.sqrt(inertia / directing)
    pendulum = scene(
        mass=[rod],
        hub=hub | {"mount": "axis"},
        load=[{"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}],
        analysis={"kind": "dynamic", "duration": half},
        integrator={"step": half / 200, "spectral_radius": 0.8},
        probe=[{"name": "tip", "at": [2.0, 0.0]}],
        output={"fps": 1.0},
    )
    result = wo.simulate(pendulum)
    tip = result.probes["tip"]
    speed = 2.0 * np.sqrt(2.0 * directing / inertia)  # at the lowest point
    np.testing.assert_allclose(tip[-1, :3], [-2.0, 0.0, 0.0], atol=2e-3)
    assert np.linalg.norm(tip[-1, 3:6]) < 5e-3 * speed
    assert np.linalg.norm(tip[:, 3:6], axis=1).max() == pytest.approx(speed, rel=1e-3)
    assert result.summary["energy_loss"] < 1e-3


def test_a_string_that_spins_with_a_mass_is_as_tight_as_the_mass_pulls():
    """A narrow strip of next to no mass on an axis, m r w^2 = E A strain: the mean of its ringing is on the circle."""
    strip = scene(
        pattern={"kind": "sheet", "width": 1.0, "height": 0.1, "origin": [0.0, -0.05], "nx": 2, "ny": 2},
        material=SHEET | {"density": 1.0, "model": "linear", "poisson_ratio": 0.0, "thickness": 1e-4},
        mass=[{"at": {"box": [[1.0, -0.05], [1.0, 0.05]]}, "value": 0.1}],
        hub={"at": {"box": [[0.0, -0.05], [0.0, 0.05]]}, "mass": 1.0, "axial_inertia": 10.0, "mount": "axis"},
        load=[{"kind": "initial_spin", "rate": 50.0}],
        analysis={"kind": "dynamic", "duration": 0.02},
        integrator={"step": 2e-5, "spectral_radius": 0.9},
        probe=[{"name": "tip", "at": [1.0, 0.0]}],
        output={"fps": 50.0},
    )
    tip = wo.simulate(strip).probes["tip"]
    radius = np.linalg.norm(tip[:, :2], axis=1)
    strain = 0.1 * 50.0**2 / (2.5e9 * 0.1 * 1e-4)
    assert radius.mean() - 1.0 == pytest.approx(strain, rel=0.1)
    assert radius.max() - 1.0 == pytest.approx(2.0 * strain, rel=0.1)  # released unstretched


def test_wrong_masses_are_refused():
    with pytest.raises(InputError, match=r"mass\.0\.value"):
        scene(mass=[{"at": {"all": True}, "value": 0.0}])
    with pytest.raises(InputError, match=r"mass\.0\.at"):
        scene(mass=[{"value": 1.0}])
    with pytest.raises(InputError, match=r"mass\.0\.at"):
        system_of(scene(mass=[{"at": {"circle": [9.0, 9.0, 0.1]}, "value": 1.0}]))
