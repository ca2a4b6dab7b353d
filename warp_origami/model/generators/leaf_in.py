"""The leaf-in square of the paper (section 5): nested squares, diagonals and medians, stowed as four arms.

The text of the paper names no coordinates. They follow from four-fold mirror symmetry, three layers in each eighth of
the sheet, 48 triangles and a stress-free stowed state: ring corners P_k = (a_k, a_k) and ring middles Q_k = (a_k, 0)
with a_k = k side / 6, trapezoids cut by the creases Q_k-P_{k+1}. With these points alone the stowed state is an X of
coinciding layers. Ring middles 1 and 2 are therefore moved inwards by `inset`, which opens the layers; the stowed state
then is the shape whose edges all have their flat lengths:

    |x_i - x_j|^2 = |X_i - X_j|^2   on the 11 edges of one eighth,

for its 11 unknowns: radius and height of P_1, P_2 in the plane of the diagonal and of Q_1, Q_2, Q_3 in that of the
median, and the height of the centre. The distance of the corner P_3 from the axis is given, its height is 0. Other
numbers n of rings, and rings of other widths, go the same way: 4 n - 1 edges for as many unknowns.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from ...errors import InputError
from ..crossing import find_crossing
from ..fold_angles import fold_angles
from ..mesh import CREASE, Mesh, build_mesh
from ..pattern import Pattern

DIAGONAL = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0])

# In sides of the square, for three rings of equal width.
DEFAULT_INSET = 0.005 / 0.6
DEFAULT_CORNER_DISTANCE = 0.312 / 0.6
CONTINUATION_STEP = 0.004
CORNER_DISTANCES = (0.51, 0.515, 0.52, 0.53, 0.54, 0.56, 0.58, 0.6, 0.62, 0.64)
"""Tried in this order for other rings."""


def leaf_in(
    side: float = 0.6,
    inset: float | None = None,
    corner_distance: float | None = None,
    rings: int = 3,
    widths: tuple[float, ...] | None = None,
) -> Pattern:
    """Leaf-in square of 16 `rings` triangles, centred at the origin, sides along x and y.

    Args:
        side: m.
        inset: how far the ring middles but the outermost lie inside the squares of their rings, m; by default a
            twentieth of the narrowest ring.
        corner_distance: distance of the stowed corners from the axis, m; 0.312 / 0.6 side by default, where the layers
            are widest apart for the default inset of three equal rings (below about 0.508 side they cross), for other
            rings the first of CORNER_DISTANCES at which nothing crosses. Deployed it is side / sqrt(2). On the way
            there the panels of the smaller insets cross unless contact keeps them apart.
        rings: from the centre to the side.
        widths: of the rings from the centre outwards, over each other: they are scaled to fill the side. Equal by
            default.

    Raises:
        InputError: a side or a width that is not positive, widths that are not one for each ring; an inset or a
            distance without such a stowed state.
    """
    if not (np.isfinite(side) and side > 0):
        raise InputError("pattern.side", side, "a length above 0 (m)")
    if rings < 2:
        raise InputError("pattern.rings", rings, "at least 2 rings")
    widths = _widths(rings, widths)
    narrowest = widths.min() / (2.0 * widths.sum())
    inset = default_inset(rings, widths) if inset is None else inset / side
    if not 0 <= inset < narrowest:
        wants = f"a length from 0 to below the narrowest ring, {narrowest * side:.6g} (m)"
        raise InputError("pattern.inset", inset * side, wants)
    corner = default_corner(rings, widths, inset) if corner_distance is None else corner_distance / side
    if not 0.5 < corner < np.sqrt(0.5):
        raise InputError(
            "pattern.corner_distance", corner * side, f"between side / 2 and side / sqrt(2), side {side} m"
        )

    mesh, points = _square(_Eighth(widths, inset), corner)
    mesh = replace(mesh, vertices=side * mesh.vertices)
    points *= side
    return Pattern(_with_letters(mesh, points), points, np.arange(len(mesh.triangles)), np.zeros((0, 3), dtype=int))


def default_inset(rings: int, widths: Sequence[float] | None) -> float:
    """Inset unless given, in sides: a twentieth of the narrowest ring."""
    widths = _widths(rings, widths)
    narrowest = widths.min() / (2.0 * widths.sum())
    return DEFAULT_INSET if narrowest == 1.0 / 6.0 else 0.05 * narrowest


def default_corner(rings: int, widths: Sequence[float] | None, inset: float) -> float:
    """Distance of the corners from the axis unless given, in sides: the first of CORNER_DISTANCES at which nothing
    crosses, DEFAULT_CORNER_DISTANCE for three rings of equal width."""
    widths = _widths(rings, widths)
    if rings == 3 and np.ptp(widths) == 0.0:
        return DEFAULT_CORNER_DISTANCE
    for corner in CORNER_DISTANCES:
        try:
            mesh, points = _square(_Eighth(widths, inset), corner)
        except InputError:
            continue
        if find_crossing(points, mesh.edges, mesh.triangles) is None:
            return corner
    return DEFAULT_CORNER_DISTANCE


def _square(eighth: "_Eighth", corner: float) -> tuple[Mesh, np.ndarray]:
    """Mesh and stowed positions of the whole square, in sides, creases as yet unassigned."""
    stowed = eighth.stowed(corner)
    vertices, triangles, pieces = _mirror(eighth)
    points = np.empty((len(vertices), 3))
    for turn, numbers in pieces:
        points[numbers] = stowed @ turn.T
    return build_mesh(vertices, triangles, *_creases(eighth, pieces)), points


def _widths(rings: int, widths: Sequence[float] | None) -> np.ndarray:
    """(rings,) widths over each other."""
    if widths is None:
        return np.ones(rings)
    if len(widths) != rings:
        raise InputError("pattern.widths", f"{len(widths)} numbers", f"{rings}, one for each of the rings")
    for k, width in enumerate(widths):
        if not (np.isfinite(width) and width > 0):
            raise InputError(f"pattern.widths.{k}", width, "a number above 0: widths over each other")
    return np.array(widths, dtype=float)


class _Eighth:
    """The part between the median y = 0 and the diagonal, in sides of the square.

    Points are numbered: the centre, ring corners P_1 ... P_n, ring middles Q_1 ... Q_n, the middle of O-P_1.

    Attributes:
        flat: (2 n + 2, 3) flat positions.
        triangles: (2 n, 3) points.
        lengths: (4 n - 1, 2) points of the edges that keep their lengths: all but the halves of O-P_1 and MIDDLE-Q_1.
    """

    def __init__(self, widths: np.ndarray, inset: float):
        n = self.rings = len(widths)
        ring = np.cumsum(widths) / (2.0 * widths.sum())
        middles = ring - np.append(np.full(n - 1, inset), 0.0)
        self.inset, self.middle = inset, 2 * n + 1
        p, q = np.arange(1, n + 1), np.arange(n + 1, 2 * n + 1)
        self.flat = np.zeros((2 * n + 2, 3))
        self.flat[p, :2] = ring[:, None]
        self.flat[q, 0] = middles
        self.flat[self.middle] = 0.5 * self.flat[p[0]]
        triangles, lengths = [(0, q[0], self.middle), (self.middle, q[0], p[0])], [(0, p[0]), (0, q[0]), (q[0], p[0])]
        for k in range(n - 1):
            triangles += [(q[k], q[k + 1], p[k + 1]), (q[k], p[k + 1], p[k])]
            lengths += [(p[k], p[k + 1]), (q[k], q[k + 1]), (q[k + 1], p[k + 1]), (q[k], p[k + 1])]
        self.triangles, self.lengths = np.array(triangles), np.array(lengths)

        # the X of four vertical arms, corners at height 0: radius and height of P_1 ... P_(n-1), Q_1 ... Q_n, then of O
        height = np.zeros(n + 1)
        for k in range(n - 1, -1, -1):
            height[k] = height[k + 1] + (-1.0 if (n - k) % 2 else 1.0) * widths[k]
        arms = np.concatenate(
            [np.stack([np.cumsum(widths)[:-1], height[1:-1]], axis=1), np.stack([np.zeros(n), height[1:]], 1)]
        )
        self.four_arms = np.append(arms.ravel(), height[0]) / (2.0 * widths.sum())

    def stowed(self, corner: float) -> np.ndarray:
        """(2 n + 2, 3) stowed positions: continuation from the four arms in the corner distance."""
        i, j = self.lengths.T
        square = np.sum((self.flat[i] - self.flat[j]) ** 2, axis=1)

        def mismatch(unknowns, corner):
            points = self._place(unknowns, corner)
            return np.sum((points[i] - points[j]) ** 2, axis=1) / square - 1.0

        unit = np.array(
            [self._place(e, 0.0) for e in np.eye(len(self.lengths))]
        )  # positions are linear in the unknowns
        change = unit[:, i] - unit[:, j]  # (unknowns, edges, 3)

        def slope(unknowns, corner):
            points = self._place(unknowns, corner)
            return 2.0 * np.einsum("uec,ec->eu", change, points[i] - points[j]) / square[:, None]

        unknowns = self.four_arms
        steps = int(np.ceil(abs(corner - DEFAULT_CORNER_DISTANCE) / CONTINUATION_STEP))
        for distance in np.linspace(DEFAULT_CORNER_DISTANCE, corner, steps + 1) if steps else [corner]:
            unknowns = least_squares(mismatch, unknowns, slope, args=(distance,), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
            if np.abs(mismatch(unknowns, distance)).max() > 1e-12:
                raise InputError(
                    "pattern.corner_distance",
                    f"{corner} side with an inset of {self.inset:.6g} side",
                    "a stowed state without strain; there is none on the path from the four arms",
                )
        return self._place(unknowns, corner)

    def _place(self, unknowns: np.ndarray, corner: float) -> np.ndarray:
        """(2 n + 2, 3) positions: P_k in the plane of the diagonal, Q_k in that of the median y = 0, O on the axis."""
        n = self.rings
        points = np.zeros((2 * n + 2, 3))
        radius, height = unknowns[:-1:2], unknowns[1:-1:2]
        points[1:n] = radius[: n - 1, None] * DIAGONAL
        points[n] = corner * DIAGONAL
        points[n + 1 : 2 * n + 1, 0] = radius[n - 1 :]
        points[1:n, 2], points[n + 1 : 2 * n + 1, 2] = height[: n - 1], height[n - 1 :]
        points[0, 2] = unknowns[-1]
        points[self.middle] = 0.5 * (points[0] + points[1])
        return points


def _mirror(eighth: _Eighth) -> tuple[np.ndarray, np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """Flat vertices and triangles of all eighths, and for each its (3, 3) motion and the vertices of its points."""
    vertices: list[np.ndarray] = []
    triangles, pieces = [], []
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for turns in range(4):
        for mirror in (1.0, -1.0):
            motion = np.linalg.matrix_power(quarter, turns) @ np.diag([1.0, mirror, 1.0])
            numbers = []
            for point in eighth.flat @ motion.T:
                same = [k for k, vertex in enumerate(vertices) if np.abs(vertex - point).max() < 1e-9]
                if not same:
                    vertices.append(point)
                numbers.append(same[0] if same else len(vertices) - 1)
            numbers = np.array(numbers)
            pieces.append((motion, numbers))
            triangles.append(numbers[eighth.triangles])
    return np.array(vertices)[:, :2], np.concatenate(triangles), pieces


def _creases(eighth: _Eighth, pieces) -> tuple[np.ndarray, np.ndarray]:
    """Lines and letters of all edges except MIDDLE-Q_1, as yet unassigned."""
    middle = eighth.middle  # it lies on O-P_1, the first
    ends = np.concatenate([eighth.lengths[1:], [(0, middle), (middle, 1)]])
    lines = np.concatenate([numbers[ends] for _, numbers in pieces])
    return lines, np.full(len(lines), "U")


def _with_letters(mesh: Mesh, points: np.ndarray) -> Mesh:
    """Mesh whose creases are mountains and valleys as in the stowed state."""
    angles = fold_angles(mesh, points)
    letters = np.where(angles > 0, "V", "M")
    return replace(mesh, edge_assignments=np.where(mesh.edge_kinds == CREASE, letters, mesh.edge_assignments))
