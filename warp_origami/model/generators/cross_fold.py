"""A square sail of four petals, each folded into a z-pattern of strips: stowed, it is a cross of four arms.

The petals meet along the diagonals. Fold lines run along the sides of the square, mountain and valley in turn. Where a
hub of side b stands in the middle, two more (y = b/2 and y = -b/2 in the petal around +x) lead from its corners to the
side, else one, the median. Between them the strips lie along the side of the hub; the halves of two neighbouring petals
beyond them form an arm along the diagonal.

Strips that stayed parallel to the sides could be stowed in one way only, without any distance between layers. The fold
lines of the halves are therefore inclined by the angle t, and with them the sheet has a second state without strain:
with s = side / 2, from the line k through P_k = (a_k, a_k) on the diagonal to R_k = (m_k, b/2) on the fold line

    flat:    m_k = a_k - (a_k - b/2) tan t,                 line along (sin t, cos t)
    stowed:  R_k = (q_k, b/2, 0 or H),  line along (sin f, cos f, 0),  f = pi/4 - t,
             q_k = b/2 + (a_k - b/2) sqrt(2) tan t

Both keep the lengths of the strips if sin f (cos f - sin f) = sin t (cos t - sin t), which has these two solutions, and
the angle between neighbouring strips (the opening) follows from the step of q_k over that of m_k:

    sin(opening / 2) = sqrt(2) tan t / (1 - tan t)

There is no rigid folding between the two states; the strain on the way is that of a bistable structure.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ..layer_order import layer_orders
from ..mesh import Mesh
from ..pattern import Pattern
from .eighths import ladder, square_of_eighths

SLIT = 0.02
"""How far the edges of slits lie inside their panels, over its width: they must not touch each other."""

NEARLY = 0.02
"""Opening, rad, at which the order of the layers of the closed pack is looked at."""


def cross_fold(
    side: float = 14.0,
    hub: float = 1.2,
    strips: int = 10,
    opening: float = 0.1,
    columns: int | None = None,
    slits: float = 0.0,
) -> Pattern:
    """Square sail centred at the origin, sides along x and y; its corners carry the tip masses.

    Args:
        side: of the square, m.
        hub: side of the square opening around the hub, m, along which the stowed sail lies as the flat one does; 0:
            none, the petals meet in the centre.
        strips: of each petal, from the hub to the side.
        opening: angle between neighbouring strips of the stowed sail, rad; 0: all layers of a strip coincide, above 0
            the fold lines of the flat sail are inclined to its sides by about opening / 2.8.
        columns: element sides along half a side of the sail; by default as many as make elements about as long as the
            strips are wide.
        slits: share of the diagonals that is open, in the middle of each strip: bridges across the fold lines join the
            petals. 0: joined all along.

    Raises:
        InputError: a length that is not positive, a hub as wide as the sail, fewer than two strips, an opening outside
            [0, pi/2], slits outside [0, 1).
    """
    _check(side, hub, strips, opening, columns, slits)
    mesh, stowed = _sail(side, hub, strips, opening, columns, slits)
    faces, orders = mesh.faces.astype(int), np.zeros((0, 3), dtype=int)
    if opening == 0.0:
        orders = layer_orders(mesh, faces, stowed, _sail(side, hub, strips, NEARLY, columns, slits)[1])
    return Pattern(mesh, stowed, faces, orders)


def _sail(side, hub, strips, opening, columns, slits) -> tuple[Mesh, np.ndarray]:
    """Mesh and the (nv, 3) stowed positions of its vertices, m."""
    rows = _rows(0.5 * side, 0.5 * hub, strips, opening, columns)
    numbers, count = [], 0
    for row in rows:
        numbers.append(np.arange(count, count + len(row.flat)))
        count += len(row.flat)
    flat, stowed = (np.concatenate([getattr(row, key) for row in rows]) for key in ("flat", "stowed"))
    triangles, lines, letters = [], [], []
    for k in range(strips):
        (i, j), (low, high) = (rows[k].joint, rows[k + 1].joint), numbers[k : k + 2]
        for one, two in ((low[: i + 1], high[: j + 1]), (low[i:], high[j:])):
            triangles += ladder(flat[one], flat[two], int(one[0]), int(two[0]))
        around = list(itertools.pairwise(low)) if k > 0 else []
        lines += [(low[i], high[j]), *around]
        letters += ["MV"[k % 2]] + ["VM"[k % 2]] * len(around)
        diagonal = [int(low[-1]), int(high[-1])]
        if slits > 0.0:
            diagonal[1:1] = list(range(len(flat), len(flat) + 3))
            triangles, apex = _divided(triangles, diagonal)
            flat, stowed = (np.concatenate([x, _slit(x[low[-1]], x[high[-1]], x[apex], slits)]) for x in (flat, stowed))
            flat[[-3, -1], 1] = flat[[-3, -1], 0]  # on the diagonal to the last bit
        bridges = list(itertools.pairwise(diagonal))
        bridges = bridges if slits == 0.0 else [bridges[0], bridges[-1]]
        lines += bridges
        letters += ["VM"[k % 2]] * len(bridges)
    return square_of_eighths(flat, stowed, triangles, lines, letters)


def _divided(triangles: list[tuple[int, int, int]], points: list[int]) -> tuple[list[tuple[int, int, int]], int]:
    """Triangles of which the one with the ends of `points` as a side gets the points between as vertices, and its third
    corner."""
    ends = {points[0], points[-1]}
    (whole,) = [t for t in triangles if ends < set(t)]
    apex = (set(whole) - ends).pop()
    return [t for t in triangles if t != whole] + [(a, b, apex) for a, b in itertools.pairwise(points)], apex


def _slit(a: np.ndarray, b: np.ndarray, apex: np.ndarray, share: float) -> np.ndarray:
    """(3, d) ends of a slit on the side a-b of a panel, and its middle, a little inside the panel."""
    middle = 0.5 * (a + b)
    half = 0.5 * share * (b - a)
    return np.array([middle - half, middle + SLIT * (apex - middle), middle + half])


@dataclass(frozen=True)
class _Row:
    """Points of a fold line in the eighth, from the median to the diagonal.

    Attributes:
        flat: (n, 2) places, m.
        stowed: (n, 3) positions, m.
        joint: which of them lies on the fold line y = b/2.
    """

    flat: np.ndarray
    stowed: np.ndarray
    joint: int


def _rows(half: float, b: float, strips: int, opening: float, columns: int | None) -> list[_Row]:
    """Fold lines 0 (around the hub) to `strips` (the side of the sail); half: of the side, b: of the hub's, m."""
    sine = np.sin(0.5 * opening)
    tangent = sine / (np.sqrt(2.0) + sine)
    t = np.arctan(tangent)
    width = (half - b) / strips
    across, along = width * (1.0 - tangent), width * np.sqrt(2.0) * tangent  # steps of m_k and q_k
    height = across * np.cos(0.5 * opening)
    size = half / columns if columns is not None else width
    inner = np.linspace(0.0, b, max(1, round(b / size)) + 1)[:-1] if b > 0.0 else np.zeros(0)
    rows = []
    for k in range(strips + 1):
        a = half if k == strips else b + k * width  # to the last bit, where the mirror planes are looked for
        arm = (a - b) / np.cos(t)
        flat = np.array([a - (a - b) * tangent, b])
        stowed = np.array([b + k * along, b, (k % 2) * height])
        end = b + arm * np.cos(0.25 * np.pi - t)
        tip = np.array([end, end, stowed[2]])
        if k == strips:  # the outermost strip ends at the side, not on an inclined line
            more = (a - flat[0]) / across
            flat[0] = a
            stowed += more * np.array([along, 0.0, (-1.0) ** (k + 1) * height])
        share = np.linspace(0.0, 1.0, max(1, round(arm / size)) + 1)[:, None] if k > 0 else np.zeros((1, 1))
        outer_flat = flat + share * (np.array([a, a]) - flat)
        outer_flat[-1] = a
        rows.append(
            _Row(
                np.concatenate([np.stack([np.full(len(inner), flat[0]), inner], axis=1), outer_flat]),
                np.concatenate(
                    [stowed * [1.0, 0.0, 1.0] + inner[:, None] * [0.0, 1.0, 0.0], stowed + share * (tip - stowed)]
                ),
                len(inner),
            )
        )
    return rows


def _check(side, hub, strips, opening, columns, slits) -> None:
    if not (np.isfinite(side) and side > 0):
        raise InputError("pattern.side", side, "a length above 0 (m)")
    if not 0 <= hub < side:
        raise InputError("pattern.hub", hub, f"a length from 0 to below the side {side} (m)")
    if strips < 2:
        raise InputError("pattern.strips", strips, "at least 2 strips")
    if not 0 <= opening <= 0.5 * np.pi:
        raise InputError("pattern.opening", opening, "an angle from 0 to pi/2 (rad)")
    if columns is not None and columns < 1:
        raise InputError("pattern.columns", columns, "at least 1")
    if not 0 <= slits < 1:
        raise InputError("pattern.slits", slits, "a share from 0 to below 1")
