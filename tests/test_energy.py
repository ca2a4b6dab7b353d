"""The energy balance: its definition, work of drivers and gravity, dissipation of both kinds of damping."""

import numpy as np
import pytest

from runs import GRAVITY, film, run
from warp_origami.solve.energy import EnergyBalance, Forces

MASS = 1420.0 * 5e-4 * 0.36
TAUT = {"initial": {"stretch": [1.0004, 1.0004]}}
RIM = {"at": {"boundary": True}}


def no_forces(**changes):
    zero = {"external": np.zeros(3), "damping": np.zeros(3), "prescribed": np.zeros(1), "values": np.zeros(1)}
    return Forces(**{name: np.asarray(changes.get(name, value), dtype=float) for name, value in zero.items()})


def test_error_is_what_is_stored_and_dissipated_less_work_and_start():
    balance = EnergyBalance.start(1.0, 2.0, 4.0)
    assert (balance.error, balance.gain, balance.loss) == (0.0, 0.0, 0.0)
    moved = np.array([1.0, 0.0, 2.0])
    before = no_forces(external=[2, 0, 0], damping=[0, 0, 1], prescribed=[3], values=[0])
    after = no_forces(external=[4, 0, 0], damping=[0, 0, 2], prescribed=[5], values=[0.5])
    balance = balance.advance(2.0, 3.0, 4.0, moved, before, after)
    assert balance.external_work == 3.0 + 2.0
    assert balance.dissipated == 3.0
    assert balance.error == 9.0 + 3.0 - 5.0 - 7.0


def extremes(error, stored):
    """energy_gain and energy_loss of a whole history, from their definition."""
    largest = stored.max()
    if largest == 0.0:
        return 0.0, 0.0
    gain = max((error[k] - error[: k + 1].min() for k in range(len(error))), default=0.0)
    return gain / largest, max(0.0, -error.min()) / largest


@pytest.mark.parametrize("seed", range(5))
def test_gain_and_loss_of_any_history(seed):
    rng = np.random.default_rng(seed)
    stored = rng.uniform(size=20) * 10.0 ** rng.uniform(-2, 2, 20)
    balance = EnergyBalance.start(stored[0], 0.0, 0.0)
    for value in stored[1:]:
        balance = balance.advance(value, 0.0, 0.0, np.zeros(3), no_forces(), no_forces())
    assert (balance.gain, balance.loss) == pytest.approx(extremes(stored - stored[0], stored), rel=1e-12)


def test_nothing_stored_is_no_gain_and_no_loss():
    balance = EnergyBalance.start(0.0, 0.0, 0.0).advance(0.0, 0.0, 0.0, np.zeros(3), no_forces(), no_forces())
    assert (balance.gain, balance.loss) == (0.0, 0.0)


@pytest.fixture(scope="module")
def plucked():
    """A held sheet with everything that takes part in the balance: driver, gravity, both kinds of damping."""
    return run(
        film(
            0.1,
            TAUT,
            {"mass_damping": 5.0, "stiffness_damping": 1e-4},
            support=[{"at": {"box": [[0.0, 0.0], [0.0, 0.6]]}}],
            driver=[{"name": "d", "at": {"box": [[0.6, 0.0], [0.6, 0.6]]}, "translate": [0.0, 0.0, 0.05]}],
            load=[GRAVITY],
            integrator={"tolerance": 1e-5},
        )
    )


def test_history_obeys_the_definition(plucked):
    h = plucked.history
    stored = h["kinetic_energy"] + h["strain_energy"] + h["contact_energy"]
    expected = stored + h["dissipated"] - h["external_work"] - stored[0]
    np.testing.assert_allclose(h["energy_error"], expected, atol=1e-15)
    assert h["time"][0] == h["energy_error"][0] == h["step"][0] == h["newton_iterations"][0] == 0.0
    np.testing.assert_allclose(np.diff(h["time"]), h["step"][1:], rtol=1e-9)
    assert (np.diff(h["dissipated"]) >= 0.0).all()
    gain, loss = extremes(h["energy_error"], stored)
    assert (plucked.summary["energy_gain"], plucked.summary["energy_loss"]) == pytest.approx((gain, loss), rel=1e-9)
    assert loss < 0.05 and gain < 5e-3


def test_area_fractions_add_up(plucked):
    h = plucked.history
    np.testing.assert_allclose(h["taut"] + h["wrinkled"] + h["slack"], 1.0, atol=1e-12)


def test_counters_add_up(plucked):
    summary, history = plucked.summary, plucked.history
    assert summary["steps_accepted"] == len(history["time"]) - 1
    assert summary["newton_iterations"] >= history["newton_iterations"].sum()
    assert summary["wall_seconds"] == pytest.approx(sum(summary["phases"].values()))


@pytest.mark.parametrize("radius", [0.3, 1.0])
def test_work_of_a_slow_driver_is_the_strain_energy(radius):
    """A square stretched by 1e-3 both ways: U = E / (1 - nu) g^2 h A, g the strain (16); what is left is kinetic."""
    driver = [{"name": "d", "at": {"boundary": True}, "translate_to": "deployed", "overstretch": 1e-3}]
    result = run(film(0.2, {}, driver=driver, integrator={"step": 1e-3, "spectral_radius": radius}))
    h = {name: values[-1] for name, values in result.history.items()}
    strain = 1e-3 + 0.5e-6
    expected = 2.5e9 / (1 - 0.34) * strain**2 * 5e-4 * 0.36
    print(f"work {h['external_work']:.9f}, strain energy {h['strain_energy']:.9f}, exact {expected:.9f} J")
    assert h["strain_energy"] == pytest.approx(expected, rel=1e-6)
    assert h["external_work"] == pytest.approx(expected, rel=1e-3)
    assert h["kinetic_energy"] < 1e-6 * expected


def test_energy_error_falls_with_the_square_of_the_step():
    """Spectral radius 1, a driver on a vibrating sheet, no damping: only work and method err."""
    errors = []
    for step in (2e-4, 1e-4, 5e-5):
        scene = film(
            0.02,
            TAUT,
            {"model": "linear"},
            support=[{"at": {"boundary": True}, "fix": "xy"}],
            driver=[{"at": RIM["at"], "axes": "z", "translate": [0, 0, 0.005]}],
            integrator={"step": step, "spectral_radius": 1.0, "tolerance": 1e-6},
        )
        errors.append(np.abs(run(scene).history["energy_error"]).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    print(f"errors {errors} J, orders {orders}")
    assert orders[-1] > 1.8


def test_work_of_gravity_is_weight_times_fall():
    result = run(film(0.1, {}, load=[GRAVITY], integrator={"step": 0.01}))
    fall = 0.5 * 9.81 * result.history["time"] ** 2
    np.testing.assert_allclose(result.history["external_work"], MASS * 9.81 * fall, rtol=1e-12, atol=1e-15)


def test_mass_damping_slows_a_free_sheet_exponentially():
    load = [{"kind": "initial_velocity", "value": [0.0, 1.0, 2.0]}]
    material = {"model": "linear", "mass_damping": 4.0}
    result = run(film(0.5, {}, material, load=load, integrator={"step": 2e-3, "spectral_radius": 0.8}))
    h = result.history
    kinetic = 0.5 * MASS * 5.0 * np.exp(-2 * 4.0 * h["time"])
    np.testing.assert_allclose(h["kinetic_energy"], kinetic, rtol=1e-3)
    np.testing.assert_allclose(h["dissipated"], kinetic[0] - kinetic, atol=1e-4 * kinetic[0])


def lowest_mode(values, step, terms=10):
    """Circular frequency and decay of the slowest oscillation in equidistant values, by their linear recurrence."""
    table = np.lib.stride_tricks.sliding_window_view(values, terms + 1)
    recurrence, *_ = np.linalg.lstsq(table[:, :-1], table[:, -1], rcond=1e-10)
    rates = np.log(np.roots([1.0, *-recurrence[::-1]]).astype(complex)) / step
    kept = rates[(rates.imag > 1.0) & (rates.real > -100.0)]
    slowest = kept[np.argmin(kept.imag)]
    return slowest.imag, -slowest.real


@pytest.mark.parametrize(("mass_damping", "stiffness_damping"), [(0.0, 2e-4), (20.0, 0.0), (20.0, 2e-4)])
def test_a_taut_sheet_decays_at_the_rate_of_rayleigh_damping(mass_damping, stiffness_damping):
    """q = e^(-d t) cos(w t) with d = (alpha + beta (w^2 + d^2)) / 2."""
    result = run(
        film(
            0.25,
            TAUT,
            {"model": "linear", "mass_damping": mass_damping, "stiffness_damping": stiffness_damping},
            support=[RIM],
            load=[{"kind": "initial_velocity", "value": [0.0, 0.0, 1e-3]}],
            probe=[{"name": "centre", "at": [0.3, 0.3]}],
            integrator={"step": 5e-4, "spectral_radius": 1.0, "tolerance": 1e-7},
        )
    )
    frequency, decay = lowest_mode(result.probes["centre"][10:, 2], 5e-4)
    expected = 0.5 * (mass_damping + stiffness_damping * (frequency**2 + decay**2))
    print(f"{frequency / 2 / np.pi:.3f} Hz, decay {decay:.4f} 1/s, expected {expected:.4f}")
    assert decay == pytest.approx(expected, rel=5e-3)
    balance = {name: values[-1] for name, values in result.history.items()}
    assert abs(balance["energy_error"]) < 1e-2 * balance["dissipated"]


KINKED = {
    "linear": {"kind": "linear", "start": 0.03, "end": 0.06},
    "table": {"kind": "table", "table": [[0.0, 0.0], [0.03, 0.0], [0.06, 1.0], [0.1, 1.0]]},
    "trapezoid": {"kind": "trapezoid"},
}


@pytest.mark.parametrize("step", ["auto", 1e-3])
@pytest.mark.parametrize("profile", KINKED)
def test_jumps_of_the_velocity_of_a_driver_do_their_work(profile, step):
    """A sheet driven as a whole: no strain, all work is kinetic energy, also where the drive starts at once."""
    driver = {"at": {"all": True}, "translate": [0.0, 0.0, 0.1], "profile": KINKED[profile]}
    result = run(film(0.1, {}, {"model": "linear"}, driver=[driver], integrator={"step": step}))
    kinetic = result.history["kinetic_energy"]
    speed = {"linear": 0.1 / 0.03, "table": 0.1 / 0.03, "trapezoid": 4.0 / 3.0}[profile]
    assert kinetic.max() == pytest.approx(0.5 * MASS * speed**2, rel=1e-6)
    assert result.summary["energy_gain"] < 1e-9
    assert result.summary["energy_loss"] < 1e-9
    assert kinetic[-1] < 1e-9


def test_stiffness_damping_acts_from_the_start():
    """The first row has the damping force of the initial velocity: doubling beta doubles what it adds."""
    load = [{"kind": "initial_velocity", "value": [0.0, 0.1, 0.0], "at": {"near": [0.3, 0.3]}}]
    support = [{"name": "rim", **RIM}]
    forces = []
    for beta in (0.0, 1e-6, 2e-6):
        material = {"model": "linear", "stiffness_damping": beta}
        scene = film(1e-4, TAUT, material, load=load, support=support, integrator={"step": 1e-5})
        forces.append(run(scene).reactions["rim"][0])
    added = [f - forces[0] for f in forces[1:]]
    assert np.abs(added[0]).max() > 1e-3
    np.testing.assert_allclose(added[1], 2.0 * added[0], rtol=1e-6, atol=1e-9)
