"""Bundled scenes of the patterns, to their end: the numbers that they expect, and nothing gained."""

import pytest

from runs import run
from warp_origami.scene import load_scene
from warp_origami.study.results import read_value


@pytest.mark.slow
@pytest.mark.parametrize("name", ["z_fold", "leaf_out", "square_twist", "cross_fold"])
def test_scene_gives_what_it_expects(name):
    scene = load_scene(name)
    result = run(scene)
    assert result.summary["status"] == "done"
    assert result.summary["energy_gain"] < 1e-2
    for value in scene.verification.value:
        obtained = read_value(value.of, result) / value.over
        error = abs(obtained - value.exact) / (abs(value.exact) or 1.0)
        print(f"{name}: {value.name} {obtained:.8g}, expected {value.exact:.8g}")
        assert error < value.tolerance
