"""Supports and drivers: right-hand sides and their derivatives, conflicts, reactions of a run."""

import numpy as np
import pytest

import warp_origami as wo
from membrane_cases import rotation
from runs import GRAVITY, film, run, system_of
from warp_origami.errors import InputError
from warp_origami.model.generators import build_pattern

BOTTOM = {"box": [[0.0, 0.0], [0.6, 0.0]]}
TOP = {"box": [[0.0, 0.6], [0.6, 0.6]]}
TURN = {"axis": [1.0, 2.0, -0.5], "centre": [0.1, -0.2, 0.3], "angle": 1.3}
MOTIONS = {
    "translation": {"translate": [0.1, -0.2, 0.3]},
    "rotation": {"rotate": TURN},
    "both": {"translate": [0.1, -0.2, 0.3], "rotate": TURN},
    "deployed": {"translate_to": "deployed", "overstretch": 0.01},
}


def driven(motion, at=TOP, duration=2.0, **tables):
    """A sheet stretched by 3 % and 2 % at the start whose upper edge is driven."""
    pattern = {"initial": {"stretch": [1.03, 1.02]}}
    return film(duration, pattern, driver=[{"name": "d", "at": at, **motion}], **tables)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("profile", ["linear", "smooth", "trapezoid"])
def test_derivatives_of_prescribed_values_agree_with_differences(motion, profile):
    constraints = system_of(driven(MOTIONS[motion] | {"profile": {"kind": profile}})).constraints
    h = 1e-4
    for t in (0.3, 0.9, 1.7):
        before, here, after = (constraints.values(time) for time in (t - h, t, t + h))
        velocity, acceleration = constraints.derivatives(t)
        np.testing.assert_allclose((after - before) / (2 * h), velocity, atol=1e-7)
        np.testing.assert_allclose((after - 2 * here + before) / h**2, acceleration, atol=1e-6)
        assert np.abs(velocity).max() > 1e-3


def held(system, time):
    """q that prescribes what it must and leaves the rest as it starts."""
    c = system.constraints
    q = system.q0.ravel()
    return (q + c.right_inverse @ (c.values(time) - c.equations @ q)).reshape(-1, 3)


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_initial_state_fulfils_the_equations(motion):
    system = system_of(driven(MOTIONS[motion]))
    np.testing.assert_allclose(held(system, 0.0), system.q0, atol=1e-14)


def test_a_driver_rotates_first_and_then_translates():
    system = system_of(driven(MOTIONS["both"]))
    rows = system.coordinates.positions[np.isclose(system.mesh.vertices[:, 1], 0.6)]
    centre = np.array(TURN["centre"])
    expected = centre + (system.q0[rows] - centre) @ rotation(TURN["axis"], 1.3).T + [0.1, -0.2, 0.3]
    np.testing.assert_allclose(held(system, 2.0)[rows], expected, atol=1e-14)


def test_a_driver_turns_the_slope_along_its_edge_and_stretches_nothing():
    system = system_of(driven(MOTIONS["both"]))
    corner = int(np.flatnonzero(np.isclose(system.mesh.vertices, [0.0, 0.6]).all(axis=1))[0])
    g = system.coordinates.sector_gradients[system.coordinates.sector_vertices == corner][0]
    expected = rotation(TURN["axis"], 1.3) @ system.q0[g]
    np.testing.assert_allclose(held(system, 2.0)[g], expected, atol=1e-14)


def test_deployed_is_the_flat_sheet_scaled():
    system = system_of(driven(MOTIONS["deployed"], at={"all": True}))
    mesh, coordinates = system.mesh, system.coordinates
    q = held(system, 2.0)
    np.testing.assert_allclose(q[coordinates.positions, :2], 1.01 * mesh.vertices, atol=1e-14)
    np.testing.assert_allclose(
        q[coordinates.sector_gradients], np.tile([1.01, 0, 0], (len(mesh.vertices), 1)), atol=1e-14
    )


def test_half_way_a_point_is_on_the_straight_line_to_where_it_is_deployed():
    system = system_of(driven(MOTIONS["deployed"]))
    ends = [held(system, t) for t in (0.0, 1.0, 2.0)]
    np.testing.assert_allclose(ends[1], 0.5 * (ends[0] + ends[2]), atol=1e-15)


def support(at, fix="xyz", name=None):
    return {"at": at, "fix": fix} | ({"name": name} if name else {})


def test_one_component_of_a_vertex_has_one_driver():
    driver = [{"at": TOP, "translate": [0, 0, 1.0], "axes": "z"}]
    for other in (support({"near": [0.6, 0.6]}, "yz"), support({"boundary": True})):
        with pytest.raises(
            InputError, match=r"driver\.0: got z of the vertex at \(.*\), which support\.0 prescribes too"
        ):
            system_of(film(1.0, {}, support=[other], driver=driver))
    with pytest.raises(InputError, match=r"driver\.1: got z of the vertex at \(0\.6, 0\.6\), which driver\.0"):
        twice = [*driver, {"at": {"near": [0.6, 0.6]}, "translate": [0, 0, 1.0]}]
        system_of(film(1.0, {}, driver=twice))
    system_of(film(1.0, {}, support=[support(TOP, "xy")], driver=driver))  # different components are no conflict


def test_two_supports_may_hold_the_same_and_the_first_bears_the_load():
    pattern = {"initial": {"stretch": [1.001, 1.001]}}
    overlapping = [support(BOTTOM, name="one"), support({"boundary": True}, name="two"), support(BOTTOM, name="three")]
    result = run(film(1e-3, pattern, support=overlapping, integrator={"step": 1e-4}))
    assert result.summary["status"] == "done"
    end = {name: values[-1] for name, values in result.reactions.items()}
    assert not end["three"].any()
    assert end["one"][1] < -1.0  # holds the tension of its whole edge
    np.testing.assert_allclose(end["one"] + end["two"], 0.0, atol=1e-6 * np.abs(end["one"]).max())


@pytest.mark.parametrize("form", ["eliminate", "multipliers"])
def test_a_rotating_sheet_is_not_strained_and_its_reactions_are_its_inertia(form):
    """All coordinates driven about an axis through the centre of mass: moment I dw/dt, no force, no strain energy."""
    motion = {"rotate": {"axis": [0, 0, 1], "centre": [0.3, 0.3, 0.0], "angle": 1.0}}
    driver = [{"name": "d", "at": {"all": True}, **motion}]
    mass, side = 1420.0 * 5e-4 * 0.36, 0.6
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        scene = film(0.1, {}, driver=driver, integrator={"step": step, "constraints": form})
        result = run(scene)
        assert result.history["strain_energy"].max() < 1e-18
        profile = scene.driver[0].profile.factor()
        expected = np.zeros((len(result.history["time"]), 6))
        expected[:, 5] = [mass * side**2 / 6.0 * profile(t, 2) for t in result.history["time"]]
        errors.append(np.abs(result.reactions["d"] - expected).max() / expected.max())
    print(f"errors of the reaction {errors}")
    assert errors[-1] < 1e-3
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(2.0, abs=0.1)


def test_reactions_balance_weight_inertia_and_their_moments_at_every_step():
    """Sum of forces = d(momentum)/dt - weight, sum of moments = d(angular momentum)/dt - moment of the weight."""
    tables = {"support": [support(BOTTOM, name="low")], "load": [GRAVITY | {"acceleration": [1.0, 2.0, -9.81]}]}
    driver = {"name": "d", "at": {"near": [0.6, 0.6]}, "translate": [0.01, -0.02, 0.05]}
    scene = film(0.05, {}, driver=[driver], **tables, integrator={"step": 1e-3, "tolerance": 1e-8})
    system = system_of(scene)
    result = run(scene)
    states, total = result.accelerations, result.reactions["low"] + result.reactions["d"]
    ones = np.zeros(system.coordinates.count)
    ones[system.coordinates.positions] = 1.0
    weight = np.outer(system.mass @ ones, [1.0, 2.0, -9.81])
    for q, a, reaction in zip(result.q, states, total[1:], strict=True):
        inertia = system.mass @ a - weight
        force, moment = inertia[system.coordinates.positions].sum(axis=0), np.cross(q, inertia).sum(axis=0)
        np.testing.assert_allclose(reaction[:3], force, atol=1e-8)
        np.testing.assert_allclose(reaction[3:], moment, atol=1e-8)
    assert np.abs(total).max() > 1.0


def test_a_hanging_sheet_pulls_with_its_weight():
    """Hung by its upper edge and damped to rest: reaction 2.5075 N upwards, moment about the origin weight x arm."""
    scene = film(
        0.5,
        {"nx": 2, "ny": 2},
        material={"mass_damping": 100.0},
        support=[support(TOP, name="top")],
        load=[GRAVITY | {"acceleration": [0.0, -9.81, 0.0]}],
    )
    result = run(scene)
    weight = 1420.0 * 5e-4 * 0.36 * 9.81
    reaction = result.reactions["top"][-1]
    print(f"weight {weight:.6f} N, reaction {reaction[1]:.6f} N, moment {reaction[5]:.6f} N m")
    np.testing.assert_allclose(reaction, [0, weight, 0, 0, 0, 0.3 * weight], atol=2e-5 * weight)


def test_a_curved_rim_is_held_alike_by_one_support_and_by_several_piece_by_piece():
    """Where the pieces meet, too, only the derivative along the mean direction is held."""
    disc = {"kind": "disc", "radius": 0.5, "rings": 2, "segments": 16}

    def constraints(*supports):
        scene = film(1.0, {}).model_dump(exclude_none=True) | {"pattern": disc, "support": list(supports)}
        return system_of(wo.Scene(**scene)).constraints

    vertices = build_pattern("disc", {k: v for k, v in disc.items() if k != "kind"}).mesh.vertices
    rim = np.flatnonzero(np.isclose(np.linalg.norm(vertices, axis=1), 0.5))
    order = rim[np.argsort(np.arctan2(vertices[rim, 1], vertices[rim, 0]))].tolist()
    one = constraints({"at": {"boundary": True}})
    pieces = [order[:7], order[6:12], [*order[11:], order[0]]]
    several = constraints(*({"at": {"vertices": piece}} for piece in pieces))
    mixed = constraints({"at": {"vertices": pieces[0] + pieces[1]}}, {"at": {"vertices": pieces[2]}, "fix": "xyz"})
    for other in (several, mixed):
        assert other.null_space.shape == one.null_space.shape
        assert np.abs((one.equations @ other.null_space).toarray()).max(initial=0.0) < 1e-12
