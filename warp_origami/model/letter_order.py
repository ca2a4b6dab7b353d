"""The order of layers folded flat onto each other as their letters tell it, and orders that contradict themselves.

At a valley that is folded shut the upper sides of both faces meet, at a mountain the lower ones: each face lies on the
other's side +1 (V) or -1 (M) in the sense of FOLD `faceOrders`. Where three faces have a point in common, one of them
is the highest: there they cannot lie above each other in a circle, as they may around a twist.
"""

from collections import defaultdict

import numpy as np

from .fold_angles import fold_angles
from .mesh import CREASE, Mesh

SHUT = 1e-3
"""Angle (rad) from pi of creases taken for folded flat: their letter is the order of both faces."""

SLIVER = 1e-4
"""Width of a common part that counts as none, over the size of the sheet."""

MOST_TRIPLES = 20_000
"""Of faces whose common part is looked for: some seconds."""


def letter_orders(mesh: Mesh, pattern_faces: np.ndarray, stowed: np.ndarray) -> dict[tuple[int, int], tuple[int, int]]:
    """(f, g) -> (s, mesh edge) for faces of the pattern, f < g, that meet at a crease M or V folded shut.

    Args:
        pattern_faces: (ne,) face of the pattern that each element lies in.
        stowed: (nv, 3) positions of the vertices, m.
    """
    shut = np.abs(fold_angles(mesh, stowed)) > np.pi - SHUT
    told = shut & (mesh.edge_kinds == CREASE) & np.isin(mesh.edge_assignments, ["M", "V"])
    orders = {}
    for d in np.flatnonzero(told).tolist():
        f, g = sorted(pattern_faces[mesh.edge_triangles[d]].tolist())
        orders.setdefault((f, g), (1 if mesh.edge_assignments[d] == "V" else -1, d))
    return orders


def find_circle(
    mesh: Mesh, pattern_faces: np.ndarray, face_orders: np.ndarray, stowed: np.ndarray
) -> tuple[int, ...] | None:
    """Two or three faces of the pattern, each above the next and the last above the first where all have a common
    part; None if there are none.

    Args:
        face_orders: (k, 3) rows as in Pattern.
    """
    layers = _Layers(mesh, pattern_faces, face_orders, stowed)
    for f, lower in layers.below.items():
        for g in sorted(lower):
            if f in layers.below[g]:
                return f, g
            for h in sorted(layers.below[g]):
                if f in layers.below[h] and layers.have_common_part(f, g, h):
                    return f, g, h
    return None


def concluded_orders(
    mesh: Mesh, pattern_faces: np.ndarray, face_orders: np.ndarray, stowed: np.ndarray
) -> list[tuple[int, int, int]]:
    """Rows (f, h, s) that follow from those given: f above g and g above h, where all three have a common part.

    Args:
        face_orders: (k, 3) rows as in Pattern.
    """
    layers = _Layers(mesh, pattern_faces, face_orders, stowed)
    above, found, apart = layers.above, [], set()
    ready = sorted(above)
    for g in ready:  # grows
        for f in sorted(above[g]):
            for h in sorted(layers.below[g]):
                if f == h or (f, g, h) in apart or h in layers.below[f] or f in layers.below[h]:
                    continue
                if len(found) + len(apart) == MOST_TRIPLES:
                    return found
                if not layers.have_common_part(f, g, h):
                    apart.add((f, g, h))
                    continue
                layers.below[f].add(h)
                above[h].add(f)
                found.append((f, h, int(layers.up[h])))
                ready += [f, h]
    return found


class _Layers:
    """Which faces of the pattern lie on which.

    Attributes:
        below, above: faces under and over each of those that orders tell of.
        up: 1 for faces whose normal points up, -1 for the others, alike for all that orders connect.
    """

    def __init__(self, mesh: Mesh, pattern_faces: np.ndarray, face_orders: np.ndarray, stowed: np.ndarray):
        self.corners = stowed[mesh.triangles]
        self.least = (SLIVER * mesh.size) ** 2
        self.elements = {f: np.flatnonzero(pattern_faces == f) for f in np.unique(face_orders[:, :2]).tolist()}
        first = self.corners[[own[0] for own in self.elements.values()]]
        normals = np.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])
        self.up = _turned(face_orders, dict(zip(self.elements, normals, strict=True)))
        self.below: dict[int, set[int]] = {f: set() for f in self.elements}
        self.above: dict[int, set[int]] = {f: set() for f in self.elements}
        for f, g, side in face_orders.tolist():
            upper, lower = (f, g) if side * self.up[g] > 0.0 else (g, f)
            self.below[upper].add(lower)
            self.above[lower].add(upper)

    def have_common_part(self, *faces: int) -> bool:
        """Whether some elements of three parallel faces overlap, all three."""
        first, second, third = (self.corners[self.elements[f]] for f in faces)
        x = first[0, 1] - first[0, 0]
        y = np.cross(np.cross(x, first[0, 2] - first[0, 0]), x)
        axes = np.stack([x / np.linalg.norm(x), y / np.linalg.norm(y)], axis=1)
        first, second, third = (part @ axes for part in (first, second, third))
        for a in first:
            for b in second:
                both = _clipped(a, b)
                for c in third if len(both) > 2 else ():
                    common = _clipped(both, c)
                    if len(common) > 2 and _area(common) > self.least:
                        return True
        return False


def _turned(face_orders: np.ndarray, normals: dict[int, np.ndarray]) -> dict[int, float]:
    """1 or -1 for each face: what makes all normals that orders connect agree."""
    neighbours = defaultdict(list)
    for f, g, _ in face_orders.tolist():
        alike = float(np.sign(normals[f] @ normals[g]))
        neighbours[f].append((g, alike))
        neighbours[g].append((f, alike))
    up: dict[int, float] = {}
    for start in neighbours:
        ready = [] if start in up else [start]
        up.setdefault(start, 1.0)
        for f in ready:  # grows
            for g, alike in neighbours[f]:
                if g not in up:
                    up[g] = alike * up[f]
                    ready.append(g)
    return up


def _clipped(polygon: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """(k, 2) part of a convex polygon (n, 2) inside a triangle (3, 2)."""
    turn = np.sign(_cross(triangle[1] - triangle[0], triangle[2] - triangle[0]))
    for k in range(3):
        along = triangle[(k + 1) % 3] - triangle[k]
        heights = turn * _cross(along, polygon - triangle[k])
        kept = []
        for i, height in enumerate(heights):
            j = (i + 1) % len(polygon)
            if height >= 0.0:
                kept.append(polygon[i])
            if height * heights[j] < 0.0:
                kept.append(polygon[i] + height / (height - heights[j]) * (polygon[j] - polygon[i]))
        polygon = np.array(kept).reshape(-1, 2)
        if len(polygon) < 3:
            break
    return polygon


def _area(polygon: np.ndarray) -> float:
    return 0.5 * abs(float(_cross(polygon - polygon[0], np.roll(polygon, -1, axis=0) - polygon[0]).sum()))


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
