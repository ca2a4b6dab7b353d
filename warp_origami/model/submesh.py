"""The elements split into small triangles: what contact sees and what is drawn.

The cubic surface of an element is sampled at area coordinates that are multiples of 1 / divisions. Points where r is
continuous between elements (mesh vertices, smooth edges, and creases by the fold condition (48)) exist once; the two
sides of a cut have their own.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .lattice import edge_points, element_points, lattice
from .mesh import CREASE, Mesh

COARSE, MIDDLE = 500, 5000
"""Numbers of elements up to which elements are drawn in 4 and in 2 divisions."""


@dataclass(frozen=True)
class Submesh:
    """Every element split into divisions^2 sub-triangles.

    Points are ordered: mesh vertices that belong to an element (increasing; in a mesh without idle vertices point i is
    vertex i), then the points along every mesh edge from its first vertex to its second, then the interior points of
    the elements. Sub-triangles of one element follow each other.

    Attributes:
        divisions: k, sub-triangles along an element's side.
        elements: (np,) int32 an element that each point belongs to.
        areas: (np, 3) area coordinates of the point in that element.
        flat: (np, 2) flat coordinates, m.
        triangles: (nt, 3) int32 points of each sub-triangle, counter-clockwise in the flat sheet.
        triangle_elements: (nt,) int32 element of each sub-triangle.
        triangle_faces: (nt,) int32 mesh face of each sub-triangle.
        outer_edges: (nt, 3) bool, side m (from corner m to corner m + 1) lies on the outer boundary of the face.
        outer_corners: (nt, 3) bool, corner m lies on the outer boundary of the face.
        creases: (nc, k + 1) int32 points along every CREASE edge of the mesh.
    """

    divisions: int
    elements: np.ndarray
    areas: np.ndarray
    flat: np.ndarray
    triangles: np.ndarray
    triangle_elements: np.ndarray
    triangle_faces: np.ndarray
    outer_edges: np.ndarray
    outer_corners: np.ndarray
    creases: np.ndarray

    @cached_property
    def triangle_areas(self) -> np.ndarray:
        """(nt,) flat areas of the sub-triangles, m^2."""
        a, b, c = (self.flat[self.triangles[:, k]] for k in range(3))
        return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def default_divisions(elements: int) -> int:
    """Divisions for contact: about 800 sub-triangles or more, 4 divisions at most, 1 beyond 5000 elements.

    Contact points must lie closer together than what they are to keep apart; on a fine mesh the elements themselves do
    that. Two divisions stay up to 5000 elements because one plane facet per cubic element is coarse where it bends.
    """
    wanted = int(np.ceil(np.sqrt(800.0 / elements)))
    return int(np.clip(wanted, 1 if elements > 5000 else 2, 4))


def drawn_divisions(elements: int) -> int:
    """Divisions for drawing, and for what must not cross in a drawing: 4 on coarse meshes, where cubic shapes show."""
    return 4 if elements <= COARSE else 2 if elements <= MIDDLE else 1


def sub_triangle_corners(divisions: int) -> np.ndarray:
    """Area coordinates (divisions^2, 3, 3) of the corners of an element's sub-triangles, in their order."""
    areas, triangles, _ = lattice(divisions)
    return areas[triangles] / divisions


def build_submesh(mesh: Mesh, divisions: int) -> Submesh:
    """Splits every element of `mesh` into divisions^2 sub-triangles; every mesh edge must belong to an element."""
    k, ne = divisions, len(mesh.triangles)
    corners, local, _ = lattice(k)
    numbers = element_points(mesh, k)
    used, first, points = np.unique(numbers, return_index=True, return_inverse=True)  # idle vertices are left out
    points = points.reshape(numbers.shape)
    elements = (first // len(corners)).astype(np.int32)  # one element and lattice point of every point
    areas = corners[first % len(corners)] / k
    flat = np.einsum("pk,pkd->pd", areas, mesh.vertices[mesh.triangles[elements]])
    at_vertex = used < len(mesh.vertices)
    flat[at_vertex] = mesh.vertices[used[at_vertex]]

    creases = np.searchsorted(used, edge_points(mesh, k)[mesh.edge_kinds == CREASE]).astype(np.int32)
    triangles = points[:, local].reshape(-1, 3).astype(np.int32)
    triangle_elements = np.repeat(np.arange(ne, dtype=np.int32), k * k)
    triangle_faces = mesh.faces[triangle_elements].astype(np.int32)
    outer_edges, outer_corners = _outer(mesh, corners[local], triangles, triangle_faces)
    return Submesh(
        divisions=k,
        elements=elements,
        areas=areas,
        flat=flat,
        triangles=triangles,
        triangle_elements=triangle_elements,
        triangle_faces=triangle_faces,
        outer_edges=outer_edges,
        outer_corners=outer_corners,
        creases=creases,
    )


def _outer(mesh: Mesh, corners: np.ndarray, triangles: np.ndarray, faces: np.ndarray):
    """outer_edges and outer_corners; `corners` (k^2, 3, 3) are the lattice coordinates of an element's sub-triangles.

    A crease that ends inside a face has that face on both sides and is not on its outer boundary.
    """
    two = mesh.edge_triangles.min(axis=1) >= 0
    outer = ~two
    outer[two] = mesh.faces[mesh.edge_triangles[two, 0]] != mesh.faces[mesh.edge_triangles[two, 1]]
    # side m of the element is where the area coordinate of the opposite corner, m + 2, is zero at both ends
    zero = (corners == 0) & (np.roll(corners, -1, axis=1) == 0)  # (k^2, sub-side, area coordinate)
    on_side = np.roll(zero, 1, axis=2)  # (k^2, sub-side, side of the element): column m is area coordinate m + 2
    outer_edges = np.einsum("tsm,em->ets", on_side, outer[mesh.element_edges]).astype(bool).reshape(-1, 3)

    t, s = np.nonzero(outer_edges)
    keys = faces[:, None].astype(np.int64) * (triangles.max() + 1) + triangles
    marked = np.concatenate([keys[t, s], keys[t, (s + 1) % 3]])
    return outer_edges, np.isin(keys, marked)
