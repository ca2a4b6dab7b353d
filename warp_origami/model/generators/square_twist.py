"""The square twist, and tessellations of it: squares that turn while pleats between them close.

From each corner A_i of a square of side s two pleat lines lead to the edges of the cell, parallel to x or y; the two
lines of pleat i begin at A_i and A_(i+1) and make the angle alpha with the side between them, so that pleats are
w = s sin(alpha) wide and every corner has the sectors alpha, pi/2, pi - alpha, pi/2 (flat-foldable: Kawasaki).
Neighbouring cells are mirror images, whose pleats go on in each other.

At a corner whose two sides are both mountain (or valley) the half-angles of the folds obey

    tan(side_i / 2) = tan(side_(i-1) / 2) / p,     p = tan(pi/4 - alpha/2),

with p instead of 1/p where one is mountain and one valley

(Evans, Lang, Magleby and Howell, Rigidly foldable origami twists, Origami 6, 2015). Once around the square this closes
for the sides M M V V ("rigid"), which fold rigidly with one degree of freedom; for M M M M ("classic") it gives p^-4:
between flat and folded flat there is strain.
"""

from typing import Literal

import numpy as np

from ...errors import InputError
from ..flat_foldability import check_flat_foldable
from ..layer_order import layer_orders
from ..mesh import Mesh, build_mesh
from ..pattern import Pattern
from ..rigid_fold import fold_rigidly

LAYERS = [(0, 1 + 2 * i) for i in range(4)] + [(0, 2 + 2 * i) for i in range(4)]
for _i in range(4):
    _pleat, _next, _corner, _second = 1 + 2 * _i, 1 + 2 * ((_i + 1) % 4), 2 + 2 * _i, 2 + 2 * ((_i + 2) % 4)
    LAYERS += [(_corner, _pleat), (_pleat, 2 + 2 * ((_i + 3) % 4)), (_next, _pleat), (_pleat, _second)]
    LAYERS += [(2 + 2 * ((_i + 1) % 4), _corner)]
"""Upper and lower face wherever two lie on each other in the classic twist: 0 the square, 1 + 2 i pleat i, 2 + 2 i the
corner after it. Pleats and corners lie on each other like the flaps of a box, each on the last one."""

SIDES = {"rigid": "MMVV", "classic": "MMMM"}
"""Letters of the sides of the squares."""

NEARLY = 0.05
"""Opening, rad, at which the order of the layers of the folded sheet is looked at."""

# Points of a cell: corners of the square 0-3, ends of the two lines of pleat i 4 + 2 i and 5 + 2 i, corners 12-15.
TRIANGLES = [(0, 1, 2), (0, 2, 3)]
for _i in range(4):
    _a, _b, _e, _f = _i, (_i + 1) % 4, 4 + 2 * _i, 5 + 2 * _i
    TRIANGLES += [(_a, _e, _b), (_e, _f, _b), (_b, _f, 12 + _i), (_b, 12 + _i, 4 + 2 * ((_i + 1) % 4))]


def square_twist(
    nx: int = 1,
    ny: int = 1,
    cell: float = 0.3,
    twist: float = 0.1,
    angle: float = 0.25 * np.pi,
    assignment: Literal["rigid", "classic"] = "rigid",
    opening: float | None = None,
) -> Pattern:
    """Sheet of nx x ny square twists, a corner at the origin.

    Args:
        nx, ny: cells along x and y.
        cell: side of a cell, m.
        twist: side of the squares that turn, m.
        angle: between the sides of these squares and their pleats, rad, below pi/2: squares turn by twice as much
            when folded flat.
        assignment: mountains and valleys of the sides of the squares: "rigid" M M V V, "classic" M M M M.
        opening: angle between the two faces at the most closed creases of the stowed state, rad: pi is flat, 0 folded
            flat. "rigid": any from 0 to pi, 0.3 by default; "classic": 0, which is the default.

    Raises:
        InputError: a number or a length that is not positive, an angle outside (0, pi/2), pleats that do not fit into
            the cell, an opening that the assignment does not have.
    """
    _check(nx, ny, cell, twist, angle, assignment, opening)
    if opening is None:
        opening = 0.0 if assignment == "classic" else 0.3
    letters, half_angles = _folds(angle, SIDES[assignment])
    mesh, folds = _tile(nx, ny, _cell(cell, twist, angle), cell, letters, half_angles)
    check_flat_foldable(mesh, "pattern.angle", angle)
    faces = mesh.faces.astype(int)
    stowed = _folded(mesh, folds, opening)
    orders = np.zeros((0, 3), dtype=int)
    if opening == 0.0 and assignment == "rigid":
        orders = layer_orders(mesh, faces, stowed, _folded(mesh, folds, NEARLY))
    elif opening == 0.0:
        orders = _box_orders(faces.reshape(nx * ny, len(TRIANGLES)))
    return Pattern(mesh, stowed, faces, orders)


def _cell(cell: float, twist: float, angle: float) -> np.ndarray:
    """(16, 2) points of the first cell, m."""
    turn = angle - 0.5 * np.pi
    corner = 0.5 * twist * np.array([np.cos(turn) + np.sin(turn), np.sin(turn) - np.cos(turn)])
    points = np.zeros((16, 2))
    for i in range(4):
        points[i] = corner
        corner = np.array([-corner[1], corner[0]])
    half = 0.5 * cell
    for i in range(4):
        axis, sense = i % 2, 1.0 if i < 2 else -1.0
        for k in (0, 1):
            points[4 + 2 * i + k] = points[(i + k) % 4]
            points[4 + 2 * i + k, axis] = sense * half
        points[12 + i] = half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]][i])
    return points


def _folds(angle: float, sides: str) -> tuple[dict[tuple[int, int], str], dict[tuple[int, int], float]]:
    """Letter of each crease of the cell, and tan of half its fold angle over the largest one."""
    p = np.tan(0.25 * np.pi - 0.5 * angle)
    tangents = [1.0]
    for i in range(1, 4):
        tangents.append(tangents[-1] * (1.0 / p if sides[i] == sides[i - 1] else p))
    letters, values = {}, {}
    for i in range(4):
        ends, other = (i, (i + 1) % 4), "MV"[sides[i] == "M"]
        letters[ends], values[ends] = sides[i], tangents[i]
        for k, letter, value in ((0, other, tangents[i - 1]), (1, sides[i], tangents[(i + 1) % 4])):
            line = (ends[k], 4 + 2 * i + k)
            letters[line], values[line] = letter, value
    largest = max(values.values())
    return letters, {line: value / largest for line, value in values.items()}


def _tile(nx, ny, points, cell, letters, half_angles) -> tuple[Mesh, np.ndarray]:
    """Mesh of all cells, and tan of half the fold angle of each edge over the largest one, with its sign."""
    number: dict[tuple[int, int], int] = {}
    vertices, triangles, lines, kinds, values = [], [], [], [], []
    for j in range(ny):
        for i in range(nx):
            mirror = np.array([-1.0 if i % 2 else 1.0, -1.0 if j % 2 else 1.0])
            own = []
            for x, y in points * mirror / cell + 0.5 + np.array([i, j]):
                key = round(x * 1e9), round(y * 1e9)
                if key not in number:
                    number[key] = len(vertices)
                    vertices.append((cell * x, cell * y))
                own.append(number[key])
            triangles += [[own[v] for v in triangle] for triangle in TRIANGLES]
            for line, letter in letters.items():
                lines.append([own[v] for v in line])
                kinds.append(letter)
                values.append(half_angles[line] * (1.0 if letter == "V" else -1.0))
    mesh = build_mesh(np.array(vertices), np.array(triangles), np.array(lines), np.array(kinds))
    of = {tuple(sorted(line)): value for line, value in zip(lines, values, strict=True)}
    return mesh, np.array([of.get(tuple(sorted(edge)), 0.0) for edge in mesh.edges.tolist()])


def _box_orders(faces: np.ndarray) -> np.ndarray:
    """(k, 3) face orders of classic twists; faces: (cells, 18) face of each triangle of the cells."""
    rows = set()
    for own in faces[:, ::2].tolist():  # of the first triangle of each of the cell's faces
        for upper, lower in LAYERS:
            rows.add((own[upper], own[lower], -1 if lower % 2 else 1))  # pleats are turned over
    return np.array(sorted(rows))


def _folded(mesh: Mesh, folds: np.ndarray, opening: float) -> np.ndarray:
    """(nv, 3) positions, m."""
    if opening == 0.0:
        angles = np.pi * np.sign(folds)
    else:
        angles = 2.0 * np.arctan(folds * np.tan(0.5 * (np.pi - opening)))
    return fold_rigidly(mesh, angles)[0]


def _check(nx, ny, cell, twist, angle, assignment, opening) -> None:
    for key, value in (("nx", nx), ("ny", ny)):
        if value < 1:
            raise InputError(f"pattern.{key}", value, "at least 1 cell")
    for key, value in (("cell", cell), ("twist", twist)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"pattern.{key}", value, "a length above 0 (m)")
    if not 0 < angle < 0.5 * np.pi:
        raise InputError("pattern.angle", angle, "an angle above 0 and below pi/2 (rad)")
    if assignment not in SIDES:
        raise InputError("pattern.assignment", repr(assignment), '"rigid" or "classic"')
    widest = cell / (np.sin(angle) + np.abs(_cell(1.0, 1.0, angle)[:4]).max() * 2.0)
    if twist > widest:
        raise InputError("pattern.twist", twist, f"at most {widest:.6g} m: pleats as wide as twist sin(angle) overlap")
    if opening is not None and assignment == "classic" and opening != 0.0:
        raise InputError("pattern.opening", opening, '0 for "classic", which does not fold rigidly')
    if opening is not None and not 0 <= opening <= np.pi:
        raise InputError("pattern.opening", opening, "an angle from 0 to pi (rad)")
