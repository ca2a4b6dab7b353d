"""The leaf-in square of the paper (section 5): nested squares, diagonals and medians, stowed as four arms.

The text of the paper names no coordinates. They follow from four-fold mirror symmetry, three layers in each eighth of
the sheet, 48 triangles and a stress-free stowed state: ring corners P_k = (a_k, a_k) and ring middles Q_k = (a_k, 0)
with a_k = k side / 6, trapezoids cut by the creases Q_k-P_{k+1}. With these points alone the stowed state is an X of
coinciding layers. Ring middles 1 and 2 are therefore moved inwards by `inset`, which opens the layers; the stowed state
then is the shape whose edges all have their flat lengths:

    |x_i - x_j|^2 = |X_i - X_j|^2   on the 11 edges of one eighth,

for its 11 unknowns: radius and height of P_1, P_2 in the plane of the diagonal and of Q_1, Q_2, Q_3 in that of the
median, and the height of the centre. The distance of the corner P_3 from the axis is given, its height is 0.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from ...errors import InputError
from ..fold_angles import fold_angles
from ..mesh import CREASE, Mesh, build_mesh
from ..pattern import Pattern

# Points of one eighth: the centre, ring corners, ring middles, and the middle of O-P_1.
CENTRE, P1, P2, P3, Q1, Q2, Q3, MIDDLE = range(8)
TRIANGLES = np.array([(CENTRE, Q1, MIDDLE), (MIDDLE, Q1, P1), (Q1, Q2, P2), (Q1, P2, P1), (Q2, Q3, P3), (Q2, P3, P2)])
LENGTHS = np.array(
    [
        (CENTRE, P1),
        (CENTRE, Q1),
        (Q1, P1),
        (P1, P2),
        (Q1, Q2),
        (Q2, P2),
        (Q1, P2),
        (P2, P3),
        (Q2, Q3),
        (Q3, P3),
        (Q2, P3),
    ]
)
UNKNOWN_COUNT = 11
DIAGONAL = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0])

# In sides of the square.
DEFAULT_INSET = 0.005 / 0.6
DEFAULT_CORNER_DISTANCE = 0.312 / 0.6
CONTINUATION_STEP = 0.004

# The X of four vertical arms, corners at height 0: (radius, height) of P_1, P_2, Q_1, Q_2, Q_3, then height of O.
FOUR_ARMS = np.array([1, 0, 2, -1, 0, 0, 0, -1, 0, 0, -1]) / 6.0


def leaf_in(side: float = 0.6, inset: float | None = None, corner_distance: float | None = None) -> Pattern:
    """Leaf-in square of 48 triangles, centred at the origin, sides along x and y.

    Args:
        side: m.
        inset: how far ring middles 1 and 2 lie inside the squares of their rings, m; 0.005 / 0.6 side by default.
        corner_distance: distance of the stowed corners from the axis, m; 0.312 / 0.6 side by default, where the layers
            are widest apart for the default inset; below about 0.508 side they cross. Deployed it is side / sqrt(2).
            On the way there the panels of the smaller insets cross unless contact keeps them apart.

    Raises:
        InputError: a side that is not positive; an inset or a distance without such a stowed state.
    """
    if not (np.isfinite(side) and side > 0):
        raise InputError("pattern.side", side, "a length above 0 (m)")
    inset = DEFAULT_INSET if inset is None else inset / side
    corner = DEFAULT_CORNER_DISTANCE if corner_distance is None else corner_distance / side
    if not 0 <= inset < 1 / 6:
        raise InputError("pattern.inset", inset * side, f"a length from 0 to below a sixth of the side {side} (m)")
    if not 0.5 < corner < np.sqrt(0.5):
        raise InputError(
            "pattern.corner_distance", corner * side, f"between side / 2 and side / sqrt(2), side {side} m"
        )

    flat = _flat_eighth(inset)
    stowed = _stowed_eighth(flat, corner)
    vertices, triangles, pieces = _mirror(flat)
    points = np.empty((len(vertices), 3))
    for turn, numbers in pieces:
        points[numbers] = stowed @ turn.T
    mesh = build_mesh(side * vertices, triangles, *_creases(pieces))
    points *= side
    return Pattern(_with_letters(mesh, points), points, np.arange(len(triangles)), np.zeros((0, 3), dtype=int))


def _flat_eighth(inset: float) -> np.ndarray:
    """(8, 3) flat positions of the points of the eighth between the median y = 0 and the diagonal, in sides."""
    ring = np.array([1, 2, 3]) / 6.0
    middles = ring - np.array([inset, inset, 0.0])
    flat = np.zeros((8, 3))
    flat[[P1, P2, P3], :2] = ring[:, None]
    flat[[Q1, Q2, Q3], 0] = middles
    flat[MIDDLE] = 0.5 * flat[P1]
    return flat


def _stowed_eighth(flat: np.ndarray, corner: float) -> np.ndarray:
    """(8, 3) stowed positions of the eighth, in sides: continuation from the four arms in the corner distance."""
    i, j = LENGTHS.T
    square = np.sum((flat[i] - flat[j]) ** 2, axis=1)

    def mismatch(unknowns, corner):
        points = _place(unknowns, corner)
        return np.sum((points[i] - points[j]) ** 2, axis=1) / square - 1.0

    unit = np.array([_place(e, 0.0) for e in np.eye(UNKNOWN_COUNT)])  # positions are linear in the unknowns
    change = unit[:, i] - unit[:, j]  # (unknowns, edges, 3)

    def slope(unknowns, corner):
        points = _place(unknowns, corner)
        return 2.0 * np.einsum("uec,ec->eu", change, points[i] - points[j]) / square[:, None]

    unknowns = FOUR_ARMS
    steps = int(np.ceil(abs(corner - DEFAULT_CORNER_DISTANCE) / CONTINUATION_STEP))
    for distance in np.linspace(DEFAULT_CORNER_DISTANCE, corner, steps + 1) if steps else [corner]:
        unknowns = least_squares(mismatch, unknowns, slope, args=(distance,), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
        if np.abs(mismatch(unknowns, distance)).max() > 1e-12:
            raise InputError(
                "pattern.corner_distance",
                f"{corner} side with an inset of {flat[P1, 0] - flat[Q1, 0]:.6g} side",
                "a stowed state without strain; there is none on the path from the four arms",
            )
    return _place(unknowns, corner)


def _place(unknowns: np.ndarray, corner: float) -> np.ndarray:
    """(8, 3) positions: P_k in the plane of the diagonal, Q_k in that of the median y = 0, O on the axis."""
    points = np.zeros((8, 3))
    radius, height = unknowns[:10:2], unknowns[1:10:2]
    points[[P1, P2]] = radius[:2, None] * DIAGONAL
    points[P3] = corner * DIAGONAL
    points[[Q1, Q2, Q3], 0] = radius[2:]
    points[[P1, P2, Q1, Q2, Q3], 2] = height
    points[CENTRE, 2] = unknowns[10]
    points[MIDDLE] = 0.5 * (points[CENTRE] + points[P1])
    return points


def _mirror(flat: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """Flat vertices and triangles of all eighths, and for each its (3, 3) motion and the vertices of its 8 points."""
    vertices: list[np.ndarray] = []
    triangles, pieces = [], []
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for turns in range(4):
        for mirror in (1.0, -1.0):
            motion = np.linalg.matrix_power(quarter, turns) @ np.diag([1.0, mirror, 1.0])
            numbers = []
            for point in flat @ motion.T:
                same = [k for k, vertex in enumerate(vertices) if np.abs(vertex - point).max() < 1e-9]
                if not same:
                    vertices.append(point)
                numbers.append(same[0] if same else len(vertices) - 1)
            numbers = np.array(numbers)
            pieces.append((motion, numbers))
            triangles.append(numbers[TRIANGLES])
    return np.array(vertices)[:, :2], np.concatenate(triangles), pieces


def _creases(pieces) -> tuple[np.ndarray, np.ndarray]:
    """Lines and letters of all edges except MIDDLE-Q_1, as yet unassigned."""
    eighth = np.concatenate([LENGTHS[1:], [(CENTRE, MIDDLE), (MIDDLE, P1)]])  # MIDDLE lies on O-P1, the first
    lines = np.concatenate([numbers[eighth] for _, numbers in pieces])
    return lines, np.full(len(lines), "U")


def _with_letters(mesh: Mesh, points: np.ndarray) -> Mesh:
    """Mesh whose creases are mountains and valleys as in the stowed state."""
    angles = fold_angles(mesh, points)
    letters = np.where(angles > 0, "V", "M")
    return replace(mesh, edge_assignments=np.where(mesh.edge_kinds == CREASE, letters, mesh.edge_assignments))
