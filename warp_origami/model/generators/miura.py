"""The Miura sheet: parallelograms between straight and zigzag creases, one rigid folding with one degree of freedom.

Point (i, j) of the sheet folded by the angle theta of its panels to the plane x, y (Schenk and Guest 2013, eq. 1):

    x = i L + (j mod 2) V,   y = j S,   z = (i mod 2) H
    L = a w,  H = a sin(theta) sin(g),  S = b cos(theta) sin(g) / w,  V = b cos(g) / w,  w^2 = 1 - sin^2(theta) sin^2(g)

with the sides a, b of the parallelograms and the sector angle g between them; theta = 0 is flat.
"""

import numpy as np

from ...errors import InputError
from ..flat_foldability import check_flat_foldable
from ..layer_order import layer_orders
from ..mesh import build_mesh
from ..pattern import Pattern

NEARLY = 0.02
"""Opening, rad, at which the order of the layers of the folded sheet is looked at."""


def miura(nx: int, ny: int, a: float, b: float, sector_angle: float, opening: float | None = None) -> Pattern:
    """Miura sheet of nx x ny parallelograms of two triangles each, a corner at the origin.

    The straight creases run along x, nx sides a long; the zigzags run along y, ny sides b long, and the first side of
    each leans towards +x. Zigzags are mountains and valleys in turn, the sides of a straight crease too.

    Args:
        nx, ny: parallelograms along x and y.
        a: side along x, m.
        b: side of the zigzags, m.
        sector_angle: acute angle of the parallelograms, rad.
        opening: angle between the two panels at a zigzag crease of the stowed state, pi - 2 theta, rad: pi is flat, 0
            folded onto each other, with the order of the layers. None: no stowed state.

    Raises:
        InputError: a number of cells or a side that is not positive, a sector angle outside (0, pi/2), an opening
            outside [0, pi].
    """
    _check(nx, ny, a, b, sector_angle, opening)
    number = np.arange((nx + 1) * (ny + 1)).reshape(ny + 1, nx + 1)
    flat = _place(nx, ny, a, b, sector_angle, 0.0)
    lines, letters = _creases(number)
    mesh = build_mesh(flat[:, :2], _triangles(number), lines, letters)
    stowed = None if opening is None else _place(nx, ny, a, b, sector_angle, 0.5 * (np.pi - opening))
    check_flat_foldable(mesh, "pattern.sector_angle", sector_angle)
    faces, orders = np.repeat(np.arange(nx * ny), 2), np.zeros((0, 3), dtype=int)
    if opening == 0.0:
        nearly = _place(nx, ny, a, b, sector_angle, 0.5 * (np.pi - NEARLY))
        orders = layer_orders(mesh, faces, stowed, nearly)
    return Pattern(mesh, stowed, faces, orders)


def _place(nx: int, ny: int, a: float, b: float, sector_angle: float, theta: float) -> np.ndarray:
    """((nx + 1) (ny + 1), 3) points, row by row; theta: rad, of the panels to the plane x, y."""
    j, i = np.divmod(np.arange((nx + 1) * (ny + 1)), nx + 1)
    high = np.sin(theta) * np.sin(sector_angle)
    w = np.sqrt(1.0 - high**2)
    along, shift, across = a * w, b * np.cos(sector_angle) / w, b * np.cos(theta) * np.sin(sector_angle) / w
    return np.stack([i * along + (j % 2) * shift, j * across, (i % 2) * a * high], axis=1)


def _triangles(number: np.ndarray) -> np.ndarray:
    """(2 nx ny, 3) triangles: each parallelogram divided along its shorter diagonal, between the obtuse corners."""
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    leans = np.repeat(np.arange(len(number) - 1) % 2 == 0, number.shape[1] - 1)  # upper side shifted towards +x
    one = np.where(leans, [a, b, d], [a, b, c])
    two = np.where(leans, [b, c, d], [a, c, d])
    return np.stack([one, two], axis=0).transpose(2, 0, 1).reshape(-1, 3)


def _creases(number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, 2) ends and (k,) letters of the creases: zigzags, high ones mountains, then straight lines."""
    rows, columns = number.shape
    zigzags = np.stack([number[:-1, 1:-1], number[1:, 1:-1]], axis=-1).reshape(-1, 2)
    straights = np.stack([number[1:-1, :-1], number[1:-1, 1:]], axis=-1).reshape(-1, 2)
    i = np.tile(np.arange(1, columns - 1), rows - 1)
    j, k = np.divmod(np.arange((rows - 2) * (columns - 1)), columns - 1)
    letters = [np.where(i % 2 == 1, "M", "V"), np.where((j + 1 + k) % 2 == 0, "M", "V")]
    return np.concatenate([zigzags, straights]), np.concatenate(letters)


def _check(nx, ny, a, b, sector_angle, opening) -> None:
    for key, value in (("nx", nx), ("ny", ny)):
        if value < 1:
            raise InputError(f"pattern.{key}", value, "at least 1 parallelogram")
    for key, value in (("a", a), ("b", b)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"pattern.{key}", value, "a length above 0 (m)")
    if not 0 < sector_angle < 0.5 * np.pi:
        raise InputError("pattern.sector_angle", sector_angle, "an angle above 0 and below pi/2 (rad)")
    if opening is not None and not 0 <= opening <= np.pi:
        raise InputError("pattern.opening", opening, "an angle from 0 to pi (rad)")
