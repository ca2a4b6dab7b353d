"""The grid of boxes finds every pair once, of any sizes and anywhere, in parts of any length."""

import numpy as np
import pytest
import warp as wp
from warp_origami.kernels.precision import real, vec3

from warp_origami.terms.contact import box_pairs
from warp_origami.terms.contact.box_pairs import build_grid, joined, near_pairs, size_classes

RADIUS = 0.01


def crowd(count, seed, smallest=1e-4):
    """Boxes from `smallest` to 1 in a cube of side 2: low, high (n, 3)."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-1.0, 1.0, (count, 3))
    size = smallest ** rng.uniform(0.0, 1.0, (count, 1)) ** 2 * rng.uniform(0.0, 0.5, (count, 3))
    return middle - size, middle + size


def found(low, high, boxes, radius=RADIUS, **options):
    """Queries and items of all pairs of overlapping boxes; every pair counts as near."""

    def no_distance(queries, _items):
        return wp.zeros(len(queries), dtype=real, device="cpu")

    arrays = (wp.array(corner, dtype=vec3, device="cpu") for corner in (low, high))
    return joined(near_pairs(*arrays, boxes, radius, no_distance, **options))[:2]


def overlapping(low, high, boxes, radius=RADIUS):
    """The same by brute force: (n, m) bool."""
    below = (low[:, None] <= boxes[1] + radius).all(axis=2)
    return below & (boxes[0] - radius <= high[:, None]).all(axis=2)


def matrix(queries, items, shape):
    """(n, m) how often each pair was found."""
    result = np.zeros(shape, dtype=int)
    np.add.at(result, (queries, items), 1)
    return result


@pytest.mark.parametrize("part", [box_pairs.PART, 50])
def test_points_find_the_boxes_they_lie_in(part, monkeypatch):
    monkeypatch.setattr(box_pairs, "PART", part)
    boxes = crowd(400, 0)
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (700, 3))
    queries, items = found(points, points, boxes)
    wanted = overlapping(points, points, boxes)
    assert 200 < wanted.sum() < 0.2 * wanted.size
    np.testing.assert_array_equal(matrix(queries, items, wanted.shape), wanted)
    assert np.all(np.diff(queries) >= 0)


@pytest.mark.parametrize("part", [box_pairs.PART, 50])
@pytest.mark.parametrize("smallest", [1e-4, 0.9])
def test_boxes_find_each_other_once(part, smallest, monkeypatch):
    monkeypatch.setattr(box_pairs, "PART", part)
    boxes = crowd(300, 2, smallest)
    one, other = found(*boxes, boxes, among=True)
    got = matrix(one, other, (300, 300))
    wanted = overlapping(*boxes, boxes)
    np.fill_diagonal(wanted, False)
    assert wanted.sum() > 200
    np.testing.assert_array_equal(got + got.T, wanted)


def test_members_come_in_their_order():
    boxes = crowd(200, 3, smallest=0.5)
    points = np.random.default_rng(4).uniform(-1.0, 1.0, (100, 3))
    members = np.random.default_rng(5).permutation(200)[:120]
    queries, items = found(points, points, boxes, members=members)
    wanted = overlapping(points, points, boxes)
    wanted[:, np.setdiff1d(np.arange(200), members)] = False
    np.testing.assert_array_equal(matrix(queries, items, wanted.shape), wanted)
    rank = np.argsort(members)[np.searchsorted(np.sort(members), items)]
    assert np.all(np.diff(queries * 200 + rank) > 0)


def test_what_is_far_away_or_nowhere_does_no_harm():
    """Cells have no bound, and what lies beyond the last one that has a number is found all the same."""
    low, high = crowd(100, 6)
    far = np.array([[1e9, -3e8, 2e7]])
    low, high = (np.concatenate([corner, corner + far, [[np.nan] * 3]]) for corner in (low, high))
    with np.errstate(invalid="ignore"):
        one, other = found(low, high, (low, high), among=True)
        wanted = overlapping(low, high, (low, high))
    got = matrix(one, other, wanted.shape)
    np.fill_diagonal(wanted, False)
    np.testing.assert_array_equal(got + got.T, wanted)


def test_nothing_finds_nothing():
    none = np.zeros((0, 3))
    points = np.zeros((5, 3))
    assert [len(a) for a in found(points, points, (none, none))] == [0, 0]
    assert [len(a) for a in found(none, none, (points, points))] == [0, 0]


def test_a_mesh_graded_a_thousandfold_costs_what_an_even_one_costs():
    """Square boxes around a point, as many of each size: so many entries of the grid per box, and per slot."""
    for count in (8, 16, 32):
        angle, ring = np.meshgrid(np.arange(count), np.arange(int(count * np.log(1000.0) / 6.3)))
        radius = 1e-3 * np.exp(6.3 / count * ring.ravel())
        angle = 2 * np.pi / count * angle.ravel()
        middle = np.stack([radius * np.cos(angle), 0.8 * radius * np.sin(angle), 0.6 * radius * np.sin(angle)], axis=1)
        size = (3.2 / count * radius)[:, None]
        grid = build_grid(middle - size, middle + size, None, wp.get_device("cpu"))
        lengths = np.diff(grid.starts.numpy())
        assert lengths.sum() < 80 * len(middle)
        assert lengths.max() < 80
        assert 3 <= len(grid.inverse_widths) <= 7


def test_sizes_within_a_ratio_are_one_class():
    classes, widths = size_classes(np.array([1.0, 0.3, 0.9, 0.01, 0.015]))
    np.testing.assert_array_equal(classes, [1, 1, 1, 0, 0])
    assert widths[1] == pytest.approx(box_pairs.CELL_SHARE * 0.9)
