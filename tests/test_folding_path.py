"""Folding paths: rigid ones are found to round-off, others with a strain."""

import numpy as np
import pytest

from warp_origami.model.folding_path import folding_path
from warp_origami.model.generators import build_pattern
from warp_origami.model.generators.leaf_out import leaf_out
from warp_origami.model.pattern_report import describe_pattern


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [
        ("miura", {"nx": 3, "ny": 3, "a": 0.1, "b": 0.08, "sector_angle": 1.0, "opening": 0.2}),
        ("leaf_out", {}),
        ("leaf_out", {"opening": 0.0}),
        ("z_fold", {"opening": 0.0, "strips": 5}),
        ("square_twist", {}),
        ("square_twist", {"opening": 0.0}),
    ],
)
def test_rigid_patterns_fold_without_strain(kind, parameters):
    pattern = build_pattern(kind, parameters)
    path = folding_path(pattern.mesh, pattern.stowed, 11)
    assert path.rigid
    assert path.strain.max() < 1e-12 and path.bending.max() < 1e-12
    assert not path.crossing.any()
    assert np.all(np.diff(path.progress) > 0.0) and path.progress[[0, -1]].tolist() == [0.0, 1.0]
    assert np.ptp(path.positions[-1][:, 2]) == 0.0


def test_path_of_the_leaf_out_is_the_closed_form():
    """The states that are found have the shape of the generator at their opening."""
    pattern = leaf_out(opening=0.3)
    path = folding_path(pattern.mesh, pattern.stowed, 11)
    extent = [np.linalg.norm(points - points.mean(axis=0), axis=1).max() for points in path.positions]
    spread = [np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1)) for points in path.positions]
    openings = np.linspace(0.3, 3.1, 400)
    shapes = [leaf_out(opening=o).stowed for o in openings]
    known = [np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1)) for points in shapes]
    radius = [np.linalg.norm(points - points.mean(axis=0), axis=1).max() for points in shapes]
    order = np.argsort(known)
    assert np.allclose(
        np.interp(spread[1:-1], np.array(known)[order], np.array(radius)[order]), extent[1:-1], rtol=1e-4
    )


def test_classic_twist_has_no_rigid_path():
    pattern = build_pattern("square_twist", {"assignment": "classic"})
    path = folding_path(pattern.mesh, pattern.stowed, 11)
    assert not path.rigid
    assert 1e-2 < path.strain.max() < 0.5
    assert path.strain[[0, -1]].max() < 1e-14


def test_report_says_what_a_pattern_is():
    lines = dict(describe_pattern(build_pattern("square_twist", {})))
    assert lines["flat-foldable"].startswith("4 of 4 inner vertices")
    assert lines["folding path"].startswith("rigid: strain")
    assert "no crossing" in lines["stowed state"]
    sail = build_pattern("cross_fold", {"strips": 2, "columns": 1, "hub": 0.0, "opening": 0.0})
    lines = dict(describe_pattern(sail))
    assert "not rigid: strain" in lines["folding path"] and "pairs of layers" in lines["stowed state"]
    assert describe_pattern(build_pattern("disc", {"radius": 1.0, "rings": 2})) == [("sheet", "2 x 2 m")]
