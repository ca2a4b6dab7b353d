"""Kernels on several threads: the same bits as on one, each thread on a core of its own, errors come through."""

import os
import threading
import time

import numpy as np
import pytest
import warp as wp
from warp_origami.kernels.gather import gather_vectors
from warp_origami.kernels.precision import vec3

import warp_origami as origami
from membrane_cases import Film, distorted_sheet
from warp_origami.model.coordinates import affine_coordinates
from warp_origami.terms import membrane as terms_membrane
from warp_origami.terms.contact import edge_narrow, facets, masters, narrow
from warp_origami.terms.launches import Launch, launch_together
from warp_origami.terms.membrane import Membrane
from warp_origami.terms.threads import LATE, PAUSE, available_cores, team, use_threads

several = pytest.mark.skipif(available_cores() < 2, reason="one core")


@several
def test_tasks_of_a_team_run_at_the_same_time_each_on_its_core():
    """Both tasks wait for the other to have begun: on one thread they would wait for ever."""
    both, found = threading.Barrier(2, timeout=20.0), [None, None]

    def task(i):
        both.wait()
        found[i] = os.sched_getaffinity(0)

    home = os.sched_getaffinity(0)
    with use_threads(2) as two:
        two.run([[lambda: task(0)], [lambda: task(1)]])
    assert all(len(place) == 1 for place in found)
    assert found[0] != found[1]
    assert os.sched_getaffinity(0) == home
    assert team().size == 1


@several
def test_what_a_thread_raises_is_raised_and_the_team_goes_on():
    def fail():
        raise ValueError("broken")

    done = []
    with use_threads(2) as two:
        with pytest.raises(ValueError, match="broken"):
            two.run([[], [fail]])
        with pytest.raises(ValueError, match="broken"):
            two.run([[fail], [lambda: done.append(1)]])
        two.run([[lambda: done.append(2)], [lambda: done.append(3)], [lambda: done.append(4)]])  # more than threads
    assert sorted(done) == [1, 2, 3, 4]


@several
def test_threads_that_simulate_at_the_same_time_have_teams_of_their_own():
    """One begins and ends while the other one simulates: what that has is neither taken nor ended by it."""
    begun, ended, found = threading.Event(), threading.Event(), []

    def other():
        with use_threads(2) as own:
            begun.set()
            ended.wait(timeout=20.0)
            found.append(team() is own)
            own.run([[lambda: found.append(1)], [lambda: found.append(2)]])
        found.append(team().size)

    thread = threading.Thread(target=other)
    thread.start()
    begun.wait(timeout=20.0)
    with use_threads(2) as mine:
        assert team() is mine
    ended.set()
    thread.join(timeout=20.0)
    assert not thread.is_alive()
    assert team().size == 1
    assert found[0] is True
    assert sorted(found[1:]) == [1, 1, 2]


@several
@pytest.mark.parametrize("falling", [False, True])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 100])
def test_every_index_is_worked_on_once_however_launches_are_divided(count, falling):
    """A row map of one entry each, in two launches of different size: out = v[i] + zero, and nothing beyond."""
    values = np.random.default_rng(1).random((count + 10, 3))
    out = wp.zeros(count + 10, dtype=vec3, device="cpu")
    rows = wp.array(np.arange(count + 11), dtype=wp.int32, device="cpu")
    given = [rows, rows, wp.array(values, dtype=vec3, device="cpu")]
    low = count // 3
    launches = [
        Launch(gather_vectors, low, given, [out], "cpu", 1, falling=falling),
        Launch(gather_vectors, 5, given, [out], "cpu", 1, begin=low, falling=falling),
    ]
    launches[1].set_dim(count - low)
    with use_threads(2):
        launch_together(launches)
        launch_together(launches)
    expected = np.zeros_like(values)
    expected[:count] = values[:count]
    assert np.array_equal(out.numpy(), expected)


@several
def test_membrane_is_bitwise_the_same_on_two_threads(monkeypatch):
    for name in ("TANGENT_GRAIN", "GRADIENT_GRAIN", "GATHER_GRAIN"):
        monkeypatch.setattr(terms_membrane, name, 1)
    mesh, coordinates = distorted_sheet(8, crease=3)
    membrane = Membrane(mesh, coordinates, Film())
    q = affine_coordinates(mesh, coordinates, np.pad(mesh.vertices, ((0, 0), (0, 1))))
    random = np.random.default_rng(2)

    def everything(q):
        membrane.take_strains(q)
        membrane.advance_strains(q, 0.1 * q[::-1], 0.7)
        mixed = membrane.linearize(q, mixed=True)
        return [*membrane.gradient(q), *mixed, membrane.blocks.numpy().copy(), *membrane.tangent(q)[1:]]

    for _ in range(20):
        state = q + 1e-3 * random.standard_normal(q.shape)
        alone = [np.copy(part) for part in everything(state)]
        with use_threads(2):
            together = [np.copy(part) for part in everything(state)]
        assert all(np.array_equal(a, b) for a, b in zip(alone, together, strict=True))


@several
def test_a_run_with_contact_is_bitwise_the_same_on_two_threads(monkeypatch):
    for module in (narrow, facets, edge_narrow, masters):  # every launch is divided, however small
        monkeypatch.setattr(module, "GRAIN", 1)
    scene = origami.load_scene("hard/crossing_strips")
    runs = [origami.simulate(scene, device="cpu", until=0.03, threads=threads) for threads in (1, 2)]
    assert runs[0].history["contacts_sts"].max() > 0
    assert runs[0].history["contacts_nts"].max() > 0
    for name in runs[0].history:
        assert np.array_equal(runs[0].history[name], runs[1].history[name]), name
    assert np.array_equal(runs[0].frames[-1].nodes, runs[1].frames[-1].nodes)


@several
def test_a_team_whose_core_is_busy_elsewhere_leaves_work_to_one_thread_for_a_while():
    """The other part always takes longer than the own one, as when another program has its core."""
    with use_threads(2) as two:
        assert two.begin()
        for _ in range(LATE):
            two.run([[], [lambda: time.sleep(1e-3)]])
        assert not any(two.begin() for _ in range(PAUSE))
        assert two.begin()
