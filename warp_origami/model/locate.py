"""Which elements a point of the flat sheet lies in."""

import numpy as np

from warp_origami.errors import InputError

from .mesh import Mesh

SNAP = 1e-6
"""m, how far outside of the sheet a point may lie and still be taken to be on it."""


def area_coordinates(mesh: Mesh, elements: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n, 3) area coordinates (3) of flat points (n, 2) in elements (n,)."""
    a, b, c = (mesh.vertices[mesh.triangles[elements, k]] for k in range(3))
    total = _cross(b - a, c - a)
    first = _cross(b - points, c - points) / total
    second = _cross(c - points, a - points) / total
    return np.column_stack([first, second, 1.0 - first - second])


def locate(mesh: Mesh, point: np.ndarray, key: str) -> tuple[np.ndarray, np.ndarray]:
    """All elements that touch the flat point, and its area coordinates in each; a point just outside snaps to them.

    Raises:
        InputError: the point is farther than SNAP from the sheet; `key` names it.
    """
    everything = np.arange(len(mesh.triangles))
    areas = area_coordinates(mesh, everything, np.broadcast_to(point, (len(everything), 2)))
    clipped = np.clip(areas, 0.0, None)
    clipped /= clipped.sum(axis=1, keepdims=True)
    nearest = np.einsum("ek,ekx->ex", clipped, mesh.vertices[mesh.triangles])
    distance = np.linalg.norm(nearest - point, axis=1)
    hits = np.flatnonzero(distance <= SNAP)
    if len(hits) == 0:
        raise InputError(
            key,
            f"{np.asarray(point).tolist()}, off the sheet by {_off(mesh, point):.3g} m",
            "a point of the flat sheet",
        )
    return hits, clipped[hits]


def _off(mesh: Mesh, point: np.ndarray) -> float:
    a, b = (mesh.vertices[mesh.edges[:, k]] for k in range(2))
    along = np.clip(np.sum((point - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1), 0.0, 1.0)
    return float(np.min(np.linalg.norm(a + along[:, None] * (b - a) - point, axis=1)))


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
