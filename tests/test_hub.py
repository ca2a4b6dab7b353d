"""A rigid hub: rigid, conserving, driven or held as it is mounted, and what is fixed to it goes along."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import warp_origami as wo
from membrane_cases import rotation
from runs import run, system_of
from warp_origami.errors import InputError
from warp_origami.terms.hub import PAIRS, RigidHub, hub_masses, spinning_stress

FILM = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 7.5e-6}
CENTRE = {"box": [[-0.5, -0.5], [0.5, 0.5]]}


def scene(duration=1.0, hub=None, step=0.01, radius=0.6, integrator=None, **tables):
    """A square of 4 m with 6 x 6 cells, its inner 2 x 2 cells fixed to a hub."""
    base = {
        "pattern": {"kind": "sheet", "width": 3.0, "height": 3.0, "nx": 6, "ny": 6, "origin": [-1.5, -1.5]},
        "material": FILM,
        "hub": {"at": CENTRE, "mass": 3.0, "axial_inertia": 2.0, "transverse_inertia": 1.5} | (hub or {}),
        "integrator": {"step": step, "spectral_radius": radius} | (integrator or {}),
        "output": {"fps": 1.0},
    }
    return wo.Scene(name="hub", analysis={"kind": "dynamic", "duration": duration}, **(base | tables))


def spinning(duration, step, radius, rate=(0.0, 0.0, 1.0), **options):
    """All fixed to the hub: a rigid body."""
    spin = {"kind": "initial_spin", "rate": float(np.linalg.norm(rate)), "axis": list(rate)}
    return scene(duration, step=step, radius=radius, load=[spin], hub={"at": {"all": True}} | options, pattern=SMALL)


SMALL = {"kind": "sheet", "nx": 1, "ny": 1, "origin": [-0.5, -0.5], "creases_x": []}


def test_energy_force_and_tangent_fit_and_rigid_motion_is_free():
    hub = RigidHub(0, 7.0, np.diag([0.2, 0.1, 0.3]))
    rng = np.random.default_rng(2)
    q, d = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))

    class Blocks:
        def write_at(self, begin, values):
            self.values = values

    def tangent(q):
        blocks, matrix = Blocks(), np.zeros((4, 3, 4, 3))
        hub.add_tangent(q, blocks, 0)
        for (k, m), block in zip(PAIRS, blocks.values, strict=True):
            matrix[k, :, m] = block
            matrix[m, :, k] = block.T
        return matrix

    h = 1e-5
    energy, gradient = hub.gradient(q)
    rise = (hub.gradient(q + h * d)[0] - hub.gradient(q - h * d)[0]) / (2 * h)
    assert rise == pytest.approx(np.sum(gradient * d), rel=1e-8)
    change = (hub.gradient(q + h * d)[1] - hub.gradient(q - h * d)[1]) / (2 * h)
    np.testing.assert_allclose(np.einsum("iajb,jb->ia", tangent(q), d), change, rtol=1e-7)
    turn = rotation([1, 2, 3], 1.0)
    assert hub.gradient(q @ turn.T + [1.0, 2.0, 3.0] * np.array([[1], [0], [0], [0]]))[0] == pytest.approx(energy)
    np.testing.assert_allclose(np.cross(q, gradient).sum(axis=0), 0.0, atol=1e-12)


def test_a_spinning_frame_is_in_balance_at_the_start():
    """J_k d_k'' = -sum_l p_kl d_l is what a rigid body does, whatever its axis."""
    masses, rate = hub_masses(3.0, 2.0, 1.5), np.array([0.3, -0.5, 1.1])
    inertia = np.array([1.5, 1.5, 2.0])
    turning = np.linalg.solve(np.diag(inertia), -np.cross(rate, inertia * rate))  # Euler
    needed = [np.cross(turning, e) + np.cross(rate, np.cross(rate, e)) for e in np.eye(3)]
    np.testing.assert_allclose(-spinning_stress(masses, rate), masses[1:, None] * needed, atol=1e-14)


def test_torque_free_rotation_is_that_of_euler():
    """About an axis that is no principal one: the body wobbles as the exact solution says, and the momentum stays."""
    rate = np.array([0.6, 0.2, 1.0])
    scene = spinning(4.0, 0.02, 0.9, rate)
    got = run(scene)
    system = system_of(scene)
    first, frame = system.hub.first, system.hub.frame
    sheet = FILM["density"] * FILM["thickness"] / 12.0
    inertia = np.array([1.5 + sheet, 1.5 + sheet, 2.0 + 2.0 * sheet])

    def motion(_, y):
        turn, w = y[:9].reshape(3, 3), y[9:]  # columns: the axes of the body
        spin = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return np.concatenate([(turn @ spin).ravel(), -np.cross(w, inertia * w) / inertia])

    start = np.concatenate([frame.T.ravel(), frame @ rate])
    exact = solve_ivp(motion, (0.0, 4.0), start, rtol=1e-10, atol=1e-12).y[:9, -1].reshape(3, 3)
    np.testing.assert_allclose(got.q[-1][first + 1 : first + 4].T, exact, atol=2e-3)
    momentum = np.array([np.cross(q, system.mass @ v).sum(axis=0) for q, v in zip(got.q, got.v, strict=True)])
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-4)


@pytest.mark.parametrize(("radius", "factor"), [(0.3, 0.16), (0.6, 0.017)])
def test_loss_of_angular_momentum_is_of_third_order_in_the_step(radius, factor):
    """Of about factor (w h)^3 per radian: what docs/spin.md says."""
    losses = []
    for step in (0.1, 0.05):
        result = wo.simulate(spinning(6.0, step, radius))
        losses.append(-result.summary["angular_momentum_change"])
        assert np.ptp(result.spin["moment_of_inertia"]) < 1e-6 * result.spin["moment_of_inertia"][0]
    assert losses[0] / losses[1] == pytest.approx(8.0, rel=0.25)
    assert losses[1] == pytest.approx(factor * 0.05**3 * 6.0, rel=0.2)


def test_the_sheet_goes_along_and_keeps_the_angular_momentum():
    load = [{"kind": "initial_spin", "rate": 1.0}]
    tips = [{"at": {"near": [x, y]}, "value": 0.1} for x in (-1.5, 1.5) for y in (-1.5, 1.5)]
    result = wo.simulate(scene(1.5, load=load, mass=tips))
    sheet = FILM["density"] * FILM["thickness"] * 9.0 * 9.0 / 6.0
    inertia = 2.0 + sheet + 0.4 * 2.0 * 1.5**2
    assert result.spin["moment_of_inertia"][0] == pytest.approx(inertia, rel=1e-9)
    momentum = result.spin["angular_momentum.z"]
    assert momentum[0] == pytest.approx(inertia, rel=1e-6)
    assert np.abs(momentum / momentum[0] - 1.0).max() < 2e-4
    assert result.summary["angular_momentum_change"] == pytest.approx(momentum[-1] / momentum[0] - 1.0, abs=1e-7)
    assert "rigid hub (free)" in result.summary["terms"]


def test_everything_starts_as_one_rigid_body():
    """Slopes and points alike: the spin has no strain rate, and constraints leave it as it is."""
    load = [{"kind": "initial_spin", "rate": 2.0, "axis": [1.0, 2.0, 2.0], "centre": [0.3, 0.0, 0.1]}]
    folds = {"kind": "sheet", "nx": 3, "ny": 3, "origin": [-1.5, -1.5], "creases_x": [1], "creases_y": [1]}
    system = system_of(scene(load=load, pattern=folds | {"width": 3.0, "height": 3.0}))
    centre = np.outer(system.translation, [0.3, 0.0, 0.1])
    expected = np.cross(2.0 * np.array([1.0, 2.0, 2.0]) / 3.0, system.q0 - centre)
    np.testing.assert_allclose(system.v0, expected, atol=1e-13)


def test_both_forms_of_the_constraints_give_the_same_motion():
    load = [{"kind": "initial_spin", "rate": 1.0}, {"kind": "gravity", "acceleration": [0.0, 0.0, -1.0]}]
    ends = [run(scene(0.1, load=load, integrator={"constraints": form})).q[-1] for form in ("eliminate", "multipliers")]
    np.testing.assert_allclose(*ends, atol=1e-8)


def test_points_and_edges_between_them_stay_fixed_to_the_hub():
    load = [{"kind": "gravity", "acceleration": [0.3, 0.1, -1.0]}, {"kind": "initial_spin", "rate": 1.0}]
    here = scene(0.3, load=load)
    system, q = system_of(here), run(here).q[-1]
    c, frame = q[system.hub.first], q[system.hub.first + 1 : system.hub.first + 4]
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-5)
    fixed = np.abs(system.mesh.vertices).max(axis=1) <= 0.5
    places = np.column_stack([system.mesh.vertices[fixed], np.zeros(fixed.sum())])
    np.testing.assert_allclose(q[system.coordinates.positions[fixed]], c + places @ frame, atol=1e-12)
    inner = np.flatnonzero(fixed[system.mesh.triangles].all(axis=1))
    for row in np.unique(system.coordinates.elements[inner][:, [1, 4, 7]]):
        np.testing.assert_allclose(q[row : row + 2], frame[:2], atol=1e-12)


def test_a_hub_on_an_axis_turns_about_it_alone():
    load = [{"kind": "initial_spin", "rate": 1.0}, {"kind": "gravity", "acceleration": [0.5, 0.0, -1.0]}]
    here = scene(0.5, load=load, hub={"mount": "axis"})
    system, got = system_of(here), run(here)
    rows = got.q[:, system.hub.first : system.hub.first + 4]
    np.testing.assert_allclose(rows[:, 0], 0.0, atol=1e-14)
    np.testing.assert_allclose(rows[:, 3], np.broadcast_to([0.0, 0.0, 1.0], (len(rows), 3)), atol=1e-14)
    assert np.abs(rows[:, 1:3, 2]).max() < 1e-6
    assert 0.4 < np.arctan2(rows[-1, 1] @ system.hub.frame[1], rows[-1, 1] @ system.hub.frame[0]) < 0.51
    # what holds the axis is a reaction of its own: at the start it bears the weight of hub and sheet
    force = got.reactions["hub"][:, :3]
    assert np.abs(force[:, 2]).max() > 2.0


def test_a_driven_hub_turns_as_its_profile_says():
    here = scene(0.5, hub={"mount": "driven", "angle": 1.0, "profile": {"kind": "smooth"}}, step=0.01)
    result = wo.simulate(here)
    s = result.history["time"] / 0.5
    np.testing.assert_allclose(result.spin["rate"], 30.0 * s**2 * (1.0 - s) ** 2 / 0.5, atol=1e-2)
    work = result.history["external_work"]
    assert work.max() > 0.9 * 0.5 * 2.0 * 3.75**2  # the largest rate is 15/8 of the mean


def test_wrong_hubs_are_refused():
    with pytest.raises(InputError, match=r"hub\.transverse_inertia"):
        scene(hub={"transverse_inertia": 0.9})
    with pytest.raises(InputError, match=r"hub\.angle"):
        scene(hub={"angle": 1.0})
    with pytest.raises(InputError, match=r"hub\.angle"):
        scene(hub={"mount": "driven"})
    with pytest.raises(InputError, match=r"hub\.axis"):
        scene(hub={"axis": [0.0, 0.0, 0.0]})
    with pytest.raises(InputError, match=r"support\.0\.at"):
        system_of(scene(support=[{"at": CENTRE}]))
    with pytest.raises(InputError, match=r"hub\.profile"):
        scene(hub={"mount": "driven", "angle": 1.0, "profile": {"table": [[0.0, 1.0], [1.0, 2.0]]}})
    with pytest.raises(InputError, match=r"load\.0"):
        wo.Scene(
            name="static",
            analysis={"kind": "static"},
            pattern=SMALL,
            material=FILM,
            load=[{"kind": "initial_spin", "rate": 1.0}],
        )


@pytest.mark.parametrize(("rings", "segments"), [(2, 12), (4, 24)])
def test_a_round_hub_holds_the_film_as_a_driver_of_its_rim_does(rings, segments):
    """Torque of an annulus twisted by 0.02 rad: a polygon that stands for a circle holds its mean direction only."""
    inner, torques = {"circle": [0.0, 0.0, 0.2]}, []
    for moved in (
        {"hub": {"at": inner, "mass": 0.1, "axial_inertia": 1e-3, "mount": "driven", "angle": 0.02}},
        {"driver": [{"at": inner, "rotate": {"axis": [0.0, 0.0, 1.0], "angle": 0.02}}]},
    ):
        annulus = wo.Scene(
            name="annulus",
            analysis={"kind": "static", "load_steps": 2},
            pattern={"kind": "annulus", "inner_radius": 0.2, "outer_radius": 0.5, "rings": rings, "segments": segments},
            material=FILM | {"model": "linear"},
            support=[{"name": "rim", "at": {"circle": [0.0, 0.0, 0.5]}}],
            **moved,
        )
        torques.append(wo.simulate(annulus, device="cpu").reactions["rim"][-1, 5])
    assert torques[0] == pytest.approx(torques[1], rel=1e-9)


def test_stiffness_damping_is_none_of_the_hub():
    """It would brake the rotation of a rigid body by a tenth within a tenth of a turn; the film's share is small."""
    spin, damped = {"kind": "initial_spin", "rate": 3.0}, FILM | {"stiffness_damping": 1e-6}
    body = scene(0.2, {"at": {"all": True}}, 2e-3, 0.9, load=[spin], material=damped, pattern=SMALL)
    assert abs(wo.simulate(body, device="cpu").summary["angular_momentum_change"]) < 1e-3


def test_change_of_angular_momentum_is_told_only_where_there_is_some_to_keep():
    still = scene(0.02, hub={"mount": "driven", "angle": 0.1})
    assert "angular_momentum_change" not in wo.simulate(still, device="cpu").summary
    spun = spinning(0.02, 0.01, 0.6)
    assert "angular_momentum_change" in wo.simulate(spun, device="cpu").summary


def test_expected_speed_is_that_of_what_a_driven_hub_leads():
    """Half a turn in a second, smooth: 1.875 pi rad/s at most, at 0.71 m from the axis."""
    contact = {"expected_speed": "auto", "sts_stiffness": "auto", "nts_stiffness": "auto"}
    system = system_of(scene(1.0, hub={"mount": "driven", "angle": np.pi}, contact=contact))
    speed = 1.875 * np.pi * np.sqrt(0.5)
    assert speed < system.contact_settings.expected_speed < 3.0 * speed


def test_a_support_cannot_have_the_name_of_a_hub_with_reactions():
    support = [{"name": "hub", "at": {"near": [1.5, 1.5]}}]
    with pytest.raises(InputError, match=r"support\.0\.name.*the hub has it"):
        scene(hub={"mount": "axis"}, support=support)
    scene(hub={"mount": "free"}, support=support)
