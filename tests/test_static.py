"""Static analysis: equilibria do not depend on the way to them, reactions balance loads, and failures say why."""

import json
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import warp_origami as wo
from runs import GRAVITY, system_of
from warp_origami.cli import main
from warp_origami.errors import NumericalFailure
from warp_origami.output.memory import Memory
from warp_origami.solve import equilibrium, static
from warp_origami.solve.loop import loop
from warp_origami.solve.simulate import simulate
from warp_origami.terms.pressure import FollowerPressure
from warp_origami.terms.pressure_rim import PressureRim

LEFT, RIGHT = {"box": [[0.0, 0.0], [0.0, 0.6]]}, {"box": [[0.6, 0.0], [0.6, 0.6]]}
RIM = {"name": "rim", "at": {"boundary": True}}
HELD = {"name": "held", "at": LEFT}
TAUT = {"initial": {"stretch": [1.001, 1.001]}}


def pressure(value, **keys):
    return {"kind": "pressure", "value": value, **keys}


def film(steps, pattern=None, material=None, **tables):
    """A static scene of a square of polyimide film; `pattern` and `material` change single values."""
    return wo.Scene(
        name="film",
        analysis={"kind": "static", "load_steps": steps},
        pattern={"kind": "sheet", "width": 0.6, "height": 0.6, "nx": 4, "ny": 4, "diagonal": "alternate"}
        | (pattern or {}),
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4}
        | (material or {}),
        **{"output": {"fps": 1.0, "fields": []}, **tables},
    )


def airbag(steps, value, cells=8, s=1e-4):
    """A quarter of a square airbag, one side: z = 0 on its outer rim, which moves freely in the plane."""
    sides = {"x": [[0, 0], [0, 0.5]], "y": [[0, 0], [0.5, 0]], "z": [[0.5, 0], [0.5, 0.5]]}
    support = [{"name": f"on_{c}", "at": {"box": box}, "fix": c} for c, box in sides.items()]
    return film(
        steps,
        {"width": 0.5, "height": 0.5, "nx": cells, "ny": cells},
        {"youngs_modulus": 588e6, "poisson_ratio": 0.4, "thickness": 6e-4, "s1": s, "s2": s},
        support=[*support, {"name": "on_top", "at": {"box": [[0, 0.5], [0.5, 0.5]]}, "fix": "z"}],
        load=[pressure(value)],
    )


def twisted(steps, angle=1.0, nodes=4):
    """A flat sheet held on its left, the right edge turned about its middle and the x axis."""
    turn = {"axis": [1, 0, 0], "centre": [0.6, 0.3, 0], "angle": angle}
    driver = [{"name": "turned", "at": RIGHT, "rotate": turn}]
    return film(steps, {"nx": nodes, "ny": nodes}, support=[HELD], driver=driver)


class States(Memory):
    """Keeps the checkpoints, and stops the run after some of them if asked to."""

    def __init__(self, stop_after=None):
        super().__init__()
        self.checkpoints, self.stop_after = [], stop_after

    def checkpoint(self, arrays):
        self.checkpoints.append({name: value.copy() for name, value in arrays.items()})
        if len(self.checkpoints) == self.stop_after:
            raise KeyboardInterrupt  # as if killed there


def solve(scene, **options):
    """History, reactions, summary, and the states (k, n, 3) at the load factors (k,)."""
    states = States()
    summary = simulate(scene, states, device="cpu", **options)
    found = states.checkpoints
    factors, first = np.unique([float(a["factor"]) for a in found], return_index=True)
    return SimpleNamespace(
        history=states.history,
        reactions=states.reactions,
        summary=summary,
        factors=factors,
        q=np.array([found[k]["q"] for k in first]),
        checkpoints=found,
    )


def done(scene, **options):
    result = solve(scene, **options)
    assert result.summary["status"] == "done", result.summary.get("message")
    return result


# Equilibria do not depend on the way to them -------------------------------------------------------------------------


@pytest.mark.parametrize("value", [1.0, 1e3, 1e5])
def test_a_clamped_sheet_is_found_from_flat_in_any_number_of_load_steps(value):
    scenes = [film(steps, support=[RIM], load=[pressure(value)]) for steps in (1, 5, 20)]
    one, five, twenty = (done(scene) for scene in scenes)
    for other in (five, twenty):
        assert np.abs(other.q[-1] - one.q[-1]).max() < 1e-9
    per_step = [
        result.summary["newton_iterations"] / result.summary["steps_accepted"] for result in (one, five, twenty)
    ]
    print(f"{value:g} Pa: Newton iterations per load step {per_step}")
    assert max(per_step) < 12


@pytest.mark.parametrize(
    "scene", [film(5, support=[RIM], load=[pressure(1e3)]), twisted(5)], ids=["pressed", "twisted"]
)
def test_the_vanishing_regularization_leaves_no_trace(scene, monkeypatch):
    results = []
    for multiple in (1e-1, 1e-2, 1e-3):
        monkeypatch.setattr(static, "FIRST_MULTIPLE", multiple)
        results.append(done(scene).q[-1])
    assert max(np.abs(q - results[0]).max() for q in results) < 1e-8


@pytest.mark.parametrize("make", [twisted, lambda steps: film(steps, support=[RIM], load=[pressure(1e3)])])
def test_eliminated_and_multiplier_equilibria_agree(make):
    results = []
    for form in ("eliminate", "multipliers"):
        scene = make(3)
        integrator = scene.integrator.model_copy(update={"constraints": form})
        results.append(done(scene.model_copy(update={"integrator": integrator})))
    a, b = results
    assert (a.summary["constraint_form"], b.summary["constraint_form"]) == ("eliminate", "multipliers")
    assert np.abs(a.q[-1] - b.q[-1]).max() < 1e-9
    for name, values in a.reactions.items():
        assert np.abs(values[-1] - b.reactions[name][-1]).max() < 1e-6 * np.abs(values).max()


@pytest.mark.parametrize(
    ("value", "steps", "expected", "most"),
    [(1.0, 1, 0.2432, 300), (100.0, 1, 0.2465, 75), (5e3, 1, 0.2551, 35), (5e3, 5, 0.2551, 100)],
)
def test_an_airbag_is_found_under_small_and_large_pressure(value, steps, expected, most):
    """Under small pressure it is inextensible: its height tends to a limit, its strain to zero. Heights are those that
    runs in any number of load steps agree on, `most` is half as many iterations again as were measured."""
    result = done(airbag(steps, value))
    height = result.q[-1][:, 2].max()
    print(f"{value:g} Pa in {steps}: height {height:.5f} m, {result.summary['newton_iterations']} iterations")
    assert height == pytest.approx(expected, abs=1e-4)
    assert result.summary["newton_iterations"] <= most


def test_a_sheet_bent_in_its_plane_takes_few_iterations_once_its_wrinkles_are_known():
    """Uniaxial tension lies exactly on the switch of the law. Height H, force P, k' = 4: 2M / (P H) = 2/3."""
    height, length, k = 0.2, 0.4, 4.0
    force = 1e-5 * 2.5e9 * 5e-4 * height
    curvature = 2.0 * k * force / (2.5e9 * 5e-4 * height**2)
    turn = {"axis": [0, 0, -1], "centre": [length, height * (1 - k**-0.5), 0], "angle": length * curvature}
    scene = film(
        10,
        {"width": length, "height": height, "nx": 8, "ny": 4},
        {"s1": 1e-6, "s2": 1e-6},
        support=[
            {"at": {"all": True}, "fix": "z"},
            {"at": {"box": [[0, 0], [0, height]]}, "fix": "x"},
            {"at": {"near": [0, height]}, "fix": "y"},
        ],
        driver=[{"name": "end", "at": {"box": [[length, 0], [length, height]]}, "axes": "x", "rotate": turn}],
    )
    result = done(scene)
    fx, *_, mz = result.reactions["end"][-1]
    moment = 2.0 * abs(-mz - 0.5 * height * fx) / (fx * height)
    iterations = result.history["newton_iterations"].astype(int).tolist()
    print(f"2M / (P H) = {moment:.5f}, iterations {iterations}")
    assert moment == pytest.approx(2.0 / 3.0, rel=0.01)
    assert np.mean(iterations[3:]) < 15


@pytest.mark.parametrize("held", [[(0.0, 0.0)], [(0.0, 0.0), (0.6, 0.0)]], ids=["one corner", "two corners"])
def test_a_horizontal_sheet_falls_into_hanging(held):
    """From flat and horizontal to hanging. From one corner its centre comes to half the diagonal below it; all that
    hangs lies below what holds it."""
    support = [{"name": f"corner{k}", "at": {"near": list(point)}} for k, point in enumerate(held)]
    scene = film(1, support=support, load=[GRAVITY])
    result = done(scene)
    system = system_of(scene)
    z = result.q[-1][system.coordinates.positions, 2]
    weight = 1420.0 * 5e-4 * 0.36 * 9.81
    lifted = sum(values[-1][2] for values in result.reactions.values())
    print(f"lowest {z.min():.4f} m, {result.summary['newton_iterations']} iterations")
    assert lifted == pytest.approx(weight, rel=1e-6)
    assert z.max() < 1e-3
    assert z.min() < -0.55


@pytest.mark.parametrize("value", [1e-8, 1e-6, 1e-2, 1.0, 1e5])
def test_light_and_heavy_loads_are_carried_and_deflect_as_they_must(value):
    """A flat clamped sheet resists by stretching alone: deflection of p^(1/3) while it is small.

    Round-off of strains, 1e-16, is 1e-6 of the strain under 1e-8 Pa.
    """
    unit = 1e-4
    one, other = (done(film(1, support=[RIM], load=[pressure(p, follower=False)])) for p in (unit, value))
    carried = -other.reactions["rim"][-1][2] / (value * 0.36)
    growth = other.q[-1][:, 2].max() / one.q[-1][:, 2].max() / (value / unit) ** (1 / 3)
    print(f"{value:g} Pa: carried {carried - 1:.1e}, deflection {growth - 1:.1e}")
    assert carried == pytest.approx(1.0, abs=1e-6)
    if value <= 1.0:
        assert growth == pytest.approx(1.0, abs=3e-5)


@pytest.mark.parametrize("strain", [1e-10, 1e-8, 1e-6])
def test_a_light_pull_stretches_by_the_strain_of_the_load(strain):
    force = strain * 2.5e9 * 5e-4 * 0.6
    support = [
        {"at": {"all": True}, "fix": "z"},
        {"name": "left", "at": LEFT, "fix": "x"},
        {"at": {"near": [0.0, 0.0]}, "fix": "y"},
    ]
    scene = film(1, support=support, load=[{"kind": "force", "at": RIGHT, "value": [force, 0.0, 0.0]}])
    result = done(scene)
    right = system_of(scene).coordinates.positions[system_of(scene).mesh.vertices[:, 0] > 0.59]
    moved = (result.q[-1] - result.q[0])[right, 0]
    print(f"carried {-result.reactions['left'][-1][0] / force - 1:.1e}, moved {moved.mean() / (0.6 * strain) - 1:.1e}")
    assert -result.reactions["left"][-1][0] == pytest.approx(force, rel=1e-6)
    assert moved.mean() == pytest.approx(0.6 * strain, rel=2e-6)  # positions are known to 1e-16 m


def test_loads_below_round_off_are_remarked():
    assert "below the round-off" in done(film(1, support=[RIM], load=[pressure(1e-11)])).summary["message"]


@pytest.mark.parametrize("form", ["eliminate", "multipliers"])
def test_a_sheet_that_stands_on_its_edge_is_unstable_and_one_that_hangs_is_not(form):
    load = [{"kind": "gravity", "acceleration": [0.0, -9.81, 0.0]}]
    for y, unstable in ((0.0, True), (0.6, False)):
        support = [{"at": {"box": [[0.0, y], [0.6, y]]}}]
        scene = film(1, material={"model": "linear"}, support=support, load=load, integrator={"constraints": form})
        assert ("the equilibrium is unstable" in done(scene).summary.get("message", "")) == unstable


# Forces and moments --------------------------------------------------------------------------------------------------


BALANCED = {
    "follower pressure, free rim": film(
        2, support=[HELD, {"name": "right", "at": RIGHT}], load=[pressure(1e3), pressure(50.0, follower=False)]
    ),
    "edge force": film(2, support=[HELD], load=[{"kind": "force", "at": RIGHT, "value": [30.0, 5.0, 10.0]}]),
    "gravity and driver": film(
        2, TAUT, support=[HELD], load=[GRAVITY], driver=[{"name": "d", "at": RIGHT, "translate": [0.01, 0.0, 0.02]}]
    ),
    "twist": twisted(2),
}


@pytest.mark.parametrize("name", list(BALANCED))
def test_reactions_balance_the_loads(name):
    scene = BALANCED[name]
    result, system = done(scene), system_of(scene)
    q = result.q[-1]
    loads = system.external_force(q, system.external.at(1.0))
    positions = system.coordinates.positions
    total = np.concatenate([loads[positions].sum(axis=0), np.cross(q, loads).sum(axis=0)])
    exerted = np.array([values[-1] for values in result.reactions.values()])
    left = np.abs(total + exerted.sum(axis=0)).max()
    print(f"{name}: {left:.1e} of {np.abs(exerted).max():.3g} N, N m")
    assert np.abs(exerted).max() > 0.1
    assert left < 2e-6 * np.abs(exerted).max()


def test_the_moment_of_a_turned_edge_is_the_derivative_of_the_energy():
    step = 1e-3
    base = [done(twisted(1, angle)) for angle in (1.0 - step, 1.0, 1.0 + step)]
    energies = [result.history["strain_energy"][-1] for result in base]
    slope = (energies[2] - energies[0]) / (2.0 * step)
    values = base[1].reactions["turned"][-1]
    centre = np.array([0.6, 0.3, 0.0])
    moment = (values[3:] - np.cross(centre, values[:3]))[0]
    print(f"moment {moment:.6f} N m, dU/dangle {slope:.6f}")
    assert moment == pytest.approx(slope, rel=1e-5)


def test_a_sheet_moved_as_a_whole_has_no_energy_and_no_reactions():
    turn = {"axis": [1, 2, 3], "centre": [0.1, 0.0, 0.2], "angle": 2.0}
    driver = [{"name": "all", "at": {"all": True}, "translate": [0.1, 0.2, 0.3], "rotate": turn}]
    result = done(film(3, driver=driver))
    assert result.history["strain_energy"].max() < 1e-20
    # of the energy of a strain of 1e-7
    assert max(result.summary["energy_gain"], result.summary["energy_loss"]) < 1e-2
    assert np.abs(result.reactions["all"]).max() < 1e-6  # round-off of E h strain on 0.15 m


def test_loads_in_balance_need_no_supports():
    pull = [{"kind": "force", "at": side, "value": [f, 0, 0]} for side, f in ((LEFT, -10.0), (RIGHT, 10.0))]
    probes = [{"name": name, "at": [x, 0.3]} for name, x in (("a", 0.0), ("b", 0.6))]
    result = wo.simulate(film(1, load=pull, probe=probes), device="cpu")
    stretch = np.linalg.norm(result.probes["b"][-1, :3] - result.probes["a"][-1, :3]) / 0.6
    # uniform uniaxial second Piola-Kirchhoff stress S with lambda S h H = F
    stress = 2.5e9 * 0.5 * (stretch**2 - 1.0)
    assert stretch * stress * 5e-4 * 0.6 == pytest.approx(10.0, rel=1e-9)


# Newton --------------------------------------------------------------------------------------------------------------


def newton_steps(scene, monkeypatch):
    """Sizes (m) of all but the last Newton step of the only load step, without regularization."""
    sizes, search = [], equilibrium.line_search

    def recording(potential, q, step, slope):
        sizes.append(np.linalg.norm(step.reshape(-1, 3), axis=1).max())
        return search(potential, q, step, slope)

    with monkeypatch.context() as patch:
        patch.setattr(equilibrium, "line_search", recording)
        patch.setattr(static, "FIRST_MULTIPLE", 0.0)
        done(scene)
    return np.array(sizes)


def test_newton_is_quadratic_with_follower_pressure_on_a_free_rim(monkeypatch):
    """The tangent is not symmetric there; without its skew part the steps shrink linearly."""
    held = [HELD, {"name": "right", "at": RIGHT}]
    scene = film(1, TAUT, {"model": "linear"}, support=held, load=[pressure(2e4)])
    exact = newton_steps(scene, monkeypatch)
    monkeypatch.setattr(FollowerPressure, "skew", lambda self, q: 0.0 * PressureRim.skew(self._rim, q))
    symmetric = newton_steps(scene, monkeypatch)
    print("Newton steps, m:", *([f"{size:.1e}" for size in sizes] for sizes in (exact, symmetric)))
    assert exact[-1] < 10.0 * exact[-2] ** 2
    assert symmetric[-1] > 0.03 * symmetric[-2]
    assert len(symmetric) > len(exact)


# Profiles ------------------------------------------------------------------------------------------------------------


def test_loads_follow_their_profiles():
    """Constant from load factor 0, dead and follower alike; a table that loads twice as far and half unloads."""
    wanted = done(film(1, support=[RIM], load=[pressure(1e3)])).q[-1]
    constant = {"kind": "constant"}
    table = {"kind": "table", "table": [[0.0, 0.0], [0.5, 2.0], [1.0, 1.0]]}
    for profile in (constant, table):
        found = done(film(6, support=[RIM], load=[pressure(1e3, profile=profile)])).q[-1]
        assert np.abs(found - wanted).max() < 1e-9


def test_a_follower_pressure_acts_on_the_present_area_and_a_dead_one_on_the_flat():
    dead, follower = (
        done(film(1, TAUT, support=[RIM], load=[pressure(1.0, follower=kind)])).q[-1][:, 2].max()
        for kind in (False, True)
    )
    assert follower / dead == pytest.approx(1.001**2, rel=1e-5)


def test_unloading_comes_back():
    table = {"kind": "table", "table": [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]]}
    result = done(film(10, TAUT, support=[RIM], load=[pressure(1e3, profile=table)]))
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-9
    assert np.abs(result.q[5] - result.q[0]).max() > 1e-3
    going, coming = result.q[2], result.q[8]
    assert np.abs(going - coming).max() < 1e-9
    assert abs(result.history["energy_error"][-1]) < 1e-9


def test_the_error_of_the_work_falls_with_the_square_of_the_load_steps():
    """Work is summed by the trapezoidal rule over the load steps; a taut sheet has no singular first one."""
    errors = []
    for steps in (10, 20, 40):
        history = done(film(steps, TAUT, support=[RIM], load=[pressure(5e3)])).history
        gained = history["strain_energy"][-1] - history["strain_energy"][0]
        errors.append(abs(history["energy_error"][-1]) / gained)
    print(f"energy error over the energy gained: {errors}")
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > 1.8
    assert errors[-1] < 2e-3


# Contact -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [10.0, 1e3])
def test_a_pressed_stack_has_the_gap_of_pressure_over_stiffness(value):
    """Two sheets of meshes that do not match, pressed together from both sides: gap p / eps, mean over the sheet.

    Contact is summed at points, and a sheet without bending follows what that misses: single points are 5 % off.
    """
    eps, thickness = 1e8, 5e-4
    lower, upper = {"box": [[0.0, 0.0], [0.3, 0.3]]}, {"box": [[0.4, 0.0], [0.7, 0.3]]}
    base = wo.load_scene("two_sheets").model_dump(exclude_none=True)
    corners = [[0.0, 0.0], [0.3, 0.0], [0.0, 0.3]]
    scene = wo.Scene(
        **base
        | {
            "analysis": {"kind": "static", "load_steps": 5},
            "support": [{"name": "plane", "at": {"all": True}, "fix": "xy"}]
            + [{"at": {"near": point}, "fix": "z"} for point in corners],
            "load": [pressure(-value, at=upper), pressure(value, at=lower)],
            "probe": [],
            "output": {"fps": 1.0, "fields": []},
        }
    )
    system, result = system_of(scene), done(scene)
    z = result.q[-1][:, 2]
    above = system.mesh.vertices[:, 0] > 0.35
    heights = []
    for side in (above, ~above):
        elements = np.flatnonzero(side[system.mesh.triangles].all(axis=1))
        rows = system.coordinates.elements[elements]
        weights = np.zeros(len(z))
        for load in system.external.pressures:
            force = load.term.force(system.q0)[:, 2]
            if np.isin(np.flatnonzero(force), rows).all():
                weights = force
        heights.append(weights @ z / 0.09)
    gap = thickness - (heights[0] - heights[1])
    deepest = result.history["max_penetration"][-1]
    print(f"gap over p / eps: mean {gap * eps / value:.6f}, largest {deepest * eps / value:.4f}")
    assert gap == pytest.approx(value / eps, rel=2e-3)
    assert deepest == pytest.approx(value / eps, rel=0.06)


LOWER, UPPER = {"box": [[0.0, 0.0], [0.3, 0.3]]}, {"box": [[0.4, 0.0], [0.7, 0.3]]}


def press(depth, steps):
    """A sheet of 0.5 mm is driven down on a held one, from just above."""
    down = {"name": "down", "at": UPPER, "translate": [0.0, 0.0, -depth], "profile": {"kind": "linear"}}
    base = wo.load_scene("two_sheets").model_dump(exclude_none=True)
    analysis = {"kind": "static", "load_steps": steps}
    tables = {"support": [{"name": "lower", "at": LOWER}], "driver": [down], "load": [], "probe": []}
    return wo.Scene(**base | tables | {"analysis": analysis, "output": {"fps": 1.0, "fields": []}})


@pytest.mark.parametrize(("depth", "steps"), [(0.02, 1), (0.02, 4), (0.002, 4)])
def test_a_sheet_is_never_driven_through_another(depth, steps):
    result = solve(press(depth, steps))
    assert result.summary["status"] == "failed"
    assert "layers would pass through each other" in result.summary["message"]
    assert "stiffness" in result.summary["advice"]
    assert result.summary["steps_rejected"] > 4
    assert 0.0 < result.history["max_penetration"][-1] <= 5e-4
    assert np.all(np.diff(result.history["contact_energy"]) >= 0.0)


def test_a_gentle_press_is_resisted_and_resumes_with_the_same_bits():
    scene = press(5e-4, 4)
    whole, killed = done(scene), States(stop_after=3)
    assert whole.summary["steps_rejected"] == 0
    assert np.all(np.diff(whole.history["contact_energy"]) > 0.0)
    force, counter = whole.reactions["down"][:, 2], whole.reactions["lower"][:, 2]
    assert np.all(np.diff(force) < 0.0)
    assert counter == pytest.approx(-force, abs=1e-8 * np.abs(force).max())
    with pytest.raises(KeyboardInterrupt):
        simulate(scene, killed, device="cpu")
    assert done(scene, resume=killed.checkpoints[-1]).q[-1].tobytes() == whole.q[-1].tobytes()


# Failures, interrupts, going on --------------------------------------------------------------------------------------


def limited(maximum, monkeypatch):
    """Newton gives up after `maximum` iterations."""
    iterate = equilibrium.EquilibriumSolver._iterate

    def short(self, start, external, multiple, patient):
        return iterate(self, start, external, multiple, True, maximum)

    monkeypatch.setattr(equilibrium.EquilibriumSolver, "_iterate", short)


def test_load_steps_without_equilibrium_are_halved_and_grow_again(monkeypatch):
    scene = twisted(1).model_copy(update={"material": film(1, material={"model": "linear"}).material})
    wanted = done(scene)
    limited(wanted.summary["newton_iterations"] - 2, monkeypatch)
    found = done(scene)
    steps = found.history["step"][1:]
    print(f"load steps {steps}, {found.summary['steps_rejected']} rejected")
    assert found.summary["steps_rejected"] > 0
    assert found.summary["steps_accepted"] == len(steps) > 1
    assert np.all(np.isin(steps, 0.5 ** np.arange(8)))
    assert np.abs(found.q[-1] - wanted.q[-1]).max() < 1e-9


def test_load_steps_end_where_the_smallest_does_not_converge(monkeypatch):
    scene = twisted(2).model_copy(update={"material": film(1, material={"model": "linear"}).material})
    limited(1, monkeypatch)
    summary = solve(scene).summary
    assert summary["message"] == "stopped at load factor 0: Newton did not converge in 1 iterations"
    assert (summary["steps_accepted"], summary["steps_rejected"]) == (0, 7)  # 0.5 to 0.5 / 64, below 1 % of 0.5 then


def test_prescribed_motion_survives_rungs_without_a_factor(monkeypatch):
    """Newton alone and the first rung of the ladder cannot even begin; the next one still moves the driven edge."""
    wanted, factorize, calls = done(twisted(1)), equilibrium.EquilibriumSolver._factorize, []

    def failing(self, linearization, multiple):
        calls.append(multiple)
        return (None, multiple) if len(calls) <= 2 else factorize(self, linearization, multiple)

    monkeypatch.setattr(equilibrium.EquilibriumSolver, "_factorize", failing)
    found = done(twisted(1))
    assert np.abs(found.q[-1] - wanted.q[-1]).max() < 1e-8


NOT_HELD = film(4, load=[{"kind": "force", "at": RIGHT, "value": [10.0, 0.0, 0.0]}])


def test_a_load_that_nothing_holds_fails_at_once_and_names_supports():
    with pytest.raises(
        NumericalFailure, match=r"load factor 0: loads push the sheet along x .* a support that fixes x"
    ):
        wo.simulate(NOT_HELD, device="cpu")
    result = solve(film(1, load=[GRAVITY], support=[{"at": {"near": [0, 0]}, "fix": "xy"}]))
    assert "along z" in result.summary["message"]
    assert result.summary["newton_iterations"] == 0


def test_a_failure_keeps_the_load_steps_before_it(tmp_path, monkeypatch):
    """Driven to what has no equilibrium here: exit code 3, tables up to the load factor that the message names."""
    monkeypatch.chdir(tmp_path)
    late = {"kind": "table", "table": [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]}
    push = [{"kind": "force", "at": RIGHT, "value": [10.0, 0.0, 0.0], "profile": late}]
    scene = film(4, load=[*push, {"kind": "force", "at": {"near": [0.6, 0.0]}, "value": [0.0, 0.0, 0.0]}])
    (tmp_path / "late.toml").write_text(scene.to_toml())
    ended = CliRunner().invoke(main, ["run", "late.toml", "--quiet", "--out", "out"])
    print(ended.stderr)
    assert ended.exit_code == 3
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["status"] == "failed"
    assert summary["message"].startswith("stopped at load factor 0.5:")
    assert "support" in summary["advice"]
    rows = (tmp_path / "out" / "history.csv").read_text().splitlines()
    assert len(rows) == 1 + 3  # heading, load factors 0, 0.25, 0.5


@pytest.mark.parametrize("scene", [twisted(6), airbag(4, 5e3, cells=4)], ids=["twisted", "airbag"])
def test_a_resumed_run_has_the_same_bits(scene):
    whole = done(scene)
    for after in (1, 3):
        killed = States(stop_after=after)
        with pytest.raises(KeyboardInterrupt):
            simulate(scene, killed, device="cpu")
        rest = done(scene, resume=killed.checkpoints[-1])
        assert rest.q[-1].tobytes() == whole.q[-1].tobytes()
        assert rest.summary["newton_iterations"] == whole.summary["newton_iterations"]
        ours, theirs = (r.history["energy_error"][-1] for r in (rest, whole))
        assert ours == theirs


def test_an_interrupted_run_stops_between_load_steps_and_goes_on():
    scene = twisted(6)
    system, states, stop = system_of(scene), States(), threading.Event()
    run = static.StaticRun(system, states, 1.0)
    state = run.start()
    stop.set()
    assert loop(run, state, stop)["status"] == "interrupted"
    rest = done(scene, resume=states.checkpoints[-1])
    assert rest.q[-1].tobytes() == done(scene).q[-1].tobytes()


def test_a_run_ends_where_it_is_asked_to():
    result = solve(twisted(4), until=0.6)
    np.testing.assert_allclose(result.history["time"], [0.0, 0.25, 0.5, 0.6], atol=1e-12)
