"""Triangles of a simple polygon without new vertices: ears are cut off, then diagonals are turned until Delaunay.

A vertex in the middle of a straight side is a corner like any other: no triangle may have it on its side, so none is
lost and the neighbours across that side still share whole edges with this face. Faces are many and small, so the work
is done on plain floats.
"""

import math

import numpy as np

Point = tuple[float, float]

THINNEST = 1e-9
"""Height over longest side below which a triangle is taken for a line."""


def triangulate(polygon: np.ndarray) -> np.ndarray | None:
    """(n - 2, 3) corners of counter-clockwise triangles that fill a polygon, or None if it is not simple.

    Of all triangulations without new vertices the result has the largest smallest angle (constrained Delaunay).

    Args:
        polygon: (n, 2) vertices in order, in either sense, n >= 3; need not be convex.
    """
    points = [tuple(point) for point in np.asarray(polygon, dtype=float).tolist()]
    area = polygon_area(points)
    loop = list(range(len(points)))
    triangles = _cut_ears(points, loop if area > 0 else loop[::-1])
    if triangles is None or any(smallest_angle(*_corners(points, t)) <= 0 for t in triangles):
        return None
    covered = sum(polygon_area(_corners(points, t)) for t in triangles)
    if abs(covered - abs(area)) > 1e-9 * covered:
        return None
    return np.array(_turn_diagonals(points, triangles))


def polygon_area(points: list[Point]) -> float:
    """Area of a polygon, positive where it is counter-clockwise, m^2."""
    x0, y0 = points[0]
    pairs = zip(points, [*points[1:], points[0]], strict=True)
    return 0.5 * sum((ax - x0) * (by - y0) - (bx - x0) * (ay - y0) for (ax, ay), (bx, by) in pairs)


def smallest_angle(a: Point, b: Point, c: Point) -> float:
    """Smallest angle of a triangle, rad; 0 if it is clockwise or a line."""
    twice_area = _cross(a, b, c)
    short, middle, long = sorted(
        (
            (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2,
            (c[0] - b[0]) ** 2 + (c[1] - b[1]) ** 2,
            (a[0] - c[0]) ** 2 + (a[1] - c[1]) ** 2,
        )
    )
    if twice_area <= THINNEST * long:
        return 0.0
    # It is opposite to the shortest side, between the other two.
    return math.atan2(twice_area, 0.5 * (middle + long - short))


def _cut_ears(points: list[Point], loop: list[int]) -> list[tuple[int, int, int]] | None:
    """Triangles of a counter-clockwise loop of vertices, the ear with the largest smallest angle first."""
    triangles = []
    convex = {b: smallest_angle(*_corners(points, (a, b, c))) > 0 for a, b, c in _ears(loop)}
    quality = {ear[1]: _ear_quality(points, ear, convex) for ear in _ears(loop)} if len(loop) > 3 else {}
    while len(loop) > 3:
        best = max(loop, key=quality.__getitem__)
        if quality[best] <= 0:
            return None
        k = loop.index(best)
        before, after = loop[k - 1], loop[(k + 1) % len(loop)]
        triangles.append((before, best, after))
        del loop[k], convex[best]
        # An ear that is blocked is blocked by a vertex that is not convex, so only the two neighbours change.
        ears = [(loop[j - 1], loop[j], loop[(j + 1) % len(loop)]) for j in (loop.index(before), loop.index(after))]
        for ear in ears:
            convex[ear[1]] = smallest_angle(*_corners(points, ear)) > 0
        for ear in ears:
            quality[ear[1]] = _ear_quality(points, ear, convex)
    return [*triangles, tuple(loop)]


def _ears(loop: list[int]) -> list[tuple[int, int, int]]:
    return list(zip([loop[-1], *loop[:-1]], loop, [*loop[1:], loop[0]], strict=True))


def _ear_quality(points: list[Point], ear: tuple[int, int, int], convex: dict[int, bool]) -> float:
    """Smallest angle (rad) of the triangle that would be cut off; 0 if another vertex lies in it or on its sides."""
    a, b, c = corners = _corners(points, ear)
    angle = smallest_angle(*corners)
    if angle <= 0:
        return 0.0
    tolerance = -THINNEST * max(math.dist(a, b), math.dist(b, c), math.dist(c, a)) ** 2
    for vertex, is_convex in convex.items():
        if is_convex or vertex in ear:
            continue
        p = points[vertex]
        if _cross(a, b, p) >= tolerance and _cross(b, c, p) >= tolerance and _cross(c, a, p) >= tolerance:
            return 0.0
    return angle


def _turn_diagonals(points: list[Point], triangles: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """Triangles after turning diagonals as long as the smaller angle of their two triangles grows."""
    owner = {edge: t for t, triangle in enumerate(triangles) for edge in _sides(triangle)}
    pending = [edge for edge in owner if edge[::-1] in owner and edge[0] < edge[1]]
    while pending:
        a, b = pending.pop()
        if (a, b) not in owner or (b, a) not in owner:
            continue
        left, right = owner[a, b], owner[b, a]
        c, d = (sum(triangles[t]) - a - b for t in (left, right))
        turned = ((a, d, c), (d, b, c))
        before = min(smallest_angle(*_corners(points, triangles[t])) for t in (left, right))
        if min(smallest_angle(*_corners(points, t)) for t in turned) <= before * (1 + 1e-9):
            continue
        del owner[a, b], owner[b, a]
        for t, triangle in zip((left, right), turned, strict=True):
            triangles[t] = triangle
            owner.update(dict.fromkeys(_sides(triangle), t))
        pending += [edge for edge in ((a, d), (d, b), (b, c), (c, a)) if edge in owner and edge[::-1] in owner]
    return triangles


def _sides(triangle: tuple[int, int, int]) -> tuple[tuple[int, int], ...]:
    a, b, c = triangle
    return (a, b), (b, c), (c, a)


def _corners(points: list[Point], triangle: tuple[int, int, int]) -> list[Point]:
    return [points[k] for k in triangle]


def _cross(a: Point, b: Point, c: Point) -> float:
    """Twice the area of a triangle, positive where it is counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
