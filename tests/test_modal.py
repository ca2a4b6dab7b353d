"""Modes: exact frequencies, complete with multiplicities, from either solver, about any equilibrium."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from scipy.linalg import eigh
from scipy.special import jn_zeros
from threadpoolctl import threadpool_limits

import warp_origami as wo
from exact_membranes import drum
from runs import film, system_of
from warp_origami.output.run_directory import RunDirectory
from warp_origami.solve import modal
from warp_origami.solve.modal import Modes

SIDE, STRESS, DENSITY, MODULUS, NU = 0.6, 1e6, 1420.0, 2.5e9, 0.34
STRETCH = float(np.sqrt(1 + 2 * STRESS * (1 - NU) / MODULUS))
TAUT = {"initial": {"stretch": [STRETCH, STRETCH]}}
RIM = {"support": [{"name": "rim", "at": {"boundary": True}}]}
LEFT, RIGHT = {"box": [[0.0, 0.0], [0.0, SIDE]]}, {"box": [[SIDE, 0.0], [SIDE, SIDE]]}


@pytest.fixture(autouse=True)
def one_thread():
    """As in a run: threads that wait for each other cost more than they save."""
    with threadpool_limits(1):
        yield


class LastState:
    """Keeps q of the last checkpoint (an Observer)."""

    def ignore(self, *_):
        pass

    start = phase = step = frame = save = finish = ignore

    def checkpoint(self, arrays):
        self.q = arrays["q"]


def sheet(count=6, pattern=None, material=None, n=8, **tables):
    tables = {"analysis": {"kind": "modal", "count": count, "load_steps": 1}} | tables
    scene = film(1.0, {"nx": n, "ny": n} | (pattern or {}), material)
    fields = {name: getattr(scene, name) for name in ("name", "pattern", "material", "output")}
    return wo.Scene(**fields, **tables)


def frequencies(scene):
    return np.array(wo.simulate(scene, device="cpu").summary["frequencies"])


def about_equilibrium(scene):
    """The system, the equilibrium q and the modes about it."""
    last = LastState()
    wo.simulate(scene, device="cpu", observers=[last])
    system = system_of(scene)
    return system, last.q, Modes(system).find(last.q, system.external.at(1.0))


def exact_drum(count, a=SIDE, b=None):
    return np.array([mode.frequency for mode in drum(a, STRESS, DENSITY, count, b)])


# Exact frequencies ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dense", [0, 10000])
@pytest.mark.parametrize("diagonal", ["right", "alternate"])
def test_drum_is_of_order_four(monkeypatch, dense, diagonal):
    monkeypatch.setattr(modal, "DENSE", dense)
    errors = [frequencies(sheet(6, TAUT | {"diagonal": diagonal}, n=n, **RIM)) / exact_drum(6) - 1 for n in (6, 12)]
    orders = np.log2(np.array(errors[0]) / errors[1])
    assert np.all((orders > 3.75) & (orders < 4.25))
    assert errors[1][0] < 3e-6
    assert np.max(errors[1]) < 1e-4


def test_rectangle():
    scene = sheet(8, TAUT | {"width": 0.9, "height": 0.5, "nx": 14, "ny": 8}, **RIM)
    assert frequencies(scene) == pytest.approx(exact_drum(8, 0.9, 0.5), rel=1e-3)


def test_disc_is_of_order_two_in_the_polygonal_rim():
    zeros = np.array([jn_zeros(0, 1)[0], *2 * [jn_zeros(1, 1)[0]], *2 * [jn_zeros(2, 1)[0]], jn_zeros(0, 2)[1]])
    exact = np.sqrt(STRESS / DENSITY) / (2 * np.pi * 0.3) * zeros
    errors = []
    for rings in (4, 8):
        pattern = {"kind": "disc", "radius": 0.3, "rings": rings} | TAUT
        scene = wo.Scene(
            name="disc",
            analysis={"kind": "modal", "count": 6},
            pattern=pattern,
            material={"density": DENSITY, "youngs_modulus": MODULUS, "poisson_ratio": NU, "thickness": 5e-4},
            output={"fields": []},
            **RIM,
        )
        errors.append(frequencies(scene) / exact - 1)
    assert np.all(np.log2(errors[0] / errors[1]) > 1.7)
    assert np.max(np.abs(errors[1])) < 5e-3


@pytest.mark.parametrize("model", ["linear", "srm"])
def test_longitudinal_vibrations_of_a_taut_sheet_on_rollers(model):
    """Everything moves along x alone: f = sqrt((stretch^2 E / (1 - nu^2) + S) / rho) / (2 a)."""
    support = [{"at": {"all": True}, "fix": "yz"}, {"at": LEFT}, {"at": RIGHT}]
    found = frequencies(sheet(1, TAUT, {"model": model}, n=6, support=support))
    speed = np.sqrt((STRETCH**2 * MODULUS / (1 - NU**2) + STRESS) / DENSITY)
    assert found[0] == pytest.approx(speed / (2 * SIDE), rel=2e-4)


def test_hanging_sheet_swings_like_a_chain():
    """f = j_0k / (4 pi) sqrt(g / L), Bernoulli; the weight stretches the sheet by 1e-6."""
    support = [{"at": {"box": [[0.0, SIDE], [SIDE, SIDE]]}}]
    load = [{"kind": "gravity", "acceleration": [0.0, -9.81, 0.0]}]
    found = frequencies(sheet(1, {"nx": 2, "ny": 12}, support=support, load=load))
    assert found[0] == pytest.approx(jn_zeros(0, 1)[0] / (4 * np.pi) * np.sqrt(9.81 / SIDE), rel=1e-3)


# Completeness --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("diagonal", ["right", "alternate"])
def test_both_solvers_find_the_same_with_every_copy_for_any_count(monkeypatch, diagonal):
    """The mesh with alternating diagonals has the symmetry of the square: f12 = f21, f13 = f31 to round-off."""
    system = system_of(sheet(24, TAUT | {"diagonal": diagonal}, **RIM))
    modes, external = Modes(system), system.external.at(1.0)
    monkeypatch.setattr(modal, "DENSE", 10000)
    every = modes.find(system.q0, external).frequencies
    monkeypatch.setattr(modal, "DENSE", 0)
    for count in (*range(1, 12), 17, 24):
        modes.count = count
        assert modes.find(system.q0, external).frequencies == pytest.approx(every[:count], rel=1e-9)
    if diagonal == "alternate":
        assert every[1] == pytest.approx(every[2], rel=1e-9)
        assert every[4] == pytest.approx(every[5], rel=1e-9)


@pytest.mark.parametrize("dense", [0, 10000])
def test_flat_sheet_without_stress_has_no_stiffness_across(monkeypatch, dense):
    """As many zero frequencies as unknowns across the plane, more than any block is wide; exactly zero, not noise."""
    monkeypatch.setattr(modal, "DENSE", dense)
    scene = sheet(100, {}, {"model": "linear"}, n=8, **RIM)
    across = system_of(scene).constraints.null_space.shape[1] // 3
    found = frequencies(scene)
    assert across > 100
    assert np.array_equal(found, np.zeros(100))
    if dense:
        found = frequencies(sheet(across + 1, {}, {"model": "linear"}, n=8, **RIM))
        assert np.all(found[:across] == 0.0)
        assert found[across] > 1000.0


@pytest.mark.parametrize("dense", [0, 10000])
def test_free_sheet_keeps_its_rigid_motions(monkeypatch, dense):
    """A free sheet without stress: zero across its plane, and three rigid motions in it."""
    monkeypatch.setattr(modal, "DENSE", dense)
    scene = sheet(1, {}, {"model": "linear"}, n=4, support=[{"at": {"all": True}, "fix": "z"}])
    modes = about_equilibrium(sheet(5, {}, {"model": "linear"}, n=4, support=[{"at": {"all": True}, "fix": "z"}]))[2]
    assert np.array_equal(modes.frequencies[:3], np.zeros(3))
    assert modes.frequencies[3] > 100.0
    assert frequencies(scene) == [0.0]


def test_count_beyond_the_unknowns_gives_them_all():
    scene = sheet(10000, TAUT, n=3, **RIM)
    unknowns = system_of(scene).constraints.null_space.shape[1]
    found = frequencies(scene)
    assert len(found) == unknowns
    assert np.all(np.diff(found) >= 0.0)
    assert frequencies(sheet(4, TAUT, n=2, support=[{"at": {"all": True}}])).size == 0


# Equilibria ----------------------------------------------------------------------------------------------------------


GRAVITY = {"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}
PRESSURE = {"kind": "pressure", "value": 1000.0}
EQUILIBRIA = {
    "gravity": {"load": [GRAVITY], **RIM},
    "pressure": {"load": [PRESSURE], **RIM},
    "multipliers": {"load": [PRESSURE], "integrator": {"constraints": "multipliers"}, **RIM},
    "free edges under pressure": {
        "load": [PRESSURE | {"value": 100.0}],
        "support": [{"at": LEFT}, {"at": RIGHT}],
    },
    "creased": {"load": [PRESSURE], "pattern": {"creases_x": [2]}, **RIM},
}


@pytest.mark.parametrize("name", EQUILIBRIA)
@pytest.mark.parametrize("dense", [0, 10000])
def test_modes_are_those_of_the_linearized_equations_of_motion(monkeypatch, name, dense):
    """Against the symmetric part of differences of all forces at the equilibrium, reduced by the constraints."""
    monkeypatch.setattr(modal, "DENSE", dense)
    tables = dict(EQUILIBRIA[name])
    scene = sheet(6, tables.pop("pattern", {}), {"model": "linear"}, n=4, **tables)
    system, q, modes = about_equilibrium(scene)
    null, external, step = system.constraints.null_space, system.external.at(1.0), 1e-6

    def balance(y):
        state = (q.ravel() + null @ y).reshape(-1, 3)
        return null.T @ (system.evaluate(state).gradient - system.external_force(state, external)).ravel()

    unit = step * np.eye(null.shape[1])
    stiffness = np.array([(balance(y) - balance(-y)) / (2 * step) for y in unit])
    mass = (null.T @ system.full_mass @ null).toarray()
    expected = np.sqrt(eigh(0.5 * (stiffness + stiffness.T), mass, eigvals_only=True)[:6]) / (2 * np.pi)
    assert modes.frequencies == pytest.approx(expected, rel=1e-6)
    assert modes.remark is None


@pytest.mark.parametrize(("pressure", "matters"), [(1.0, False), (2e4, True)])
def test_the_skew_part_of_pressure_on_free_edges_is_told_where_it_matters(pressure, matters):
    load, held = [PRESSURE | {"value": pressure}], {"support": [{"at": LEFT}, {"at": RIGHT}]}
    _, _, modes = about_equilibrium(sheet(12, {}, {"model": "linear"}, n=4, load=load, **held))
    assert ("skew" in (modes.remark or "")) == matters


@pytest.mark.parametrize("dense", [0, 10000])
def test_shapes_are_orthonormal_in_mass_and_solve_the_equations(monkeypatch, dense):
    monkeypatch.setattr(modal, "DENSE", dense)
    system, q, modes = about_equilibrium(sheet(7, {}, load=[PRESSURE], **RIM))
    shapes = modes.shapes.reshape(7, -1)
    assert shapes @ (system.full_mass @ shapes.T) == pytest.approx(np.eye(7), abs=1e-10)
    squares = (2 * np.pi * modes.frequencies) ** 2
    found = Modes(system)
    stiffness = found.tangent.symmetric(system.linearize(q, system.external.at(1.0)), 0.0, 0.0).full()
    y = system.constraints.left_inverse @ shapes.T
    inertia = (found.mass @ y) * squares
    assert np.linalg.norm(stiffness @ y - inertia, axis=0) == pytest.approx(0.0, abs=1e-5 * np.linalg.norm(inertia))
    assert np.abs(system.constraints.equations @ shapes.T).max() < 1e-12 * np.abs(shapes).max()


def test_components_that_drivers_prescribe_are_held():
    """The flat sheet, stretched by a driver of its rim, is the drum."""
    drive = [{"at": {"boundary": True}, "translate_to": "deployed", "overstretch": STRETCH - 1}]
    stretched = frequencies(sheet(6, {}, driver=drive))
    assert stretched == pytest.approx(frequencies(sheet(6, TAUT, **RIM)), rel=1e-8)


def test_compressed_sheet_is_unstable():
    """S = -1 MPa: statics stay in the plane and -f_mn are found; the finest waves grow fastest."""
    shrunk = float(np.sqrt(1 - 2 * STRESS * (1 - NU) / MODULUS))
    scene = sheet(10000, {"initial": {"stretch": [shrunk, shrunk]}}, {"model": "linear"}, n=6, **RIM)
    result = wo.simulate(scene, device="cpu").summary["frequencies"]
    unstable = np.sort(-np.array([f for f in result if f < 0.0]))
    assert len(unstable) == system_of(scene).constraints.null_space.shape[1] // 3
    assert unstable[:4] == pytest.approx(exact_drum(4), rel=1e-3)


def test_contact_is_part_of_the_stiffness():
    """Two sheets in touch, rigid against each other: omega^2 = 2 eps / m, m per area, as Rayleigh's quotient."""
    scene = wo.load_scene("two_sheets")
    areal = scene.material.density * scene.material.thickness
    stiffness, thickness = 1e8, scene.contact.thickness
    scene = wo.Scene(
        name="resting",
        analysis={"kind": "modal", "count": 1, "load_steps": 1},
        pattern=scene.pattern,
        material=scene.material.model_copy(update={"model": "linear"}),
        contact={"method": "sts", "sts_stiffness": stiffness, "thickness": thickness},
        support=[{"at": {"all": True}, "fix": "xy"}],
        output={"fields": []},
    )
    system = system_of(scene)
    z = system.q0[system.coordinates.positions, 2]
    assert len(np.unique(z)) == 2
    gap = z.max() - z.min()
    system.q0[system.coordinates.positions[z == z.max()], 2] -= gap - 0.9 * thickness
    system.accept(system.q0)
    modes = Modes(system)
    linearization = system.linearize(system.q0, system.external.at(1.0))
    tangent = modes.tangent.symmetric(linearization, 0.0, 0.0).full()
    rigid = np.zeros_like(system.q0)
    rigid[system.coordinates.positions, 2] = np.where(z == z.max(), 0.5, -0.5)
    y = system.constraints.left_inverse @ rigid.ravel()
    assert y @ (tangent @ y) / (y @ (modes.mass @ y)) == pytest.approx(2 * stiffness / areal, rel=1e-2)


def test_modes_about_sheets_in_contact():
    """A taut sheet pressed on a held one rides on the contact: omega^2 = eps / m, m per area, is its lowest mode."""
    pressed = wo.load_scene("scenes/verification/pressed_stack.toml")
    tables = pressed.model_dump(exclude_none=True, exclude={"verification"})
    result = wo.simulate(wo.Scene(**tables | {"analysis": {"kind": "modal", "count": 2}}), device="cpu")
    areal = pressed.material.density * pressed.material.thickness
    first, second = result.summary["frequencies"]
    assert result.history["contacts_sts"][-1] > 0
    assert "message" not in result.summary
    assert first == pytest.approx(np.sqrt(pressed.contact.sts_stiffness / areal) / (2 * np.pi), rel=1e-2)
    assert second > 2.0 * first


# Results -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dense", [0, 10000])
def test_two_runs_are_equal_to_the_last_bit(monkeypatch, dense):
    monkeypatch.setattr(modal, "DENSE", dense)
    first, second = (about_equilibrium(sheet(5, {}, load=[GRAVITY], **RIM))[2] for _ in range(2))
    assert np.array_equal(first.frequencies, second.frequencies)
    assert np.array_equal(first.shapes, second.shapes)


def test_animation_takes_each_mode_through_one_period(tmp_path):
    scene = sheet(3, TAUT, n=6, **RIM)
    wo.simulate(scene, device="cpu", observers=[RunDirectory(tmp_path)])
    system, q, modes = about_equilibrium(scene)
    stage = Usd.Stage.Open(str(tmp_path / "animation.usdc"))
    rate = stage.GetTimeCodesPerSecond()
    nodes = UsdGeom.Points(stage.GetPrimAtPath("/World/nodes")).GetPointsAttr()
    assert stage.GetEndTimeCode() == 3 * rate

    def at(time):
        return np.asarray(nodes.Get(time * rate), dtype=float)

    still = q[system.coordinates.positions]
    for k, shape in enumerate(modes.shapes[:, system.coordinates.positions]):
        for time in (k, k + 0.5, k + 1):
            assert at(time) == pytest.approx(still, abs=1e-7)
        up, down = at(k + 0.25) - still, at(k + 0.75) - still
        assert up == pytest.approx(-down, abs=1e-6)
        assert np.abs(up).max() == pytest.approx(modal.AMPLITUDE * system.mesh.size, rel=0.1)
        cosine = np.sum(up * shape) / np.linalg.norm(up) / np.linalg.norm(shape)
        assert abs(cosine) == pytest.approx(1.0, abs=1e-6)


def test_a_run_that_ends_before_all_loads_act_says_that_it_has_no_modes():
    summary = wo.simulate(sheet(2, TAUT, n=2, **RIM), device="cpu", until=0.5).summary
    assert summary["message"] == "no modes before load factor 1"
    assert "frequencies" not in summary
