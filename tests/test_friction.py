"""Friction: force law, resultants, sliding, sticking, stopping, momentum and energy."""

import numpy as np
import pytest

import warp_origami as wo
from contact_cases import TwoSheets, wavy
from contact_meshes import grid
from friction_cases import AREAL_MASS, LOWER, MASS, SIDE, UPPER, pressed, sliding, thrown
from runs import film, run, system_of
from warp_origami.errors import InputError
from warp_origami.solve.constraint_form import make_constraint_form
from warp_origami.solve.generalized_alpha import GeneralizedAlpha
from warp_origami.solve.step_potential import StepPotential
from warp_origami.terms.contact.friction import FrictionLaw

MU = 0.3
METHODS = pytest.mark.parametrize("method", ["sts", "nts", "mixed"])


class Touching:
    """Two sheets 10 um into each other, and their friction."""

    def __init__(self, lower, upper, method="mixed", seed=None, speed=1e-3):
        self.sheets = TwoSheets(lower, upper)
        contact = self.sheets.contact(method)
        self.q = self.sheets.at(1e-3 - 1e-5)
        if seed is not None:
            self.q = wavy(self.sheets.coordinates, self.q, seed, position=3e-6, slope=1e-3)
        self.pull = self.sheets.force(contact, self.q)
        self.contacts = contact.statistics()
        law = FrictionLaw(self.sheets.mesh, self.sheets.coordinates, MU, speed)
        self.friction = law.between(contact.active_pairs(), self.q)

    def random_velocity(self, seed, size=2e-3):
        return size * np.random.default_rng(seed).normal(size=self.q.shape)

    def resultant(self, v):
        """Friction on the upper sheet, N."""
        forces = -self.friction.resistance(v).reshape(-1, 3)
        return forces[self.sheets.coordinates.positions[self.sheets.above]].sum(axis=0)


def crossing_strips(method="mixed", seed=None):
    return Touching(grid(4, 1, (1.0, 0.1)), grid(1, 3, (0.1, 0.9), angle=0.3), method, seed)


def turned_squares(method="mixed", seed=None):
    return Touching(grid(2, 2), grid(3, 3, (0.6, 0.6), angle=0.4), method, seed)


CASES = pytest.mark.parametrize("case", [crossing_strips, turned_squares])


@CASES
def test_resistance_is_the_derivative_of_the_potential_and_the_tangent_that_of_the_resistance(case):
    touching = case(seed=1)
    friction, v = touching.friction, touching.random_velocity(2).ravel()
    d = np.random.default_rng(3).normal(size=v.size)
    h = 1e-7
    slope = (friction.potential(v + h * d) - friction.potential(v - h * d)) / (2.0 * h)
    assert slope == pytest.approx(friction.resistance(v) @ d, rel=1e-7)
    rows, weights = friction.tangent(v)
    assert (weights > 0.0).all()
    change = (friction.resistance(v + h * d) - friction.resistance(v - h * d)) / (2.0 * h)
    expected = rows.T @ (weights * (rows @ d))
    np.testing.assert_allclose(change, expected, atol=1e-6 * np.abs(expected).max())


@CASES
@METHODS
def test_friction_has_no_resultant_and_no_moment(case, method):
    """Both sheets slip at one place, halfway between them: neither their distance nor waves leave a moment."""
    touching = case(method, seed=4)
    v = touching.random_velocity(5)
    forces = -touching.friction.resistance(v).reshape(-1, 3)
    positions = touching.sheets.coordinates.positions
    size = np.abs(forces[positions]).sum()
    assert size > 0.0
    assert np.abs(forces[positions].sum(axis=0)).max() < 1e-12 * size
    # the virtual work of a rigid rotation is the moment, whatever the coordinates are
    assert np.abs(np.cross(touching.q, forces).sum(axis=0)).max() < 1e-12 * size
    assert np.abs(forces[positions[touching.sheets.above]].sum(axis=0)).max() > 0.01 * size


@CASES
@METHODS
@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5])
def test_a_pressed_patch_resists_with_mu_times_the_normal_force(case, method, angle):
    """Whatever carries the normal force (both passes, nodes, edges) carries friction, and no more than once."""
    touching = case(method)
    assert (touching.contacts.contacts_edge > 0) == (case is crossing_strips and method == "mixed")
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    v = np.zeros_like(touching.q)
    positions = touching.sheets.coordinates.positions
    v[positions[touching.sheets.above]] = 2e-3 * along
    law = 2.0 / np.sqrt(2.0**2 + 1.0)
    normal = touching.pull[2]
    np.testing.assert_allclose(touching.resultant(v), -MU * law * normal * along, atol=1e-12 * normal)
    assert v.ravel() @ touching.friction.resistance(v) == pytest.approx(MU * law * normal * 2e-3, rel=1e-12)


def test_tangent_of_a_step_is_the_derivative_of_its_balance(tmp_path):
    system = system_of(pressed(tmp_path, 0.02, {"friction": MU, "friction_speed": 0.05}, turn=0.4))
    assert "friction" in system.terms
    method = GeneralizedAlpha(0.3)
    start = method.start(0.0, system.q0, system.v0, 0.0 * system.q0, 0.0 * system.q0, 1e-3)
    form = make_constraint_form(system, system.mass)
    potential = StepPotential(system, form, method.form(start, 1e-3), system.external.at(1e-3))
    c = system.constraints
    prescribed = c.right_inverse @ c.values(1e-2)  # pressed as deep as it will be

    def within(q):
        return c.null_space @ (c.left_inverse @ (q.ravel() - prescribed)) + prescribed

    rng = np.random.default_rng(0)
    q = within(system.q0 + 1e-5 * rng.normal(size=system.q0.shape) * system.row_lengths[:, None])
    system.evaluate(q.reshape(-1, 3))
    potential.friction = system.friction_at(q.reshape(-1, 3))
    assert len(potential.friction.limits) > 20
    gradient, direction = potential.linearize(q)
    step = direction(gradient)
    h = 1e-5
    change = (potential.gradient(q + h * step) - potential.gradient(q - h * step)) / (2.0 * h)
    reduced, expected = c.null_space.T @ change, -c.null_space.T @ gradient
    assert np.abs(reduced - expected).max() < 1e-6 * np.abs(expected).max()


def normal_force(result):
    return result.reactions["held"][:, 2]


@pytest.mark.parametrize("method, turn", [("sts", 0.4), ("nts", 0.4), ("mixed", 0.0)])
def test_a_thrown_plate_is_braked_and_stops(tmp_path, method, turn):
    """On meshes that do not match, in any direction of their edges; its kinetic energy is what friction dissipates."""
    speed = 0.3
    contact = {"method": method, "friction": 2.0 * MU}
    load, integrator = [thrown([speed, 0.0, 0.0])], {"step": 1e-3}
    result = run(pressed(tmp_path, 0.045, contact, turn, load=load, integrator=integrator))
    limit = 2.0 * MU * normal_force(result)
    time, v = result.history["time"], result.probes["upper"][:, 3:5]
    slides = np.flatnonzero((time > 8e-3) & (v[:, 0] > 0.2 * speed))
    assert len(slides) >= 4
    impulse = 1e-3 * (limit[slides].sum() - 0.5 * (limit[slides[0]] + limit[slides[-1]]))
    # where points lie under the rim of the plate, the normal of contact is not quite that of the sheet
    assert MASS * (v[slides[0], 0] - v[slides[-1], 0]) == pytest.approx(impulse, rel=5e-3)
    np.testing.assert_allclose(result.reactions["held"][slides, 0], -limit[slides], rtol=5e-3)
    assert np.abs(v[-1]).max() < 1e-6
    dissipated = result.history["dissipated"]
    assert np.diff(dissipated).min() > -1e-4 * dissipated[-1]  # in the step in which it stops
    assert dissipated[-1] == pytest.approx(0.5 * MASS * speed**2, rel=5e-3)
    assert max(result.summary["energy_gain"], result.summary["energy_loss"]) < 1e-2
    assert result.summary["terms"].count("friction") == 1


def test_it_stops_where_coulomb_says(tmp_path):
    """v dv = -mu N(t) / m dx with the force of the prescribed depth, which grows to that of 20 um."""
    contact = {"friction": MU, "friction_speed": 1e-5}
    result = run(pressed(tmp_path, 0.04, contact, load=[thrown([0.2, 0.0, 0.0])], integrator={"step": 1e-3}))
    time = np.linspace(0.0, 0.04, 40001)
    s = np.minimum(time / 8e-3, 1.0)
    deceleration = MU * normal_force(result)[-1] / MASS * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
    v = np.maximum(
        0.2 - np.concatenate([[0.0], np.cumsum(0.5 * (deceleration[1:] + deceleration[:-1]))]) * time[1], 0.0
    )
    moved = result.probes["upper"][-1, 0] - result.probes["upper"][0, 0]
    assert moved == pytest.approx(np.sum(0.5 * (v[1:] + v[:-1])) * time[1], rel=2e-3)


def test_below_the_limit_it_sticks_and_creeps_as_slowly_as_stated(tmp_path):
    pull = {"kind": "gravity", "acceleration": [4.0, 0.0, 0.0]}
    contact = {"friction": MU, "friction_speed": 1e-3}
    result = run(pressed(tmp_path, 0.03, contact, 0.4, load=[pull], integrator={"step": 1e-3}))
    share = MASS * 4.0 / (MU * normal_force(result)[-1])
    assert 0.4 < share < 0.7
    assert result.probes["upper"][-1, 3] == pytest.approx(1e-3 * share / np.sqrt(1.0 - share**2), rel=1e-2)


@pytest.mark.parametrize("angle, mu", [(0.6, 0.3), (0.2, 0.5)])
def test_a_sheet_on_an_inclined_one(tmp_path, angle, mu):
    """Its impulse along the slope is m g t sin a less mu times that of the normal force, m g t cos a + m v_z, also
    while it bounces. Where tan a < mu it stays."""
    g = 9.81 * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    scene = sliding(
        tmp_path,
        0.05,
        grid(1, 1, (0.6, 0.6), angle=0.3),
        grid(1, 1, (SIDE, SIDE)),
        {"sts_stiffness": 1e5, "friction": mu},
        support=[{"at": LOWER, "fix": "xyz"}],
        load=[{"kind": "gravity", "acceleration": g.tolist()}],
    )
    result = run(scene)
    system = system_of(scene)
    v = (system.mass @ result.v[-1])[system.coordinates.positions[system.mesh.vertices[:, 0] > 1.0]].sum(axis=0) / MASS
    if np.tan(angle) > mu:
        assert v[0] == pytest.approx(g[0] * 0.05 - mu * (-g[2] * 0.05 + v[2]), rel=1e-2)
    else:
        assert abs(v[0]) < 2e-3
        assert g[0] * 0.05 > 0.05


SQUARES = grid(1, 1, (SIDE, SIDE)), grid(2, 2, (SIDE, SIDE), angle=0.3), "sts"
STRIPS = grid(2, 1, (0.3, 0.04)), grid(1, 2, (0.04, 0.3), angle=0.2), "mixed"


def oblique(tmp_path, case, mu):
    """Two free sheets thrown onto each other obliquely."""
    lower, upper, method = case
    return sliding(
        tmp_path,
        2.5e-3,
        lower,
        upper,
        {"method": method, "friction": mu},
        height=5.2e-4,
        load=[thrown([-0.2, 0.0, 0.25], LOWER), thrown([0.2, 0.1, -0.25], UPPER)],
        integrator={"step": 1e-4, "spectral_radius": 1.0},
    )


@pytest.fixture(scope="module", params=[SQUARES, STRIPS], ids=["squares", "crossing strips"])
def impacts(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("oblique")
    system = system_of(oblique(folder, request.param, 0.0))
    return system, {mu: run(oblique(folder, request.param, mu)) for mu in (0.0, 0.4)}


def test_two_free_sheets_keep_their_momentum(impacts):
    system, results = impacts
    positions = system.coordinates.positions

    def momenta(result):
        p = [system.mass @ v for v in result.v]
        linear = np.array([each[positions].sum(axis=0) for each in p])
        return linear, np.array([np.cross(q, each).sum(axis=0) for q, each in zip(result.q, p, strict=True)])

    (_, smooth), (linear, angular) = momenta(results[0.0]), momenta(results[0.4])
    scale = AREAL_MASS * system.mesh.areas.sum() * 0.25
    assert np.abs(linear - linear[0]).max() < 1e-9 * scale
    # the method of integration keeps angular momentum to second order only; friction makes it no worse
    assert np.abs(angular - angular[0]).max() < 2.0 * np.abs(smooth - smooth[0]).max() + 1e-12 * scale * SIDE
    along = results[0.4].probes["upper"][-1, 3:5]
    assert np.linalg.norm(along) < 0.98 * np.linalg.norm([0.2, 0.1])


def test_an_oblique_impact_keeps_its_energy_balance(impacts):
    """As well as without friction, though friction begins and ends within steps."""
    _, results = impacts
    smooth, rough = results[0.0].summary, results[0.4].summary
    for name in ("energy_gain", "energy_loss"):
        assert rough[name] < smooth[name] + 1e-3
    history = results[0.4].history
    assert history["dissipated"][-1] > 0.1 * history["kinetic_energy"][0]
    assert (np.diff(history["dissipated"]) >= 0.0).all()


def test_second_order_in_time(tmp_path):
    """Force and place of contact are those of the end of the step: position, dissipation and energy error."""
    results = []
    for step in (2e-3, 1e-3, 5e-4):
        contact = {"friction": MU, "friction_speed": 0.02}
        integrator = {"step": step}
        result = run(pressed(tmp_path, 0.016, contact, 0.4, 0.016, [thrown([0.3, 0.0, 0.0])], integrator))
        last = {name: column[-1] for name, column in result.history.items()}
        results.append([result.probes["upper"][-1, 0], last["dissipated"], last["energy_error"]])
    changes = np.abs(np.diff(results, axis=0))
    assert (changes[1:] < 0.3 * changes[:-1]).all()
    assert abs(results[-1][2]) < 5e-4 * results[-1][1]


def test_without_friction_nothing_of_it_is_there(tmp_path):
    """mu = 0 gives the bits of a scene that does not know the word."""
    load = [thrown([0.1, 0.0, 0.0])]
    plain, zero = (
        run(pressed(tmp_path, 0.01, contact, load=load)) for contact in ({}, {"friction": 0.0, "friction_speed": 7.0})
    )
    for name in ("q", "v", "accelerations"):
        assert np.array_equal(getattr(plain, name), getattr(zero, name))
    assert "friction" not in zero.summary["terms"]
    assert system_of(pressed(tmp_path, 0.01, {"friction": 0.0})).friction is None


@pytest.mark.parametrize("kind", ["static", "modal"])
def test_friction_needs_motion(kind):
    moving = film(1.0, {}, contact={"friction": 0.3}).model_dump(exclude_none=True)
    with pytest.raises(InputError) as caught:
        wo.Scene(**moving | {"analysis": {"kind": kind}})
    assert "contact.friction" in str(caught.value)


@pytest.mark.parametrize("key, value", [("friction", -0.1), ("friction_speed", 0.0)])
def test_law_out_of_range(key, value):
    with pytest.raises(InputError) as caught:
        film(1.0, {}, contact={key: value})
    assert f"contact.{key}" in str(caught.value)
