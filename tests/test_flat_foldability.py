"""Kawasaki and Maekawa: single vertices that can be folded flat, and ones that cannot."""

import numpy as np
import pytest

from warp_origami.errors import InputError
from warp_origami.model.flat_foldability import check_flat_foldable, vertex_folds
from warp_origami.model.generators import build_pattern
from warp_origami.model.mesh import build_mesh


def vertex(angles, letters):
    """A round sheet with one inner vertex and creases at these angles (degrees)."""
    turn = np.radians(angles)
    points = np.concatenate([[[0.0, 0.0]], np.stack([np.cos(turn), np.sin(turn)], axis=1)])
    n = len(turn)
    triangles = [(0, 1 + k, 1 + (k + 1) % n) for k in range(n)]
    return build_mesh(points, np.array(triangles), np.array([(0, 1 + k) for k in range(n)]), np.array(list(letters)))


@pytest.mark.parametrize(
    ("angles", "letters", "foldable"),
    [
        ([0, 60, 180, 240], "MMMV", False),  # 60 + 60, not 180
        ([0, 60, 150, 270], "MMMV", True),  # 60 + 120 = 90 + 90
        ([0, 60, 150, 270], "MMVV", False),  # Maekawa
        ([0, 60, 150, 270], "MMUV", True),  # it may still be given the right letter
        ([0, 72, 144, 216, 288], "MMMVV", False),  # odd
        ([0, 60, 120, 180, 240, 300], "MVMMVM", True),
    ],
)
def test_single_vertices(angles, letters, foldable):
    folds = vertex_folds(vertex(angles, letters))
    assert folds.vertices.tolist() == [0]
    assert folds.degrees.tolist() == [len(angles)]
    assert folds.flat_foldable.tolist() == [foldable]


def test_miss_is_told_in_radians():
    folds = vertex_folds(vertex([0, 60, 180, 240], "MMMV"))
    assert np.isclose(folds.kawasaki[0], np.pi - np.radians(120))


def test_refusal_names_parameter_place_and_theorem():
    with pytest.raises(InputError, match=r"pattern\.angle: got 1\.5, wants .*Kawasaki.*1\.05 rad off at vertex 0"):
        check_flat_foldable(vertex([0, 60, 180, 240], "MMMV"), "pattern.angle", 1.5)
    with pytest.raises(InputError, match="Maekawa"):
        check_flat_foldable(vertex([0, 60, 150, 270], "MMVV"), "pattern.angle", 1.5)


@pytest.mark.parametrize("kind", ["square_twist", "miura"])
def test_patterns_that_fold_flat_pass(kind):
    miura = {"nx": 4, "ny": 3, "a": 0.1, "b": 0.08, "sector_angle": 1.0}
    folds = vertex_folds(build_pattern(kind, miura if kind == "miura" else {"nx": 2}).mesh)
    assert len(folds.vertices) and folds.flat_foldable.all()


def test_centre_of_a_leaf_is_no_flat_fold():
    """Eight creases, as many mountains as valleys: the medians stay folded by a right angle."""
    mesh = build_pattern("leaf_out", {}).mesh
    folds = vertex_folds(mesh)
    wrong = folds.vertices[~folds.flat_foldable]
    assert np.abs(mesh.vertices[wrong]).max() < 1e-12
