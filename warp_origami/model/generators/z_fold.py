"""The z-fold: a rectangle folded like an accordion, the simplest rigid folding with one degree of freedom.

Strips of width w = length / strips, at the angle theta = (pi - opening) / 2 to the plane x, y in turn downwards and
upwards: fold line i lies at x = i w cos(theta), z = 0 or -w sin(theta).
"""

from dataclasses import replace

import numpy as np

from ...errors import InputError
from ..layer_order import layer_orders
from ..pattern import Pattern
from .sheet import sheet

NEARLY = 0.02
"""Opening, rad, at which the order of the layers of the closed stack is looked at."""


def z_fold(
    length: float = 1.0, width: float = 0.2, strips: int = 8, columns: int | None = None, opening: float = 0.1
) -> Pattern:
    """Rectangle [0, length] x [0, width] with fold lines across x, valley and mountain in turn.

    Args:
        length: along x, across the fold lines, m.
        width: along the fold lines, m.
        strips: of equal width.
        columns: elements along a fold line; by default as many as make them about as long as a strip is wide.
        opening: angle between neighbouring strips of the stowed sheet, rad: pi is flat, 0 folded onto each other.

    Raises:
        InputError: a length or a number that is not positive, fewer than two strips, an opening outside [0, pi].
    """
    _check(length, width, strips, columns, opening)
    if columns is None:
        columns = max(1, round(width * strips / length))
    pattern = _fan(length, width, strips, columns, opening if opening > 0.0 else NEARLY)
    faces = pattern.mesh.faces.astype(int)
    if opening > 0.0:
        return replace(pattern, pattern_faces=faces)
    stowed = pattern.stowed.copy()
    line = np.round(pattern.mesh.vertices[:, 0] * strips / length).astype(int)
    stowed[:, 0] = 0.0
    stowed[:, 2] = -(line % 2) * length / strips
    return Pattern(pattern.mesh, stowed, faces, layer_orders(pattern.mesh, faces, stowed, pattern.stowed))


def _fan(length: float, width: float, strips: int, columns: int, opening: float) -> Pattern:
    creases = tuple(range(1, strips))
    return sheet(length, width, strips, columns, diagonal="alternate", creases_x=creases, opening=opening)


def _check(length, width, strips, columns, opening) -> None:
    for key, value in (("length", length), ("width", width)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"pattern.{key}", value, "a length above 0 (m)")
    if strips < 2:
        raise InputError("pattern.strips", strips, "at least 2 strips")
    if columns is not None and columns < 1:
        raise InputError("pattern.columns", columns, "at least 1")
    if not 0 <= opening <= np.pi:
        raise InputError("pattern.opening", opening, "an angle from 0 to pi (rad)")
