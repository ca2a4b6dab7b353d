"""Two equal free sheets that meet flat: duration, depth and energy of an elastic impact."""

import numpy as np
import pytest

import warp_origami as wo
from flying_sheets import AREAL_MASS, FILM, facing
from runs import run, system_of
from warp_origami.solve.generalized_alpha import GeneralizedAlpha
from warp_origami.terms.contact.law import Barrier, Penalty

THICKNESS = FILM["thickness"]
STIFFNESS = 1e8
DURATION = np.pi * np.sqrt(AREAL_MASS / (2 * STIFFNESS))
DEPTH = np.sqrt(AREAL_MASS / (2 * STIFFNESS))
"""Half sine of the penalty at 1 m/s: 1.87182e-4 s, 5.95819e-5 m."""

CONTACTS = {
    "penalty": ({"method": "sts", "sts_stiffness": STIFFNESS}, DURATION, THICKNESS),
    "auto": ({"method": "sts", "sts_stiffness": "auto"}, np.pi * 0.01 * THICKNESS, THICKNESS),
    "exact": ({"method": "sts", "sts_stiffness": STIFFNESS, "exact": True}, None, 1.1 * THICKNESS),
}


def bounce(law, begins, stiffness, speed, rho, step, start):
    """Energy after the impact over that before, and how long it takes: one mass against a law, generalized-alpha.

    `start` (m) is the distance from contact at the start, `stiffness` N/m for a mass of 1 kg.
    """

    def pushed(x):
        """Force and stiffness."""
        given = np.array([min(x, 0.0)]), np.array([stiffness]), np.array([begins])
        return (law.slope(*given).item(), law.curvature(*given).item()) if x < 0.0 else (0.0, 0.0)

    method = GeneralizedAlpha(rho)
    state = method.start(0.0, np.array([start]), np.array([-speed]), np.zeros(1), np.zeros(1), step)
    touched = []
    while not touched or state.time < touched[-1] + 5 * step:
        form = method.form(state, step)
        x = float(form.predictor[0])
        for _ in range(50):
            force, stiff = pushed(x)
            dx = float(form.b * (x - form.q_b[0]) + force) / (form.b + stiff)
            x -= dx
            if abs(dx) < 1e-14:
                break
        state = method.finish(state, form, np.array([x]))
        if x < 0.0:
            touched.append(state.time)
    return (state.v[0] / speed) ** 2, touched[-1] - touched[0]


def barrier_duration(stiffness, speed):
    """How long two sheets of AREAL_MASS touch behind a barrier of `stiffness` per area (N/m^3), finely integrated."""
    begins = 1.1 * THICKNESS
    return bounce(Barrier(THICKNESS), begins, 2 * stiffness / AREAL_MASS, speed, 1.0, DURATION / 4000, 1e-7)[1]


@pytest.mark.parametrize("name", CONTACTS)
@pytest.mark.parametrize("angle, rho", [(0.0, 1.0), (0.0, 0.3), (0.4, 0.3)])
def test_energy_returns_within_a_percent_at_twenty_steps_per_contact(tmp_path, name, rho, angle):
    """On 2 x 2 against 3 x 3 cells."""
    contact, duration, begins = CONTACTS[name]
    duration = duration or barrier_duration(STIFFNESS, 1.0)
    integrator = {"step": duration / 20, "spectral_radius": rho}
    gap = begins + 1.5 * duration / 20
    scene = facing(tmp_path, contact, 1.6 * duration, 1.0, angle=angle, gap=gap, integrator=integrator)
    result = wo.simulate(scene, device="cpu")
    history = result.history
    touching = np.count_nonzero(history["contacts_sts"])
    energy = history["kinetic_energy"] + history["strain_energy"] + history["contact_energy"]
    print(f"{name}, {rho}: {touching} steps in contact, energy {100 * (energy[-1] / energy[0] - 1):+.3f} %")
    assert touching >= 17 and history["contacts_sts"][-1] == 0
    # the corners of a turned sheet miss the other one and fly on
    assert history["contact_energy"].max() > (0.9 if angle == 0.0 else 0.8) * energy[0]
    assert abs(energy[-1] / energy[0] - 1.0) < 0.01
    if name == "exact":
        assert result.summary["max_penetration"] == 0.0


def test_sheets_exchange_their_velocities_behind_a_barrier(tmp_path):
    duration = barrier_duration(STIFFNESS, 1.0)
    contact = {"method": "sts", "sts_stiffness": STIFFNESS, "exact": True}
    integrator = {"step": duration / 30, "spectral_radius": 1.0}
    gap = 1.1 * THICKNESS + 2e-6
    scene = facing(tmp_path, contact, 1.1 * duration, 1.0, gap=gap, integrator=integrator)
    system, result = system_of(scene), run(scene)
    weights = system.mass @ np.isin(np.arange(len(system.q0)), system.coordinates.positions).astype(float)
    up = system.v0[:, 2] > 0
    for sheet, speed in ((up, -0.5), (~up, 0.5)):
        mean = result.v[-1][sheet, 2] @ weights[sheet] / (AREAL_MASS * 0.09)
        assert mean == pytest.approx(speed, rel=0.01)


@pytest.mark.parametrize("law, begins", [(Penalty(), THICKNESS), (Barrier(THICKNESS), 1.1 * THICKNESS)])
@pytest.mark.parametrize("rho", [1.0, 0.3])
def test_the_error_of_the_energy_falls_with_the_square_of_the_step(law, begins, rho):
    """For one mass, the worst of twenty distances at the start: where in a step contact begins decides the sign.

    Of the penalty, with the cube.
    """
    stiffness, worst = 2 * STIFFNESS / AREAL_MASS, []
    for steps in (20, 40, 80, 160):
        step = DURATION / steps
        shares = (np.arange(20) + 0.2) / 20
        errors = [bounce(law, begins, stiffness, 0.3, rho, step, s * 0.3 * step)[0] - 1.0 for s in shares]
        worst.append(float(np.abs(errors).max()))
    print(f"{law}, {rho}: {worst}")
    assert worst[0] < 0.01 and worst[-1] < worst[-2] / 3.3
    if isinstance(law, Penalty):
        assert worst[-1] < worst[0] / 300
