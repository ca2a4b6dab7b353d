"""The leaf-out square: four leaves that fold outwards, with one rigid folding from flat to a slender bundle.

Each quarter of the sheet is a leaf with its base in the centre: from the midrib (the diagonal) veins lead outwards,
parallel to the sides; the medians are folded too (De Focatiis and Guest, Deployable membranes designed from folding
tree leaves, Phil. Trans. R. Soc. A 360, 2002). The strips between veins are plane and stay parallel to the median of
their side, which rises by the angle eta in its plane y = 0:

    median along e = (cos eta, 0, sin eta),   vein k: P_k + s e,   P_(k+1) - P_k = sqrt(2) (p_(k+1) - p_k) d

P_k = (p_k, p_k) on the diagonal, whose unit vectors d stay in the plane x = y at 45 degrees to e. There are two such
vectors, which take turns: with (u, z) in that plane, at the angles zeta + delta and zeta - delta,

    tan zeta = sqrt(2) tan eta,   cos delta = 1 / sqrt(1 + sin^2 eta).

eta = 0 is flat; at eta = pi/2 all strips lie on each other in the planes of the diagonals.
"""

import itertools

import numpy as np
from scipy.optimize import brentq

from ...errors import InputError
from ..layer_order import layer_orders
from ..pattern import Pattern
from .eighths import ladder, square_of_eighths

NEARLY = 0.02
"""Opening, rad, at which the order of the layers of the closed bundle is looked at."""


def leaf_out(side: float = 0.6, strips: int = 3, opening: float = 0.2, columns: int = 1) -> Pattern:
    """Leaf-out square centred at the origin, sides along x and y.

    Args:
        side: of the square, m.
        strips: of each half of a side, from the median to the diagonal.
        opening: angle between neighbouring strips of the stowed sheet, rad: pi is flat, 0 folded onto each other.
        columns: elements along the longest vein; shorter ones have fewer, as long ones.

    Raises:
        InputError: a side or a number that is not positive, an opening outside [0, pi].
    """
    _check(side, strips, opening, columns)
    rows = [_vein(k, strips, columns) for k in range(strips + 1)]
    rows = [0.5 * side * row for row in rows]
    mesh, stowed = _build(rows, _rise(opening))
    orders = np.zeros((0, 3), dtype=int)
    if opening == 0.0:
        orders = layer_orders(mesh, mesh.faces, stowed, _build(rows, _rise(NEARLY))[1])
    return Pattern(mesh, stowed, mesh.faces.astype(int), orders)


def _vein(k: int, strips: int, columns: int) -> np.ndarray:
    """(n, 2) points of vein k from the diagonal to the side, in half sides; vein 0 is the median."""
    p = k / strips
    pieces = max(1, round(columns * (1.0 - p))) if k < strips else 0
    return np.stack([np.linspace(p, 1.0, pieces + 1), np.full(pieces + 1, p)], axis=1)


def _build(rows: list[np.ndarray], rise: float):
    """Mesh and stowed positions of the square."""
    along = np.array([np.cos(rise), 0.0, np.sin(rise)])
    zeta = np.arctan2(np.sqrt(2.0) * np.sin(rise), np.cos(rise))
    delta = np.arccos(min(1.0, 1.0 / np.sqrt(1.0 + np.sin(rise) ** 2)))
    numbers, count = [], 0
    stowed, tip = [], np.zeros(3)
    triangles, lines, letters = [], [], []
    for k, row in enumerate(rows):
        if k > 0:
            angle = zeta - delta if k % 2 else zeta + delta
            step = np.sqrt(2.0) * (row[0, 0] - rows[k - 1][0, 0])
            out = np.cos(angle) / np.sqrt(2.0)
            tip = tip + step * np.array([out, out, np.sin(angle)])
        stowed.append(tip + (row[:, :1] - row[0, 0]) * along)
        numbers.append(np.arange(count, count + len(row)))
        count += len(row)
    flat, positions = np.concatenate(rows), np.concatenate(stowed)
    for k, (low, high) in enumerate(itertools.pairwise(numbers)):
        triangles += ladder(flat[low], flat[high], int(low[0]), int(high[0]))
        veins = list(itertools.pairwise(low))
        lines += [*veins, (low[0], high[0])]
        letters += ["MV"[k % 2]] * len(veins) + ["VM"[k % 2]]
    return square_of_eighths(flat, positions, triangles, lines, letters)


def _rise(opening: float) -> float:
    """eta, rad, at which neighbouring strips are at this angle."""
    if opening >= np.pi:
        return 0.0
    if opening <= 0.0:
        return 0.5 * np.pi
    return brentq(lambda rise: _angle(rise) - opening, 1e-12, 0.5 * np.pi - 1e-15, xtol=1e-15)


def _angle(rise: float) -> float:
    """Angle between neighbouring strips, rad."""
    along = np.array([np.cos(rise), 0.0, np.sin(rise)])
    zeta = np.arctan2(np.sqrt(2.0) * np.sin(rise), np.cos(rise))
    delta = np.arccos(1.0 / np.sqrt(1.0 + np.sin(rise) ** 2))
    across = []
    for angle, sense in ((zeta - delta, -1.0), (zeta + delta, 1.0)):
        out = np.cos(angle) / np.sqrt(2.0)
        step = np.array([out, out, np.sin(angle)])
        across.append(sense * (step - step @ along * along))
    return float(np.arctan2(np.linalg.norm(np.cross(*across)), across[0] @ across[1]))


def _check(side, strips, opening, columns) -> None:
    if not (np.isfinite(side) and side > 0):
        raise InputError("pattern.side", side, "a length above 0 (m)")
    for key, value in (("strips", strips), ("columns", columns)):
        if value < 1:
            raise InputError(f"pattern.{key}", value, "at least 1")
    if not 0 <= opening <= np.pi:
        raise InputError("pattern.opening", opening, "an angle from 0 to pi (rad)")
