"""A square sheet from the eighth of it between the median y = 0 and the diagonal y = x, by its mirror planes."""

import numpy as np

from ..mesh import Mesh, build_mesh

SIGNS = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]


def mirrored(flat: np.ndarray, stowed: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the whole square from those of one eighth.

    Coordinates are only negated and exchanged, so that points on a mirror plane are found again bit by bit.

    Args:
        flat: (n, 2) places in the eighth, m; those on the diagonal have y = x, those on the median y = 0, exactly.
        stowed: (n, 3) their stowed positions, m.

    Returns:
        vertices (nv, 2), stowed positions (nv, 3) and the vertices (8, n) of the points in each eighth.
    """
    copies_flat, copies_stowed = [], []
    for x, y in SIGNS:
        for exchanged in (False, True):
            axes = [1, 0] if exchanged else [0, 1]
            copies_flat.append(flat[:, axes] * [x, y] + 0.0)  # 0 and -0 are one number
            copies_stowed.append(stowed[:, [*axes, 2]] * [x, y, 1.0] + 0.0)
    every = np.concatenate(copies_flat)
    _, first, inverse = np.unique(every, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in the order in which they come
    rank = np.empty(len(order), dtype=int)
    rank[order] = np.arange(len(order))
    numbers = rank[inverse.ravel()].reshape(8, len(flat))
    return every[first[order]], np.concatenate(copies_stowed)[first[order]], numbers


def ladder(lower: np.ndarray, upper: np.ndarray, first: int, second: int) -> list[tuple[int, int, int]]:
    """Triangles between two rows of points (n, 2) and (m, 2), n + m - 2 of them, whose rungs are the shorter ones.

    Args:
        first, second: numbers of the first point of each row.
    """
    i = j = 0
    triangles = []
    while i + 1 < len(lower) or j + 1 < len(upper):
        along_lower = j + 1 == len(upper) or (
            i + 1 < len(lower)
            and np.linalg.norm(lower[i + 1] - upper[j]) <= np.linalg.norm(upper[j + 1] - lower[i]) * (1.0 + 1e-9)
        )
        if along_lower:
            triangles.append((first + i, first + i + 1, second + j))
            i += 1
        else:
            triangles.append((first + i, second + j + 1, second + j))
            j += 1
    return triangles


def square_of_eighths(
    flat: np.ndarray,
    stowed: np.ndarray,
    triangles: list[tuple[int, int, int]],
    lines: list[tuple[int, int]],
    letters: list[str],
) -> tuple[Mesh, np.ndarray]:
    """Mesh of the whole square, and the (nv, 3) stowed positions of its vertices, m.

    Args:
        flat, stowed: see `mirrored`.
        triangles, lines: of the points of the eighth.
        letters: of each line, M or V.
    """
    vertices, positions, eighths = mirrored(flat, stowed)
    mesh = build_mesh(
        vertices,
        np.concatenate([eighth[np.array(triangles)] for eighth in eighths]),
        np.concatenate([eighth[np.array(lines)] for eighth in eighths]),
        np.tile(letters, 8),
    )
    return mesh, positions
