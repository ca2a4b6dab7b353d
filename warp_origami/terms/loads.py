"""Nodal vectors of loads that keep their direction: consistent with the shape functions, so that work is exact.

A traction t (N/m^2 of flat area) on a surface or a force t (N/m of flat length) along a line gives F_i = w_i t with

    w_i = int S_i dA   or   w_i = int S_i ds.
"""

import numpy as np

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.edge_traces import HERMITE, edge_traces
from warp_origami.model.mesh import Mesh
from warp_origami.model.selectors import Selection

from .quadrature import rule
from .shapes import ShapeTable, tabulate

SHAPE_DEGREE = 4
"""Degree of the shape functions."""

NORMAL_DEGREE = 8
"""Degree of the rule for unit normals, which are no polynomials."""


def surface_weights(mesh: Mesh, coordinates: Coordinates, elements: np.ndarray) -> np.ndarray:
    """(n,) int S_i dA over `elements`, exact: m^2 in rows of positions, m^3 in rows of gradients."""
    table, areas = _points(mesh, elements, SHAPE_DEGREE)
    return table.interpolation(coordinates).T @ areas


def normal_weights(mesh: Mesh, coordinates: Coordinates, elements: np.ndarray, q0: np.ndarray) -> np.ndarray:
    """(n, 3) int S_i n dA over the flat `elements`, n the unit normal along r_x x r_y in the state q0 (n, 3).

    Times a pressure (Pa) the force of a dead pressure, which keeps the direction it has in that state. Exact where q0
    is plane in every element.
    """
    table, areas = _points(mesh, elements, NORMAL_DEGREE)
    gradients = np.einsum("pid,pic->dpc", table.gradients, q0[coordinates.elements[table.elements]])
    normals = np.cross(*gradients)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return table.interpolation(coordinates).T @ (areas[:, None] * normals)


def force_weights(mesh: Mesh, coordinates: Coordinates, selection: Selection) -> np.ndarray:
    """(n,) share of each row of q in a force whose total over the selection is given; positions sum to 1.

    The force is spread evenly over what the selected vertices make up, the first of these that holds all of them:
    the whole sheet; selected edges of the boundary; elements with all corners selected; any mesh edges with both ends
    selected; else every vertex takes an equal share.
    """
    kind, parts = carriers(mesh, selection)
    if kind != "points":
        return _even(surface_weights if kind == "elements" else _line_weights, mesh, coordinates, parts)
    shares = np.zeros(coordinates.count)
    shares[coordinates.positions[parts]] = 1.0 / len(parts)
    return shares


def carriers(mesh: Mesh, selection: Selection) -> tuple[str, np.ndarray]:
    """What a load or a mass on a selection is spread over, as said in `force_weights`: "elements", "edges" or "points",
    and their numbers."""
    if selection.whole:
        return "elements", np.arange(len(mesh.triangles))
    chosen = np.zeros(len(mesh.vertices), dtype=bool)
    chosen[selection.vertices] = True
    inner = np.flatnonzero(chosen[mesh.edges].all(axis=1))
    elements = np.flatnonzero(chosen[mesh.triangles].all(axis=1))
    for kind, parts, vertices in (
        ("edges", selection.edges, mesh.edges[selection.edges]),
        ("elements", elements, mesh.triangles[elements]),
        ("edges", inner, mesh.edges[inner]),
    ):
        if len(parts) and np.isin(selection.vertices, vertices).all():
            return kind, parts
    return "points", selection.vertices


def _even(weights, mesh: Mesh, coordinates: Coordinates, parts: np.ndarray) -> np.ndarray:
    """Weights of a load spread evenly over elements or edges, over their area or length."""
    found = weights(mesh, coordinates, parts)
    return found / found[coordinates.positions[coordinates.positions >= 0]].sum()


def _line_weights(mesh: Mesh, coordinates: Coordinates, edges: np.ndarray) -> np.ndarray:
    """(n,) int S_i ds along mesh edges: l/2 at both ends, +-l^2/12 on the slopes along the edge.

    On a crease the slopes are those of its first element; the fold condition (48) makes them equal to the other's.
    """
    traces = edge_traces(mesh, coordinates, edges, np.zeros(len(edges), dtype=int))
    integrals = np.array([h.integ()(1.0) for h in HERMITE])
    local = traces.lengths[:, None] * np.einsum("a,eai->ei", integrals, traces.matrices)
    return np.bincount(traces.rows.ravel(), weights=local.ravel(), minlength=coordinates.count)


def _points(mesh: Mesh, elements: np.ndarray, degree: int) -> tuple[ShapeTable, np.ndarray]:
    """Shape functions at the quadrature points of `elements`, and the area of each point, m^2."""
    areas, weights = rule(degree)
    table = tabulate(mesh, np.repeat(elements, len(areas)), np.tile(areas, (len(elements), 1)))
    return table, np.outer(mesh.areas[elements], weights).ravel()
