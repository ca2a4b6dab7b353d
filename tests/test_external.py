"""External forces in motion: their work is stored, their impulse is the momentum, and the end of it is the statics."""

import numpy as np
import pytest

import warp_origami as wo
from runs import film, run, system_of
from warp_origami.output.memory import Memory
from warp_origami.solve.simulate import simulate

LEFT, RIGHT = {"box": [[0.0, 0.0], [0.0, 0.6]]}, {"box": [[0.6, 0.0], [0.6, 0.6]]}
TAUT = {"initial": {"stretch": [1.002, 1.002]}}
PULLED = {"initial": {"stretch": [1.002, float(np.sqrt(1.0 - 0.34 * (1.002**2 - 1.0)))]}}
AREAL_MASS = 1420.0 * 5e-4
RIM = {"at": {"boundary": True}}


class KeepLast(Memory):
    """Keeps the last equilibrium of a static run."""

    def checkpoint(self, arrays):
        self.q = arrays["q"].copy()


def momentum(scene, result):
    """(3,) at the end, kg m/s."""
    system = system_of(scene)
    return (system.mass @ result.v[-1])[system.coordinates.positions].sum(axis=0)


@pytest.mark.parametrize(
    "load",
    [
        {"kind": "pressure", "value": 200.0},
        {"kind": "pressure", "value": 200.0, "follower": False},
        {"kind": "force", "at": RIGHT, "value": [0.0, 5.0, 20.0]},
    ],
    ids=["follower pressure", "dead pressure", "edge force"],
)
def test_the_energy_balance_closes_with_the_square_of_the_step(load):
    """A sheet under uniaxial tension, three sides of its rim free to move: work of the loads = energy stored."""
    errors = []
    for step in (4e-4, 2e-4, 1e-4):
        scene = film(
            0.01,
            PULLED,
            {"model": "linear"},
            support=[{"at": LEFT}, {"at": RIGHT, "fix": "xy"}],
            load=[load | {"profile": {"kind": "smooth"}}],
            integrator={"step": step, "spectral_radius": 1.0, "tolerance": 1e-9},
        )
        history = run(scene).history
        errors.append(np.abs(history["energy_error"]).max() / history["external_work"].max())
    print(f"energy error over the work: {errors}")
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > 1.7
    assert errors[-1] < 5e-3


@pytest.mark.parametrize("follower", [True, False])
def test_a_pulse_of_pressure_gives_a_free_flat_sheet_the_velocity_p_t_over_m(follower):
    """A sheet that stays flat: every point gets the same velocity, impulse per area over mass per area."""
    pulse = {"kind": "table", "table": [[0.0, 0.0], [1e-3, 1.0], [2e-3, 0.0]]}
    load = [{"kind": "pressure", "value": 100.0, "follower": follower, "profile": pulse}]
    result = run(film(3e-3, {}, load=load, integrator={"step": 2.5e-5}))
    system = system_of(film(3e-3, {}, load=load))
    velocity = result.v[-1][system.coordinates.positions, 2]
    np.testing.assert_allclose(velocity, 100.0 * 1e-3 / AREAL_MASS, rtol=1e-3)


@pytest.mark.parametrize(
    ("load", "impulse"),
    [
        ({"kind": "force", "at": {"near": [0.6, 0.6]}, "value": [0.3, -0.2, 0.5]}, [3e-3, -2e-3, 5e-3]),
        ({"kind": "gravity", "acceleration": [1.0, 2.0, 3.0]}, np.array([0.01, 0.02, 0.03]) * AREAL_MASS * 0.36),
        ({"kind": "pressure", "value": 2.0, "follower": False}, [0.0, 0.0, 2.0 * 0.36 * 0.01]),
    ],
    ids=["corner force", "gravity", "dead pressure"],
)
def test_the_momentum_of_a_free_sheet_is_the_impulse_of_the_load(load, impulse):
    scene = film(0.01, {}, load=[load], integrator={"step": 5e-4, "spectral_radius": 1.0, "tolerance": 1e-8})
    found = momentum(scene, run(scene))
    np.testing.assert_allclose(found, impulse, atol=1e-9 * np.abs(impulse).max())


def test_a_heavily_damped_motion_ends_in_the_static_equilibrium():
    load = [{"kind": "pressure", "value": 500.0, "profile": {"kind": "constant"}}]
    moving = film(0.3, TAUT, {"mass_damping": 600.0}, support=[RIM], load=load)
    tables = moving.model_dump(exclude_none=True) | {"analysis": {"kind": "static", "load_steps": 2}}
    equilibrium = KeepLast()
    simulate(wo.Scene(**tables), equilibrium, device="cpu")
    end, wanted = run(moving).q[-1], equilibrium.q
    print(f"height {wanted[:, 2].max():.5f} m, difference {np.abs(end - wanted).max():.1e} m")
    assert wanted[:, 2].max() > 0.005
    assert np.abs(end - wanted).max() < 1e-6
