"""Faces of a crease pattern that is given by its edges alone: the regions of a planar graph.

Half-edges are followed around each region, at every vertex to the next edge clockwise from where they came; regions on
the left are then counter-clockwise, the outside of each connected part clockwise. What borders on the outside is sheet,
and so is what follows across an edge that is no boundary; across a boundary (B) sheet and hole change.
"""

from collections import defaultdict

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from .fold_file import Entry
from .limits import check_elements
from .planar import coincident_vertices
from .triangulate import polygon_area

CLOSE = 1e-6
"""Distance of vertices, and of a vertex from an edge, that is taken for none, over the size of the pattern."""


def faces_of_edges(points: np.ndarray, lines: np.ndarray, letters: np.ndarray | None, entry: Entry) -> list[list[int]]:
    """Vertices of each face, counter-clockwise.

    Args:
        points: (n, 2) vertices, m.
        lines: (k, 2) vertices of the edges.
        letters: (k,) of `edges_assignment`; None: every closed region is a face.
        entry: `edges_vertices`, for messages.

    Raises:
        InputError: edges cross, meet in a vertex that is not theirs, or end inside a face; a face has a hole that no
            edge connects with its outline; there is no face.
    """
    if not len(lines):
        raise entry.fault(None, "no edge", "edges around at least one face")
    check_elements(entry.name, len(lines) // 3)
    _check_apart(points, lines, CLOSE * float(np.linalg.norm(np.ptp(points[lines.ravel()], axis=0))), entry)
    regions, left = _trace(points, lines)
    outside = np.array([polygon_area(points[region].tolist()) <= 0.0 for region in regions], dtype=bool)
    for i in np.flatnonzero(left[:, 0] == left[:, 1]):
        raise entry.fault(int(i), f"{_ends(lines, i)} with the same region on both sides", "no edge that ends nowhere")
    sheet = _sheet(left, outside, letters)
    for i in np.flatnonzero(~sheet[left].any(axis=1)):
        raise entry.fault(int(i), f"{_ends(lines, i)} without a face at its sides", "edges of faces (B around holes)")
    faces = [region for region, kept in zip(regions, sheet, strict=True) if kept]
    _check_whole(points, lines, faces, entry)
    return faces


def _ends(lines: np.ndarray, i: int) -> str:
    return str(lines[i].tolist())


def _check_apart(points: np.ndarray, lines: np.ndarray, close: float, entry: Entry) -> None:
    """Refuses vertices in one place, vertices on edges, and edges that cross, each by its number."""
    used = np.unique(lines)
    same = coincident_vertices(points[used], close)
    if same is not None:
        a, b = (int(used[k]) for k in same)
        name = entry.name.replace("edges_vertices", "vertices_coords")
        raise Entry(None, name).fault(b, f"the place of vertex {a}", "one vertex where edges meet")
    low, high = points[lines].min(axis=1), points[lines].max(axis=1)
    by_x = used[np.argsort(points[used, 0], kind="stable")]
    for i, (a, b) in enumerate(lines.tolist()):
        first, last = np.searchsorted(points[by_x, 0], [low[i, 0] - close, high[i, 0] + close])
        near = by_x[first:last]
        way = points[b] - points[a]
        length = np.linalg.norm(way)
        along = (points[near] - points[a]) @ way / length
        aside = np.abs(_cross(way, points[near] - points[a])) / length
        on = near[(aside < close) & (along > close) & (along < length - close)]
        if len(on):
            found = f"{_ends(lines, i)} with vertex {on.min()} on it"
            raise entry.fault(i, found, f"two edges that meet in vertex {on.min()}")
    order = np.argsort(low[:, 0], kind="stable")
    starts = low[order, 0]
    for k, i in enumerate(order):
        later = order[k + 1 : np.searchsorted(starts, high[i, 0], side="right")]
        (a, b), c, d = points[lines[i]], points[lines[later, 0]], points[lines[later, 1]]
        apart = (lines[later][:, :, None] != lines[i]).all(axis=(1, 2))
        over = (_cross(b - a, c - a) * _cross(b - a, d - a) < 0.0) & (_cross(d - c, a - c) * _cross(d - c, b - c) < 0.0)
        crossed = later[over & apart]
        if len(crossed):
            i, j = sorted((int(i), int(crossed.min())))
            wants = "a vertex where they cross, and edges from it"
            raise entry.fault(j, f"{_ends(lines, j)} across edge {i}, {_ends(lines, i)}", wants)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _trace(points: np.ndarray, lines: np.ndarray) -> tuple[list[list[int]], np.ndarray]:
    """Vertices of each region and outside, and (k, 2) which of them lies left of each edge, and left of its reverse."""
    half = np.concatenate([lines, lines[:, ::-1]])
    way = points[half[:, 1]] - points[half[:, 0]]
    leaving = defaultdict(list)
    for h in np.argsort(np.arctan2(way[:, 1], way[:, 0]), kind="stable").tolist():
        leaving[half[h, 0]].append(h)
    clockwise = {h: around[k - 1] for around in leaving.values() for k, h in enumerate(around)}
    region = np.full(len(half), -1)
    found = []
    for start in range(len(half)):
        if region[start] >= 0:
            continue
        h, vertices = start, []
        while region[h] < 0:
            region[h] = len(found)
            vertices.append(int(half[h, 0]))
            h = clockwise[(h + len(lines)) % len(half)]
        found.append(vertices)
    return found, region.reshape(2, -1).T


def _sheet(left: np.ndarray, outside: np.ndarray, letters: np.ndarray | None) -> np.ndarray:
    """(regions,) bool: what is a face and no hole."""
    if letters is None:
        return ~outside
    kind = np.where(outside, 0, -1)
    neighbours = defaultdict(list)
    for (f, g), letter in zip(left.tolist(), letters.tolist(), strict=True):
        if outside[f] or outside[g]:
            kind[[k for k in (f, g) if not outside[k]]] = 1
        neighbours[f].append((g, letter == "B"))
        neighbours[g].append((f, letter == "B"))
    ready = np.flatnonzero(kind == 1).tolist()
    for f in ready:  # grows
        for g, boundary in neighbours[f]:
            if kind[g] < 0:
                kind[g] = 1 - kind[f] if boundary else kind[f]
                ready.append(g)
    return kind == 1


def _check_whole(points: np.ndarray, lines: np.ndarray, faces: list[list[int]], entry: Entry) -> None:
    """Refuses faces that touch themselves, and faces with another connected part inside."""
    for face in faces:
        if len(set(face)) < len(face):
            v = next(v for v in face if face.count(v) > 1)
            raise entry.fault(None, f"a face that touches itself in vertex {v}", "an edge (F) that divides it there")
    count = len(points)
    graph = coo_matrix((np.ones(len(lines)), lines.T), shape=(count, count))
    part = connected_components(graph, directed=False)[1]
    first = {part[v]: int(v) for v in lines.ravel()[::-1]}
    if len(first) == 1:
        return
    for own, v in first.items():
        for face in faces:
            if part[face[0]] != own and _inside(points[v], points[face]):
                raise entry.fault(
                    None,
                    f"a part with vertex {v} inside a face with vertex {face[0]}",
                    "two edges (F) from the rim of a hole to the outline around it; separate sheets apart",
                )


def _inside(point: np.ndarray, polygon: np.ndarray) -> bool:
    """Whether a ray to the right crosses the polygon's sides an odd number of times."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    across = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    a, b = a[across], b[across]
    at = a[:, 0] + (point[1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return int((at > point[0]).sum()) % 2 == 1
