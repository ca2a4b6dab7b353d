"""Pairs that contact leaves out, because they cannot have come near since the accepted state, have no force."""

import numpy as np

import warp_origami as origami
from warp_origami.clock import PhaseClock
from warp_origami.system import System


def test_looking_at_every_pair_gives_the_same_bits(monkeypatch):
    system = System(origami.load_scene("leaf_in"), "cpu", PhaseClock())
    points = system.contact._surfaces
    random = np.random.default_rng(3)
    scale = np.minimum(1.0, 10.0 * system.row_lengths / system.mesh.size)[:, None]
    touching = left_out = 0
    for k in range(60):
        q = system.q0 + 10.0 ** random.uniform(-4.0, -2.4) * scale * random.standard_normal(system.q0.shape)
        energy, gradient = points.gradient(q)
        left_out += int(np.count_nonzero(points._narrow.facets.read()[points._narrow.reached] > 1e20))
        with monkeypatch.context() as everything:
            everything.setattr(points._motion, "follow", lambda *_: points._motion.forget())
            expected = points.gradient(q)
            left_out -= int(np.count_nonzero(points._narrow.facets.read()[points._narrow.reached] > 1e20))
        assert energy == expected[0]
        assert np.array_equal(gradient, expected[1])
        touching += energy > 0.0
        if k % 10 == 9:
            points.accept(q)
    assert touching > 10
    assert left_out > 1000
