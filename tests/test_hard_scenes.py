"""Scenes that are hard for contact: nothing passes through anything in any accepted step, says an independent oracle.

The oracle looks at a sub-mesh twice as fine as that of contact. The quick tests run the cheap scenes; `-m slow` runs
all of them, also with random velocities.
"""

from functools import cache

import numpy as np
import pytest
from warp_origami.scenes import bundled_scenes
from watched_runs import Watch, watch, with_random_velocities, without_contact

from runs import States, system_of
from warp_origami.scene import load_scene
from warp_origami.study.results import read_value

SCENES = sorted(name for name in bundled_scenes() if name.startswith("hard/"))
CHEAP = ["hard/crossing_strips", "hard/poked_stack_10"]
DEAR = [name for name in SCENES if name not in CHEAP]
LARGEST_GAIN = 5e-3


@cache
def run(name):
    """The scene, what was seen, the summary and the states of its run."""
    scene, states = load_scene(name), States()
    return scene, *watch(scene, observers=[states]), states


def assert_nothing_passes(scene, seen, summary):
    assert summary["status"] == "done", summary.get("message")
    assert seen.steps == summary["steps_accepted"]
    assert seen.finite and not seen.crossings and not seen.passages
    assert summary["energy_gain"] < LARGEST_GAIN
    assert max(seen.history[column].max() for column in ("contacts_sts", "contacts_nts", "contacts_edge")) > 0
    assert summary["max_penetration"] < scene.contact.thickness
    assert summary["max_penetration"] > 0.0 or scene.contact.exact


def assert_values(scene, seen):
    """The numbers that the scene states."""
    for value in scene.verification.value if scene.verification else ():
        obtained = read_value(value.of, seen) / value.over
        print(scene.name, value.name, obtained, f"{obtained / value.exact - 1.0:+.1e}")
        assert abs(obtained / value.exact - 1.0) < value.tolerance, value.name


def momentum(scene, states):
    """(k, 3) of the sheets after each step, kg m/s."""
    system = system_of(scene)
    translation = np.zeros(system.coordinates.count)
    translation[system.coordinates.positions[system.coordinates.positions >= 0]] = 1.0
    return np.array([(system.mass @ translation) @ v for v in [system.v0, *states.v]])


def impulse(seen, name):
    """(3,) force of a support or driver on the sheet, summed over time, N s."""
    force, time = seen.reactions[name][:, :3], seen.history["time"]
    return 0.5 * (np.diff(time)[:, None] * (force[1:] + force[:-1])).sum(axis=0)


@pytest.mark.parametrize("name", SCENES)
def test_starts_uncrossed_without_strain_or_contact_force(name):
    scene = load_scene(name)
    system = system_of(scene)
    state = system.evaluate(system.q0)
    assert state.strain_energy < 1e-12 and state.contact_energy == 0.0
    seen = Watch(scene)
    seen.checkpoint({"kinematics.time": 1.0, "kinematics.q": system.q0, "kinematics.v": system.v0})
    assert seen.steps == 1 and not seen.crossings


def test_oracle_sees_what_passes():
    """The upper of the crossing strips moved through the lower one."""
    scene = load_scene("hard/crossing_strips")
    system, seen = system_of(scene), Watch(scene)
    upper = system.mesh.vertices[:, 1] > 0.09
    rows = system.coordinates.positions[upper]
    for time, depth in ((1.0, 1e-3), (2.0, 4e-3)):
        q = system.q0.copy()
        q[rows[system.mesh.vertices[upper, 0] < 0.2], 2] -= depth
        seen.checkpoint({"kinematics.time": time, "kinematics.q": q, "kinematics.v": q})
    assert seen.crossings == [2.0] and seen.passages == [2.0]


def test_oracle_sees_what_passes_flat():
    """The whole upper strip moved through the lower one in one step: no state crosses."""
    scene = load_scene("hard/crossing_strips")
    system, seen = system_of(scene), Watch(scene)
    rows = system.coordinates.positions[system.mesh.vertices[:, 1] > 0.09]
    for time, depth in ((1.0, 0.0), (2.0, 4e-3)):
        q = system.q0.copy()
        q[rows, 2] -= depth
        seen.checkpoint({"kinematics.time": time, "kinematics.q": q, "kinematics.v": q})
    assert not seen.crossings and seen.passages == [2.0]


@pytest.mark.parametrize("name", CHEAP)
def test_nothing_passes_in_cheap_scenes(name):
    scene, seen, summary, _ = run(name)
    assert_nothing_passes(scene, seen, summary)
    assert_values(scene, seen)


def test_momentum_of_the_poked_stack_goes_to_its_rims():
    scene, seen, _, states = run("hard/poked_stack_10")
    p = momentum(scene, states)
    lost = p[-1] - p[0]
    print("momentum", p[0], p[-1], "impulse of the rims", impulse(seen, "rims"))
    assert np.allclose(p[0], [0.0, 0.0, -0.071], rtol=1e-3, atol=1e-12)
    assert lost[2] > 0.0
    assert np.abs(impulse(seen, "rims") - lost).max() < 0.02 * lost[2]


@pytest.mark.slow
@pytest.mark.parametrize("name", DEAR)
def test_nothing_passes(name):
    scene, seen, summary, _ = run(name)
    assert_nothing_passes(scene, seen, summary)
    assert_values(scene, seen)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("seed", [1, 2])
def test_nothing_passes_with_random_velocities(name, seed):
    scene = with_random_velocities(load_scene(name), 0.05, seed)
    assert_nothing_passes(scene, *watch(scene))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [17, 43])
def test_ends_of_creases_do_not_close_beyond_flat(seed):
    """Crumpled sheets that are through themselves at an end of a crease on the rim, unless cones hold it open."""
    scene = with_random_velocities(load_scene("hard/crumpling"), 0.7, seed)
    assert_nothing_passes(scene, *watch(scene))


@pytest.mark.slow
def test_miura_sheet_does_not_cross_with_the_penalty():
    """Without exact contact, so that layers sink in at inner vertices."""
    scene = load_scene("hard/miura", ["contact.exact=false"])
    assert_nothing_passes(scene, *watch(scene))


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_crosses_without_contact(name):
    """So contact is what keeps it apart."""
    seen, _ = watch(without_contact(load_scene(name)))
    assert seen.crossings or seen.passages
