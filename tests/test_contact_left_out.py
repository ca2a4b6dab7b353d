"""Pairs that contact leaves out, because they cannot have come near since the accepted state, have no force."""

import numpy as np
import pytest

import warp_origami as origami
from contact_cases import TwoSheets, settings
from contact_meshes import grid
from warp_origami.clock import PhaseClock
from warp_origami.system import System
from warp_origami.terms.contact import Contact


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


def bent(sheets, height, curvature=1.0):
    """Both sheets bent into the valley z = curvature x^2 / 2, the upper one higher by `height`: cubic elements are
    exact there, and lie off their sub-triangles."""
    q = sheets.at(0.0)
    for element, corners in zip(sheets.coordinates.elements, sheets.mesh.triangles, strict=True):
        for i, vertex in enumerate(corners):
            x, y, _ = q[sheets.coordinates.positions[vertex]]
            z = 0.5 * curvature * x * x + (height if sheets.above[vertex] else 0.0)
            q[element[3 * i : 3 * i + 3]] = [[x, y, z], [1.0, 0.0, curvature * x], [0.0, 1.0, 0.0]]
    return q


@pytest.mark.parametrize("depth", [1e-4, 5e-4, 1e-3, 2e-3, 4e-3])
def test_points_between_a_surface_and_its_sub_triangles_are_not_left_out(depth, monkeypatch):
    """In a valley a point may be above the surface and already below its sub-triangles, which are its chords."""
    vertices, triangles = grid(2, 2)
    sheets = TwoSheets((vertices, triangles), (0.5 * vertices + 0.05, triangles))
    contact = Contact(sheets.mesh, sheets.coordinates, settings("nts", thickness=2e-4), bent(sheets, 5e-3))
    near, points = bent(sheets, 4e-4), contact._surfaces
    contact.accept(bent(sheets, 5e-3))
    contact.accept(near)
    assert contact.gradient(near)[0] == 0.0
    assert points._surfaces.errors.read().max() > 1e-3
    energy, gradient = points.gradient(bent(sheets, -depth))
    monkeypatch.setattr(points._motion, "follow", lambda *_: points._motion.forget())
    expected = points.gradient(bent(sheets, -depth))
    assert expected[0] > 0.0
    assert energy == expected[0]
    assert np.array_equal(gradient, expected[1])
