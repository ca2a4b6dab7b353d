"""Whether triangles lie side by side in the plane, as those of a flat sheet must."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

PAIRS_AT_ONCE = 200_000


@dataclass(frozen=True)
class Collision:
    """Two triangles that are no part of one flat sheet.

    Attributes:
        triangles: the two.
        vertex: the vertex of the first that lies on a side of the second; None where they overlap.
    """

    triangles: tuple[int, int]
    vertex: int | None


def coincident_vertices(points: np.ndarray, tolerance: float) -> tuple[int, int] | None:
    """Two of the points (n, 2) that are closer than the tolerance (m), or None."""
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    return None if len(pairs) == 0 else (int(pairs[0, 0]), int(pairs[0, 1]))


def find_collision(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> Collision | None:
    """First two counter-clockwise triangles that overlap, or of which one has a vertex on a side of the other.

    Triangles with a common edge are not compared: on opposite sides of it they cannot overlap.

    Args:
        points: (n, 2), m.
        triangles: (ne, 3).
        tolerance: m, depth of overlap that counts as none, distance from a side that counts as on it.
    """
    corners = points[triangles]
    for i, j in _near_pairs(corners, tolerance):
        shared = (triangles[i][:, :, None] == triangles[j][:, None, :]).sum(axis=(1, 2))
        i, j = i[shared < 2], j[shared < 2]
        depth = -np.maximum(separation(corners[i], corners[j]), separation(corners[j], corners[i]))
        if (depth > tolerance).any():
            k = int(np.argmax(depth > tolerance))
            return Collision((int(i[k]), int(j[k])), None)
        for a, b in ((i, j), (j, i)):
            foreign = (triangles[a][:, :, None] != triangles[b][:, None, :]).all(axis=2)
            touching = foreign & (_distance_to_sides(corners[a], corners[b]) <= tolerance)
            if touching.any():
                k, corner = np.argwhere(touching)[0]
                return Collision((int(a[k]), int(b[k])), int(triangles[a[k], corner]))
    return None


def _near_pairs(corners: np.ndarray, margin: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of triangles (ne, 3, 2) whose bounding boxes meet, in portions; a pair may come more than once.

    Boxes are spread over square cells, in each cell swept along x. The cell size bounds the entries to a few per box.
    """
    low = corners.min(axis=1) - margin
    high = corners.max(axis=1) + margin
    extent = high - low
    cell = max(np.sqrt(extent.prod(axis=1).mean()), extent.mean())
    first = np.floor((low - low.min(axis=0)) / cell).astype(np.int64)
    last = np.floor((high - low.min(axis=0)) / cell).astype(np.int64)
    wide, tall = (last - first + 1).T
    box = np.repeat(np.arange(len(corners)), wide * tall)
    rank = np.arange(len(box)) - np.repeat(np.cumsum(wide * tall) - wide * tall, wide * tall)
    row, column = np.divmod(rank, wide[box])
    cells = (first[box, 0] + column) * (last[:, 1].max() + 1) + first[box, 1] + row

    order = np.lexsort((low[box, 0], cells))
    box, cells = box[order], np.unique(cells[order], return_inverse=True)[1]
    span = 2.0 * (high[:, 0].max() - low[:, 0].min())
    start = cells * span + (low[box, 0] - low[:, 0].min())
    stop = cells * span + (high[box, 0] - low[:, 0].min())
    follow = np.maximum(np.searchsorted(start, stop, side="right") - np.arange(len(box)) - 1, 0)

    done = 0
    total = np.cumsum(follow)
    while done < len(box):
        until = max(done + 1, int(np.searchsorted(total, (total[done - 1] if done else 0) + PAIRS_AT_ONCE)))
        counts = follow[done:until]
        one = np.repeat(np.arange(done, min(until, len(box))), counts)
        two = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(counts) - counts, counts)
        i, j = box[one], box[two]
        meet = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1]) & (i != j)
        yield i[meet], j[meet]
        done = until


def separation(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(n,) largest distance at which a side of triangle `one` (n, 3, 2) leaves all of triangle `two` outside."""
    sides = np.roll(one, -1, axis=1) - one
    outward = np.stack([sides[..., 1], -sides[..., 0]], axis=2) / np.linalg.norm(sides, axis=2, keepdims=True)
    reach = np.einsum("nkc,nkvc->nkv", outward, two[:, None, :, :] - one[:, :, None, :])
    return reach.min(axis=2).max(axis=1)


def _distance_to_sides(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(n, 3) distance of each corner of triangle `one` (n, 3, 2) from the outline of triangle `two`."""
    sides = np.roll(two, -1, axis=1) - two
    offset = one[:, :, None, :] - two[:, None, :, :]  # (n, corner, side, 2)
    along = np.einsum("nvkc,nkc->nvk", offset, sides) / np.sum(sides**2, axis=2)[:, None, :]
    gap = offset - np.clip(along, 0.0, 1.0)[..., None] * sides[:, None]
    return np.linalg.norm(gap, axis=3).min(axis=2)
