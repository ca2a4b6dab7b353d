"""On which side of a layer a point lies: decided at accepted states only.

The sheet has two sides. The sign of a gap comes from the side on which the point was when it was still apart, and is
kept while it is closer than the thickness; taking it from the current normal would turn a penetration into an
attraction through the sheet.
"""

import numpy as np

from warp_origami.kernels.point_gap import FREE, UNKNOWN
from warp_origami.model.mesh import Mesh

from .narrow import NarrowPhase
from .points import ContactPoints


def sides_at(state: NarrowPhase, thickness: float, touching: float) -> np.ndarray:
    """Sides of the pairs state.reached at an accepted state.

    Inside a layer the side is kept while the point is closer than the contact `thickness` (m), on either side. Over the
    outer boundary the distance has no sign and a point may go round: there the side follows the height over the layer's
    plane, and is free near the plane. Points closer than `touching` (m) keep what they have.
    """
    at = state.reached
    sides, distance, height = state.sides.read()[at], state.distances.read()[at], state.heights.read()[at]
    sign = np.where(height < 0.0, -1, 1)
    separate = (np.abs(sides) != 1) | (sign == sides) | (np.abs(distance) >= thickness)
    inside = np.where(separate, sign, sides)
    over_boundary = np.where(np.abs(height) < 0.5 * state.thickness[at], FREE, sign)
    result = np.where(state.outer.read()[at], over_boundary, inside)
    kept = np.where(sides == UNKNOWN, FREE, sides)
    return np.where(np.abs(distance) <= touching, kept, result).astype(np.int32)


def ordered_sides(
    points: ContactPoints,
    slaves: np.ndarray,
    masters: np.ndarray,
    pattern_faces: np.ndarray,
    face_orders: np.ndarray,
    normals: np.ndarray,
) -> np.ndarray:
    """Sides (k,) of coincident pairs from FOLD faceOrders, FREE where they say nothing or both.

    Args:
        slaves: (k,) slave points.
        masters: (k,) element closest to each.
        pattern_faces: (ne,) face of the pattern of each element.
        face_orders: (m, 3) rows (f, g, s): f lies on the side s of g's normal.
        normals: (number of pattern faces, 3) normals in the start state.
    """
    first, second, side = np.asarray(face_orders, dtype=int).reshape(-1, 3).T
    # the same order seen from the other face: turned about if the normals agree
    turned = -side * np.sign(np.einsum("ij,ij->i", normals[first], normals[second])).astype(int)
    count = len(normals)
    keys = np.concatenate([first * count + second, second * count + first])
    keys, unique = np.unique(keys, return_index=True)
    values = np.concatenate([side, turned])[unique]

    sizes = points.owner_starts[slaves + 1] - points.owner_starts[slaves]
    pair = np.repeat(np.arange(len(slaves)), sizes)
    offset = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    own = pattern_faces[points.owner_elements[points.owner_starts[slaves][pair] + offset]]
    wanted = own * count + pattern_faces[masters[pair]]
    place = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    votes = np.where(keys[place] == wanted, values[place], 0) if len(keys) else np.zeros(len(wanted), dtype=int)
    return np.sign(np.bincount(pair, weights=votes, minlength=len(slaves))).astype(np.int32)


def pattern_normals(corners: np.ndarray, pattern_faces: np.ndarray) -> np.ndarray:
    """Area-weighted unit normals (nf, 3) of the pattern's faces; `corners` (ne, 3, 3) are the elements' corners, m."""
    vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros((pattern_faces.max() + 1, 3))
    np.add.at(total, pattern_faces, vectors)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return total / np.where(length > 0.0, length, 1.0)


def unordered_layers(mesh: Mesh, points: ContactPoints, slaves: np.ndarray, layers: np.ndarray) -> np.ndarray:
    """Pairs of faces (k, 2) of given pairs of points and layers, but for faces that share a vertex."""
    own = points.owners[points.owner_starts[slaves]]
    found = np.unique(np.sort(np.stack([own, layers], axis=1), axis=1), axis=0)
    around = {int(f): set(mesh.triangles[mesh.faces == f].ravel().tolist()) for f in np.unique(found)}
    return np.array([(a, b) for a, b in found.tolist() if not around[a] & around[b]], dtype=int).reshape(-1, 2)
