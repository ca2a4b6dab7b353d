"""Triangles of a simple polygon without new vertices: ears are cut off, then diagonals are turned until Delaunay.

A vertex in the middle of a straight side is a corner like any other: no triangle may have it on its side, so none is
lost and the neighbours across that side still share whole edges with this face.
"""

from itertools import pairwise

import numpy as np


def triangulate(polygon: np.ndarray) -> np.ndarray | None:
    """(n - 2, 3) corners of counter-clockwise triangles that fill a polygon, or None if it is not simple.

    Of all triangulations without new vertices the result has the largest smallest angle (constrained Delaunay).

    Args:
        polygon: (n, 2) vertices in order, in either sense, n >= 3; need not be convex.
    """
    polygon = np.asarray(polygon, dtype=float)
    area = polygon_area(polygon)
    loop = np.arange(len(polygon)) if area > 0 else np.arange(len(polygon))[::-1]
    triangles = _cut_ears(polygon, loop)
    if triangles is None:
        return None
    covered = sum(polygon_area(polygon[t]) for t in triangles)
    if min(_smallest_angle(polygon[t]) for t in triangles) <= 0 or abs(covered - abs(area)) > 1e-9 * covered:
        return None
    return _turn_diagonals(polygon, triangles)


def _cut_ears(polygon: np.ndarray, loop: np.ndarray) -> np.ndarray | None:
    """Triangles of a counter-clockwise loop of vertices, the ear with the largest smallest angle first."""
    triangles = []
    quality = _ear_qualities(polygon, loop)
    while len(loop) > 3:
        k = int(np.argmax(quality))
        if quality[k] <= 0:
            return None
        triangles.append((loop[k - 1], loop[k], loop[(k + 1) % len(loop)]))
        loop, quality = np.delete(loop, k), np.delete(quality, k)
        # An ear that is blocked is blocked by a reflex vertex too, so removing k changes its two neighbours only.
        for j in (k - 1, k % len(loop)):
            quality[j] = _ear_quality(polygon, loop, j)
    return np.array([*triangles, tuple(loop)])


def _ear_qualities(polygon: np.ndarray, loop: np.ndarray) -> np.ndarray:
    return np.array([_ear_quality(polygon, loop, k) for k in range(len(loop))])


def _ear_quality(polygon: np.ndarray, loop: np.ndarray, k: int) -> float:
    """Smallest angle (rad) of the triangle at the k-th vertex of the loop; 0 if it is no ear."""
    a, b, c = loop[k - 1], loop[k], loop[(k + 1) % len(loop)]
    corners = polygon[[a, b, c]]
    angle = _smallest_angle(corners)
    if angle <= 0:
        return 0.0
    others = polygon[loop[(loop != a) & (loop != b) & (loop != c)]]
    sides = np.roll(corners, -1, axis=0) - corners
    offset = others[:, None, :] - corners
    height = (sides[:, 0] * offset[..., 1] - sides[:, 1] * offset[..., 0]) / np.linalg.norm(sides, axis=1)
    tolerance = 1e-9 * np.abs(sides).max()
    return 0.0 if (height >= -tolerance).all(axis=1).any() else angle


def _smallest_angle(corners: np.ndarray) -> float:
    """Smallest angle of a triangle, rad; 0 if it is clockwise or a line (its height below 1e-9 of its side)."""
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    twice_area = 2 * polygon_area(corners)
    if twice_area <= 1e-9 * lengths.max() ** 2:
        return 0.0
    # The smallest angle is opposite to the shortest side, between the other two.
    short, middle, long = np.sort(lengths)
    return float(np.arctan2(twice_area, 0.5 * (middle**2 + long**2 - short**2)))


def _turn_diagonals(polygon: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles after turning diagonals as long as the smaller angle of their two triangles grows."""
    triangles = [tuple(map(int, t)) for t in triangles]
    owner = {edge: t for t, triangle in enumerate(triangles) for edge in _sides(triangle)}
    pending = [edge for edge in owner if edge[::-1] in owner and edge[0] < edge[1]]
    while pending:
        a, b = pending.pop()
        if (a, b) not in owner or (b, a) not in owner:
            continue
        left, right = owner[a, b], owner[b, a]
        c, d = (sum(triangles[t]) - a - b for t in (left, right))
        turned = ((a, d, c), (d, b, c))
        before = min(_smallest_angle(polygon[list(triangles[t])]) for t in (left, right))
        if min(_smallest_angle(polygon[list(t)]) for t in turned) <= before * (1 + 1e-9):
            continue
        del owner[a, b], owner[b, a]
        for t, triangle in zip((left, right), turned, strict=True):
            triangles[t] = triangle
            owner.update(dict.fromkeys(_sides(triangle), t))
        pending += [edge for edge in ((a, d), (d, b), (b, c), (c, a)) if edge in owner and edge[::-1] in owner]
    return np.array(triangles)


def _sides(triangle: tuple[int, int, int]) -> list[tuple[int, int]]:
    return list(pairwise((*triangle, triangle[0])))


def polygon_area(polygon: np.ndarray) -> float:
    """Area of a polygon (n, 2), positive where it is counter-clockwise, m^2."""
    x, y = (polygon - polygon[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
