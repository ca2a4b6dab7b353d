"""Penalties that the scene's speeds and loads ask for: what is penetrated is what was wanted."""

import numpy as np
import pytest

import warp_origami as wo
from contact_cases import TwoSheets
from contact_meshes import grid
from flying_sheets import AREAL_MASS, FILM, corner_over_sheet, facing
from runs import film, system_of
from warp_origami.errors import InputError
from warp_origami.scene.approach import WORKING_STRAIN
from warp_origami.terms.inertia import mass_matrix
from warp_origami.terms.shapes import tabulate

THICKNESS = FILM["thickness"]
AUTO = {"sts_stiffness": "auto", "nts_stiffness": "auto"}


def settings_of(scene):
    return system_of(scene).contact_settings


@pytest.mark.parametrize("speed, share", [(1.0, 0.01), (10.0, 0.05)])
def test_sheets_that_meet_flat_penetrate_by_the_target(tmp_path, speed, share):
    contact = {"method": "sts", "sts_stiffness": "auto", "target_penetration": share}
    depth = share * THICKNESS
    time = np.pi * depth / speed  # of contact: pi d / v
    gap = THICKNESS + 5.0 * depth
    integrator = {"step": time / 40, "spectral_radius": 1.0}
    scene = facing(tmp_path, contact, 5.0 * depth / speed + 1.2 * time, speed, gap=gap, integrator=integrator)
    result = wo.simulate(scene, device="cpu")
    assert result.summary["expected_speed"] == pytest.approx(speed)
    assert result.summary["sts_stiffness"] == pytest.approx(AREAL_MASS * speed**2 / (2 * depth**2))
    assert result.summary["max_penetration"] == pytest.approx(depth, rel=0.02)


@pytest.mark.parametrize("speed", [1.0, 10.0, 50.0])
def test_a_corner_poked_into_a_sheet_stays_below_the_target(tmp_path, speed):
    """The corner moves a fiftieth of its element's mass: a quarter of the target, at every speed."""
    step = 5e-7 / speed
    scene = corner_over_sheet(
        tmp_path, AUTO, (1e-4 + 1.2e-5) / speed, speed, integrator={"step": step, "spectral_radius": 0.8}
    )
    result = wo.simulate(scene, device="cpu")
    assert 0.05 < result.summary["max_penetration"] / (0.01 * THICKNESS) < 1.0


def test_mass_that_a_point_moves():
    """1 / (s^T M^-1 s): 0.4 (median) to 0.95 of an element's mass, at a corner a fiftieth or so, on any sub-mesh."""
    for n in (3, 6):
        sheets = TwoSheets(grid(n, n), grid(n, n))
        mass = mass_matrix(sheets.mesh, sheets.coordinates, 1420.0, THICKNESS).toarray()
        for divisions in (2, 4):
            sub = sheets.contact(divisions=divisions).submesh
            shapes = tabulate(sheets.mesh, sub.elements, sub.areas).interpolation(sheets.coordinates).toarray()
            moved = 1.0 / np.einsum("ij,ji->i", shapes, np.linalg.solve(mass, shapes.T))
            moved /= AREAL_MASS * sheets.mesh.areas.mean()
            assert 0.3 < np.median(moved) < 0.6 and moved.max() < 1.0 and 0.01 < moved.min() < 0.025


def test_pressure_is_borne_at_the_target_depth():
    quiet = film(1.0, {}, contact=AUTO | {"expected_speed": 0.0})
    base = 2.5e9 * 5e-4 * WORKING_STRAIN / system_of(quiet).mesh.size
    depth = 0.01 * THICKNESS
    assert settings_of(quiet).sts_stiffness == pytest.approx(base / depth)
    pressed = film(1.0, {}, contact=AUTO | {"expected_speed": 0.0}, load=[{"kind": "pressure", "value": -2e4}])
    assert settings_of(pressed).sts_stiffness == pytest.approx((base + 2e4) / depth)
    pushed = {"kind": "force", "value": [0.0, 0.0, 30.0], "at": {"near": [0.0, 0.0]}}
    assert (
        settings_of(film(1.0, {}, contact=AUTO | {"expected_speed": 0.0}, load=[pushed])).nts_stiffness == 30.0 / depth
    )


def test_speeds_come_from_drivers_initial_velocities_and_loads():
    held = {"at": {"near": [0.0, 0.0]}, "fix": "xyz"}
    drive = {"at": {"near": [0.6, 0.6]}, "translate": [-0.3, -0.4, 0.0]}

    def speed(**tables):
        return settings_of(film(2.0, {}, contact=AUTO, **tables)).expected_speed

    assert speed() == 0.0
    assert speed(support=[held], driver=[drive]) == pytest.approx(0.5 * 1.875 / 2.0)
    turn = {"at": {"near": [0.6, 0.6]}, "rotate": {"axis": [0, 0, 1], "angle": 0.1}, "profile": {"kind": "linear"}}
    assert speed(driver=[turn]) == pytest.approx(0.6 * np.sqrt(2) * 0.1 / 2.0, rel=0.1)
    throw = {"kind": "initial_velocity", "value": [0.0, 3.0, 4.0]}
    assert speed(load=[throw]) == 0.0  # all of it: nothing meets
    assert speed(load=[throw | {"at": {"near": [0.6, 0.6]}}]) == pytest.approx(5.0)
    fall = {"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}
    assert speed(load=[fall]) == pytest.approx(np.sqrt(2 * 9.81 * 0.6 * np.sqrt(2)))
    assert speed(load=[fall | {"profile": {"table": [[0.0, 0.0], [2.0, 0.01]]}}]) == pytest.approx(0.01 * 9.81 * 2.0)


def test_leaf_in_gets_about_the_stiffness_of_the_paper():
    """1e8 N/m^3 and 3e6 N/m there."""
    found = settings_of(wo.load_scene("leaf_in", ["contact.sts_stiffness=auto", "contact.nts_stiffness=auto"]))
    assert 1e8 < found.sts_stiffness < 1e9 and 3e5 < found.nts_stiffness < 3e6


def test_numbers_that_are_given_stay_and_auto_stays_in_the_file():
    scene = wo.load_scene("leaf_in", ["contact.sts_stiffness=auto", "contact.expected_speed=2.0"])
    found = settings_of(scene)
    assert found.nts_stiffness == 3e6 and found.expected_speed == 2.0
    assert scene.contact.sts_stiffness == "auto" and 'sts_stiffness = "auto"' in scene.to_toml()
    assert settings_of(scene) == found


@pytest.mark.parametrize(
    "override, key",
    [
        ("contact.sts_stiffness=soft", "contact.sts_stiffness"),
        ("contact.nts_stiffness=0", "contact.nts_stiffness"),
        ("contact.target_penetration=0", "contact.target_penetration"),
        ("contact.target_penetration=0.6", "contact.target_penetration"),
        ("contact.expected_speed=-1", "contact.expected_speed"),
        ("contact.exact=1", "contact.exact"),
    ],
)
def test_what_makes_no_sense_is_named(override, key):
    with pytest.raises(InputError, match=key.replace(".", r"\.")):
        wo.load_scene("leaf_in", [override])
