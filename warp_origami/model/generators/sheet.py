"""A rectangle of square cells, plain or folded like a fan along parallel creases."""

from typing import Literal

import numpy as np

from ...errors import InputError
from ..mesh import build_mesh
from ..pattern import Pattern


def sheet(
    width: float,
    height: float,
    nx: int = 1,
    ny: int = 1,
    origin: tuple[float, float] = (0.0, 0.0),
    diagonal: Literal["right", "alternate"] = "right",
    creases_x: tuple[int, ...] = (),
    creases_y: tuple[int, ...] = (),
    opening: float | None = None,
) -> Pattern:
    """Rectangle [0, width] x [0, height] from `origin`, in nx x ny cells of two triangles each.

    Args:
        width, height: sides, m.
        nx, ny: cells along x and y.
        origin: corner with the least x and y, m.
        diagonal: "right" draws every diagonal from lower left to upper right; "alternate" turns every second one.
        creases_x: grid lines x = i width / nx, 0 < i < nx, that are creases. Mountain and valley take turns.
        creases_y: the same for lines y = j height / ny.
        opening: angle between neighbouring panels of the stowed state, rad: pi is flat, 0 folded onto each other. The
            stowed sheet is a zigzag along x (creases_x) or y (creases_y) that starts at the origin, downwards at half
            the fold angle. None: no stowed state.

    Raises:
        InputError: a side or a number of cells that is not positive, a crease outside the sheet, an opening without
            creases or with creases both ways or outside (0, pi].
    """
    _check(width, height, nx, ny, diagonal, creases_x, creases_y, opening)
    x = np.linspace(0.0, width, nx + 1)
    y = np.linspace(0.0, height, ny + 1)
    grid = np.stack(np.meshgrid(x, y), axis=-1)  # (ny + 1, nx + 1, 2)
    number = np.arange((nx + 1) * (ny + 1)).reshape(ny + 1, nx + 1)

    lines, letters = [], []
    for columns, along in ((creases_x, number.T), (creases_y, number)):
        for rank, i in enumerate(sorted(columns)):
            lines.append(np.stack([along[i, :-1], along[i, 1:]], axis=1))
            letters.append(np.full(along.shape[1] - 1, "VM"[rank % 2]))
    mesh = build_mesh(
        grid.reshape(-1, 2) + np.asarray(origin, dtype=float),
        _triangles(number, diagonal),
        np.concatenate(lines) if lines else None,
        np.concatenate(letters) if letters else None,
    )
    stowed = None
    if opening is not None:
        stowed = np.concatenate([grid, np.zeros((ny + 1, nx + 1, 1))], axis=2)
        if creases_x:
            stowed[..., 0], stowed[..., 2] = _zigzag(x, sorted(creases_x), opening)
        else:
            along, up = _zigzag(y, sorted(creases_y), opening)
            stowed[..., 1], stowed[..., 2] = along[:, None], up[:, None]
        stowed = stowed.reshape(-1, 3) + np.array([*origin, 0.0])
    return Pattern(mesh, stowed, np.arange(len(mesh.triangles)), np.zeros((0, 3), dtype=int))


def _triangles(number: np.ndarray, diagonal: str) -> np.ndarray:
    """(2 nx ny, 3) triangles of the cells, row by row."""
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    right = np.stack([a, b, c, a, c, d], axis=1)
    if diagonal == "alternate":
        ny, nx = number.shape
        j, i = np.divmod(np.arange((nx - 1) * (ny - 1)), nx - 1)
        left = np.stack([a, b, d, b, c, d], axis=1)
        right = np.where(((i + j) % 2 == 1)[:, None], left, right)
    return right.reshape(-1, 3)


def _zigzag(line: np.ndarray, creases: list[int], opening: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances along and heights above the plane of the grid lines of a fan that starts downwards."""
    slope = 0.5 * (np.pi - opening)
    panel = np.searchsorted(creases, np.arange(len(line) - 1), side="right")
    step = np.diff(line)
    along = np.cumsum(step * np.cos(slope))
    up = np.cumsum(np.where(panel % 2 == 0, -1.0, 1.0) * step * np.sin(slope))
    return np.concatenate([[0.0], along]), np.concatenate([[0.0], up])


def _check(width, height, nx, ny, diagonal, creases_x, creases_y, opening) -> None:
    for key, value in (("width", width), ("height", height)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"pattern.{key}", value, "a length above 0 (m)")
    for key, value in (("nx", nx), ("ny", ny)):
        if value < 1:
            raise InputError(f"pattern.{key}", value, "at least 1 cell")
    if diagonal not in ("right", "alternate"):
        raise InputError("pattern.diagonal", repr(diagonal), '"right" or "alternate"')
    for key, creases, n in (("creases_x", creases_x, nx), ("creases_y", creases_y, ny)):
        if len(set(creases)) < len(creases) or any(not 0 < i < n for i in creases):
            raise InputError(f"pattern.{key}", list(creases), f"different grid lines between 0 and {n}, both excluded")
    if opening is None:
        return
    if not 0 < opening <= np.pi:
        raise InputError("pattern.opening", opening, "an angle above 0 and at most pi (rad)")
    if bool(creases_x) == bool(creases_y):
        raise InputError("pattern.opening", opening, "creases in one direction (creases_x or creases_y)")
