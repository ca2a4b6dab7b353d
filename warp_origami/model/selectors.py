"""Which vertices and boundary edges a selector of the scene file means, and which slopes it holds along them."""

from collections import defaultdict
from dataclasses import dataclass, replace

import numpy as np

from ..errors import InputError
from .connectivity import corner_fans
from .mesh import BOUNDARY, SMOOTH, Mesh

TIE = 1e-9
"""Distances that count as equal, relative to the size of the sheet."""

SMOOTH_TURN = np.pi / 4 - 1e-9
"""Held edges that meet at a smaller turn (rad) are a curved rim drawn as a polygon."""


NO_EDGES = np.zeros(0, dtype=int)


@dataclass(frozen=True)
class Selection:
    """What a selector selects.

    Attributes:
        vertices: (k,) mesh vertices in increasing order.
        edges: boundary edges of the mesh with both ends selected.
        whole: the selector is `all`: slopes are selected everywhere, not only along edges.
    """

    vertices: np.ndarray
    edges: np.ndarray
    whole: bool


def select(at, mesh: Mesh, key: str = "at") -> Selection:
    """Selection of a selector table.

    `near`, `circle` and `vertices` select among the vertices of the unrefined pattern and add those that refinement put
    on a boundary edge between two selected ones; `box`, `boundary` and `all` look at the refined mesh.

    Args:
        at: mapping with one of near, box, circle (and tol), boundary, all, vertices; or an object with these
            attributes, None for those not used.
        key: what the scene file calls it.

    Raises:
        InputError: nothing is selected, or a vertex number that no face has.
    """
    at = {name: value for name, value in (at if isinstance(at, dict) else vars(at)).items() if value is not None}
    whole = bool(at.get("all"))
    if whole:
        chosen = np.ones(len(mesh.vertices), dtype=bool)
    elif at.get("boundary"):
        chosen = np.zeros(len(mesh.vertices), dtype=bool)
        chosen[mesh.edges[mesh.edge_kinds == BOUNDARY]] = True
    elif "box" in at:
        chosen = _in_box(mesh, np.asarray(at["box"], dtype=float))
    else:
        chosen = _with_refined_edges(mesh, _given_vertices(mesh, at, key))
    if not chosen.any():
        low, high = mesh.vertices.min(axis=0).tolist(), mesh.vertices.max(axis=0).tolist()
        raise InputError(key, f"no vertex of the sheet, which lies in {[low, high]}", "a selector that matches some")
    rim = mesh.edge_kinds == BOUNDARY
    held = rim & chosen[mesh.edges].all(axis=1)
    return Selection(np.flatnonzero(chosen), np.flatnonzero(held), whole)


def held_directions(
    mesh: Mesh, selection: Selection, others: np.ndarray = NO_EDGES
) -> list[tuple[int, int, np.ndarray]]:
    """Directions along which a selection holds the slope: rows (vertex, element, unit vector (2,) in the flat plane).

    Each end of a selected boundary edge holds the derivative along it, in the edge's own element and hence sector.
    Where two held edges meet on one piece of the sheet at a turn below 45 degrees, the derivative along their mean
    direction is held instead. What would be the same row twice (one sector, one line) is there once. So a straight or
    curved rim gives one row per vertex, a corner two, and a rim that a crease runs into one row for each face there.

    `others` are edges that something else holds: they have no rows here, but turn with those that have.
    """
    corner_sector = corner_fans(mesh.triangles, mesh.edges, mesh.edge_triangles, mesh.edge_kinds == SMOOTH)
    corner_piece = corner_fans(mesh.triangles, mesh.edges, mesh.edge_triangles, mesh.edge_kinds != BOUNDARY)
    ends = defaultdict(list)  # piece of the sheet around a vertex -> held edges, at most two
    own = set(selection.edges.tolist())
    for d in sorted(own | set(others.tolist())):
        element = int(mesh.edge_triangles[d, 0])
        along = mesh.vertices[mesh.edges[d, 1]] - mesh.vertices[mesh.edges[d, 0]]
        along = along / np.linalg.norm(along)
        for v in mesh.edges[d].tolist():
            corner = int(np.argmax(mesh.triangles[element] == v))
            sector = int(corner_sector[element, corner])
            ends[int(corner_piece[element, corner])].append(_HeldEnd(v, element, sector, along, d in own))

    rows = []
    for held in ends.values():
        if len(held) == 2:
            # Boundary edges run around the sheet, so the turn is the angle between the two vectors.
            one, two = held[0].along, held[1].along
            if np.arctan2(abs(_cross(one, two)), one @ two) < SMOOTH_TURN:
                mean = (one + two) / np.linalg.norm(one + two)
                held = [replace(end, along=mean) for end in held]
        held = [end for end in held if end.own]
        if len(held) == 2 and held[0].sector == held[1].sector and abs(_cross(held[0].along, held[1].along)) < TIE:
            held = held[:1]
        rows += [(end.vertex, end.element, end.along) for end in held]
    return sorted(rows, key=lambda row: row[:2])


@dataclass(frozen=True)
class _HeldEnd:
    """An end of a held edge: at `vertex`, in the sector of `element`, with the edge's unit vector."""

    vertex: int
    element: int
    sector: int
    along: np.ndarray
    own: bool


def _given_vertices(mesh: Mesh, at: dict, key: str) -> np.ndarray:
    """(nv,) bool, vertices of the unrefined pattern that near, circle or vertices select."""
    given = mesh.sources >= 0
    if "near" in at:
        distance = np.linalg.norm(mesh.vertices - np.asarray(at["near"], dtype=float), axis=1)
        nearest = given & (distance <= distance[given].min() + TIE * mesh.size)
        chosen = np.zeros(len(given), dtype=bool)
        chosen[np.argmax(nearest)] = True
        return chosen
    if "circle" in at:
        x, y, radius = at["circle"]
        distance = np.linalg.norm(mesh.vertices - np.array([x, y], dtype=float), axis=1)
        return given & (np.abs(distance - radius) <= at.get("tol", 1e-6))
    numbers = np.asarray(at["vertices"], dtype=int)
    unknown = ~np.isin(numbers, mesh.sources[given])
    if unknown.any():
        raise InputError(f"{key}.vertices", int(numbers[np.argmax(unknown)]), "numbers of vertices that faces have")
    return given & np.isin(mesh.sources, numbers)


def _in_box(mesh: Mesh, box: np.ndarray) -> np.ndarray:
    """(nv,) bool, vertices in the closed box [[x0, y0], [x1, y1]]; round-off of coordinates does not count."""
    margin = TIE * mesh.size
    return ((mesh.vertices >= box[0] - margin) & (mesh.vertices <= box[1] + margin)).all(axis=1)


def _with_refined_edges(mesh: Mesh, chosen: np.ndarray) -> np.ndarray:
    added = mesh.boundary_parents[:, 0] >= 0
    return chosen | (added & chosen[mesh.boundary_parents].all(axis=1))


def _cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])
