"""Triangles that pass through each other, against an independent oracle."""

import ipctk
import numpy as np
import pytest

import warp_origami as wo
from warp_origami.clock import PhaseClock
from warp_origami.model.crossing import find_crossing
from warp_origami.model.generators.leaf_in import leaf_in
from warp_origami.model.refine import refine_pattern
from warp_origami.system import System


@pytest.mark.parametrize("corner", [0.302, 0.3035, 0.306, 0.309, 0.312, 0.318, 0.326, 0.335])
def test_stowed_leaf_in_agrees_with_the_oracle(corner):
    pattern = leaf_in(inset=0.005, corner_distance=corner)
    mesh = pattern.mesh
    oracle = ipctk.CollisionMesh(pattern.stowed, ipctk.edges(mesh.triangles), mesh.triangles)
    found = find_crossing(pattern.stowed, mesh.edges, mesh.triangles) is not None
    assert found == ipctk.has_intersections(oracle, pattern.stowed)


def test_random_triangles_agree_with_the_oracle():
    rng = np.random.default_rng(0)
    answers = []
    for _ in range(60):
        points = rng.normal(size=(12, 3)) + rng.normal(size=(12, 3))
        triangles = np.arange(12, dtype=np.int32).reshape(-1, 3)
        edges = ipctk.edges(triangles)
        oracle = ipctk.has_intersections(ipctk.CollisionMesh(points, edges, triangles), points)
        assert (find_crossing(points, edges, triangles) is not None) == oracle
        answers.append(oracle)
    assert 5 < sum(answers) < 55


@pytest.mark.parametrize("n", [2, 3, 5])
def test_elements_of_one_plane_face_do_not_cross(n):
    """Their corners lie in one plane up to round-off."""
    answers = set()
    for corner in (0.303, 0.312, 0.326):
        coarse = leaf_in(inset=0.005, corner_distance=corner)
        fine = refine_pattern(coarse, n)
        crosses = [find_crossing(p.stowed, p.mesh.edges, p.mesh.triangles) is not None for p in (coarse, fine)]
        assert crosses[0] == crosses[1]
        answers.add(crosses[0])
    assert answers == {True, False}


def test_contact_refuses_a_start_that_crosses():
    scene = wo.load_scene("leaf_in", ["pattern.corner_distance=0.303"])
    with pytest.raises(wo.InputError, match=r"pattern.initial: got .*faces \d+ and \d+ cross"):
        System(scene, "cpu", PhaseClock())
