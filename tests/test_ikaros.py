"""The spinning sail opens, and its spin rate follows the conservation of angular momentum."""

import numpy as np

import warp_origami as wo
from runs import system_of
from warp_origami.solve.simulate import simulate


def coarse():
    """The bundled scene with two strips a petal, up to where the arms are half open."""
    values = wo.load_scene("ikaros").model_dump(exclude_none=True)
    values["pattern"] |= {"strips": 2, "opening": 0.3}
    values["output"] |= {"fps": 1.0}
    return wo.Scene(**values)


def test_the_scene_is_the_sail_that_it_says():
    system = system_of(wo.load_scene("ikaros"))
    assert system.contact is not None
    assert system.scene.material.mass_damping == system.scene.material.stiffness_damping == 0.0
    sheet = 1420.0 * 7.5e-6 * (14.0**2 - 1.2**2)
    assert system.total_mass > 290.0 + 2.0 + 0.99 * sheet
    tips = system.coordinates.positions[np.abs(system.mesh.vertices).min(axis=1) == 7.0]
    assert len(tips) == 4
    np.testing.assert_allclose(system.mass.diagonal()[tips], 0.5, rtol=0.02)


def test_its_spin_rate_follows_the_conservation_of_angular_momentum():
    """Within 0.1 %, while the moment of inertia grows by a sixth; the sail stays uncrossed (contact is on)."""
    got = wo.simulate(coarse(), until=1.3)
    inertia, momentum = (got.spin[name] for name in ("moment_of_inertia", "angular_momentum.z"))
    assert inertia[-1] > 1.15 * inertia[0]
    mean = momentum / inertia
    np.testing.assert_allclose(mean, momentum[0] / inertia, rtol=1e-3)
    assert mean[-1] < 0.87 * mean[0]
    assert np.abs(got.spin["angular_momentum.x"]).max() < 1e-3 * momentum[0]
    assert abs(got.summary["angular_momentum_change"]) < 1e-3


def test_what_springs_and_hub_remember_is_in_the_checkpoint():
    """A run that is stopped and resumed gives the same bits."""

    class Checkpoints:
        def __init__(self):
            self.arrays = []

        def checkpoint(self, arrays):
            self.arrays.append({key: np.array(value) for key, value in arrays.items()})

        def __getattr__(self, name):
            return lambda *_: None

    scene = coarse()
    whole, rest = Checkpoints(), Checkpoints()
    simulate(scene, device="cpu", until=0.1, observer=whole, resume=None, threads=1)
    assert "creases.reference" in whole.arrays[0]
    middle = whole.arrays[len(whole.arrays) // 2]
    simulate(scene, device="cpu", until=0.1, observer=rest, resume=middle, threads=1)
    for key, values in whole.arrays[-1].items():
        np.testing.assert_array_equal(rest.arrays[-1][key], values, err_msg=key)
