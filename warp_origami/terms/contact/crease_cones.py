"""Tangent cones of the sheet along its creases: which way its two sides leave a crease.

    x(P + s d) - x(P) = s F d + O(s^2),      F = [r_x r_y] of the element that the flat direction d points into

At a point P of a crease the distance of the two sides vanishes, and with it the thickness that contact keeps there: the
fold may close beyond flat at P, and the sides are then through each other, though neither facets of a finite size nor
points beside P need to be. To first order the sheet at P is the cone of the triangles (0, F d_1, F d_2); that these do
not pass through each other is what the sub-mesh cannot say, however fine it is.

Cones stand at every vertex on a crease, with a ray along each of its edges, and at the points of the sub-mesh along
creases, with rays along and across the crease. Rays reach as far as the first points of the sub-mesh, so that thickness
and stiffness of facets apply.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.locate import area_coordinates
from warp_origami.model.mesh import CREASE, Mesh

from ..shapes import tabulate
from .features import FeatureMesh, edges_of

SAME_DIRECTION = 1e-6
"""Part of a ray's length below which two of a cone end at one place: rays along the lips of a cut."""


@dataclass(frozen=True)
class Rays:
    """Points of cones: apices, which are rays of no length, and ends of rays.

    Attributes:
        cones: (n,) cone of each.
        elements: (n,) element that each lies in.
        apices: (n, 2) flat position of the apex, m.
        directions: (n, 2) ray in the flat sheet, m.
        triangles: (nt, 3) apex and two ends.
        triangle_elements: (nt,) element of each triangle.
    """

    cones: np.ndarray
    elements: np.ndarray
    apices: np.ndarray
    directions: np.ndarray
    triangles: np.ndarray
    triangle_elements: np.ndarray


def crease_cones(mesh: Mesh, coordinates: Coordinates, divisions: int) -> FeatureMesh:
    """The cones, each an island with its apex at zero, of a sub-mesh with `divisions` along an element's side."""
    at, beside = _at_vertices(mesh, divisions), _along_creases(mesh, divisions)
    elements, apices, directions, triangle_elements = (
        np.concatenate([getattr(part, name) for part in (at, beside)])
        for name in ("elements", "apices", "directions", "triangle_elements")
    )
    triangles = np.concatenate([at.triangles, beside.triangles + len(at.cones)]).astype(np.int32)
    edges, edge_elements = edges_of(triangles, triangle_elements)
    islands = np.concatenate([at.cones, beside.cones + at.cones.max() + 1])
    gradients = tabulate(mesh, elements, area_coordinates(mesh, elements, apices)).gradients
    rows = np.repeat(np.arange(len(elements)), 9)
    values = np.einsum("pkd,pd->pk", gradients, directions).ravel()
    shape = (len(elements), coordinates.count)
    interpolation = csr_matrix((values, (rows, coordinates.elements[elements].ravel())), shape=shape)
    interpolation.eliminate_zeros()
    return FeatureMesh(
        interpolation=interpolation,
        flat=apices + directions,
        elements=elements,
        groups=_groups(islands, directions),
        triangles=triangles,
        triangle_elements=triangle_elements,
        edges=edges,
        edge_elements=edge_elements,
        islands=islands,
    )


def _at_vertices(mesh: Mesh, divisions: int) -> Rays:
    """Cones of all elements around each vertex that a crease ends or passes at."""
    on_crease = np.zeros(len(mesh.vertices), dtype=bool)
    on_crease[mesh.edges[mesh.edge_kinds == CREASE]] = True
    element, corner = np.nonzero(on_crease[mesh.triangles])
    here, following, last = ((corner + step) % 3 for step in range(3))
    vertices = mesh.triangles[element, here]
    # a point is named by its vertex and edge, an apex by its vertex alone; edge m goes from corner m to the next
    sides = np.stack([np.full(len(element), -1), *(mesh.element_edges[element, m] for m in (here, last))], axis=1)
    names = np.stack([np.repeat(vertices, 3), sides.ravel()], axis=1)
    _, first, triangles = np.unique(names, axis=0, return_index=True, return_inverse=True)
    ends = np.stack([mesh.vertices[mesh.triangles[element, m]] for m in (here, following, last)], axis=1)
    directions = ((ends - ends[:, :1]) / divisions).reshape(-1, 2)
    owner = first // 3
    return Rays(
        cones=np.unique(vertices[owner], return_inverse=True)[1],
        elements=element[owner],
        apices=mesh.vertices[vertices[owner]],
        directions=directions[first],
        triangles=triangles.reshape(-1, 3),
        triangle_elements=element,
    )


def _along_creases(mesh: Mesh, divisions: int) -> Rays:
    """Cones of the two elements beside each point of the sub-mesh inside the edges that are creases."""
    edges = np.repeat(np.flatnonzero(mesh.edge_kinds == CREASE), divisions - 1)
    left, right = mesh.edge_triangles[edges].T
    start, end = (mesh.vertices[mesh.edges[edges, side]] for side in (0, 1))
    part = (np.arange(len(edges)) % max(divisions - 1, 1) + 1) / divisions
    along = (end - start) / divisions
    # into the first element, around which the edge runs, as far as the first points of its sub-mesh lie from the edge
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.sum(along**2, axis=1)[:, None]
    into_left, into_right = (2.0 * mesh.areas[side][:, None] / divisions**2 * normal for side in (left, right))
    number = np.arange(len(edges))
    triangles = 5 * number[:, None, None] + np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]])
    return Rays(
        cones=np.repeat(number, 5),
        elements=np.stack([left, left, left, left, right], axis=1).ravel(),
        apices=np.repeat(start + part[:, None] * (end - start), 5, axis=0),
        directions=np.stack([0.0 * along, along, into_left, -along, -into_right], axis=1).reshape(-1, 2),
        triangles=triangles.reshape(-1, 3),
        triangle_elements=np.stack([left, left, right, right], axis=1).ravel(),
    )


def _groups(islands: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Equal numbers for points of one cone that end at one place."""
    longest = np.zeros(islands.max() + 1)
    np.maximum.at(longest, islands, np.linalg.norm(directions, axis=1))
    places = np.round(directions / (SAME_DIRECTION * longest[islands])[:, None]).astype(np.int64)
    _, first, same = np.unique(np.column_stack([islands, places]), axis=0, return_index=True, return_inverse=True)
    return first[same.ravel()].astype(np.int32)
