"""The flat pattern, split into triangular elements."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .connectivity import ConnectivityError, corner_fans, edge_keys, face_numbers, find_element_edges, list_edges

SMOOTH, CREASE, BOUNDARY = 0, 1, 2
"""Kinds of mesh edges. A cut of the pattern is two BOUNDARY edges with their own vertices."""


@dataclass(frozen=True)
class Mesh:
    """Triangles of the flat sheet with the kind of every edge.

    All elements use one flat reference frame, so that continuity of the gradient across a smooth edge (50) is plain
    sharing of nodal gradients.

    Attributes:
        vertices: (nv, 2) flat coordinates, m.
        triangles: (ne, 3) int32 vertices of each element, counter-clockwise seen from +z.
        edges: (nd, 2) int32 vertices of each edge, each edge once, counter-clockwise around its first element.
        edge_triangles: (nd, 2) int32 elements on both sides, the second -1 where there is none.
        edge_kinds: (nd,) int8, SMOOTH, CREASE or BOUNDARY.
        edge_assignments: (nd,) '<U1', the letter of the crease pattern: M, V, U (creases), F (smooth), B (boundary).
        faces: (ne,) int32 face of each element: a face is a connected set of elements without a crease between them.
        sources: (nv,) int32 index of the vertex in the pattern as given (its file or generator). A cut duplicates
            vertices: copies have the same source. -1 for vertices added by refinement.
        boundary_parents: (nv, 2) int32, for a vertex that refinement added on a boundary edge the two mesh vertices
            that are the ends of that edge of the pattern; -1 elsewhere.
        linear: whether elements stay plane, their gradients following from positions (linear_elements.py).
    """

    vertices: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    edge_triangles: np.ndarray
    edge_kinds: np.ndarray
    edge_assignments: np.ndarray
    faces: np.ndarray
    sources: np.ndarray
    boundary_parents: np.ndarray
    linear: bool = False

    @cached_property
    def areas(self) -> np.ndarray:
        """(ne,) flat areas, m^2."""
        return signed_areas(self.vertices, self.triangles)

    @cached_property
    def size(self) -> float:
        """Diagonal of the flat bounding box, m: the length that tolerances are relative to."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def element_edges(self) -> np.ndarray:
        """(ne, 3) edge from corner k to corner k + 1 of each element."""
        return find_element_edges(self.triangles, self.edges, self.edge_triangles)


def signed_areas(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(ne,) areas of triangles (ne, 3) of points (nv, 2), positive where they are counter-clockwise, m^2."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def build_mesh(
    vertices: np.ndarray,
    triangles: np.ndarray,
    lines: np.ndarray | None = None,
    letters: np.ndarray | None = None,
) -> Mesh:
    """Mesh of a triangulated crease pattern.

    Vertices without triangles are left out, the others keep their order. Cuts separate the sheet: where they divide
    the triangles around a vertex into several fans, each further fan gets a copy of the vertex, after all others; the
    tip of a cut stays one vertex.

    Args:
        vertices: (n, 2) flat coordinates, m.
        triangles: (ne, 3) vertices of each triangle, in either sense.
        lines: (k, 2) vertices of the edges that have a letter.
        letters: (k,) M, V, U (crease), F, J (smooth), C (cut) or B. An edge without a letter is smooth; an edge with
            one triangle is boundary whatever its letter.

    Raises:
        ConnectivityError: an edge has more than two triangles, or two on one side; a line is no edge of the triangles;
            an edge inside the sheet has the letter B.
    """
    vertices = np.asarray(vertices, dtype=float)
    triangles = np.array(triangles, dtype=np.int64)
    clockwise = signed_areas(vertices, triangles) < 0
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    edges, edge_triangles = list_edges(triangles, len(vertices))
    edge_letters = _letters_of_edges(edges, edge_triangles, len(vertices), lines, letters)
    sources = np.arange(len(vertices))

    cut = edge_letters == "C"
    if cut.any():
        triangles, sources = _separate(triangles, edges, edge_triangles, cut, len(vertices))
        edges, edge_triangles, edge_letters = _open_cuts(edges, edge_triangles, edge_letters, triangles, sources)

    used = np.unique(triangles)
    number = np.full(len(sources), -1)
    number[used] = np.arange(len(used))
    return assemble_mesh(
        vertices[sources[used]],
        number[triangles],
        number[edges],
        edge_triangles,
        edge_letters,
        sources[used],
        np.full((len(used), 2), -1),
    )


def assemble_mesh(vertices, triangles, edges, edge_triangles, letters, sources, boundary_parents) -> Mesh:
    """Mesh with the kinds of edges and the faces that follow from the edges' letters (M, V, U, F or B)."""
    kinds = np.where(letters == "B", BOUNDARY, np.where(letters == "F", SMOOTH, CREASE)).astype(np.int8)
    return Mesh(
        vertices=vertices,
        triangles=triangles.astype(np.int32),
        edges=edges.astype(np.int32),
        edge_triangles=edge_triangles.astype(np.int32),
        edge_kinds=kinds,
        edge_assignments=letters,
        faces=face_numbers(edge_triangles, kinds == SMOOTH, len(triangles)).astype(np.int32),
        sources=sources.astype(np.int32),
        boundary_parents=boundary_parents.astype(np.int32),
    )


def _letters_of_edges(edges, edge_triangles, vertex_count, lines, letters) -> np.ndarray:
    """(nd,) M, V, U, F, C or B: the letter given for each edge, B where there is one triangle only."""
    keys = edge_keys(*edges.T, vertex_count)
    found = np.full(len(edges), "F", dtype="<U1")
    if lines is not None and len(lines):
        lines = np.asarray(lines)
        wanted = edge_keys(*lines.T, vertex_count)
        at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        missing = keys[at] != wanted
        if missing.any():
            raise ConnectivityError(tuple(lines[np.argmax(missing)].tolist()), "no face has it")
        found[at] = letters
    inner = edge_triangles[:, 1] >= 0
    wrong = inner & (found == "B")
    if wrong.any():
        raise ConnectivityError(tuple(edges[np.argmax(wrong)].tolist()), "a boundary between two faces")
    found[found == "J"] = "F"
    found[~inner] = "B"
    return found


def _separate(triangles, edges, edge_triangles, cut, vertex_count) -> tuple[np.ndarray, np.ndarray]:
    """Triangles with a vertex of their own for every fan that cuts make, and the source of every vertex."""
    whole = corner_fans(triangles, edges, edge_triangles, np.ones(len(edges), dtype=bool)).ravel()
    fans = corner_fans(triangles, edges, edge_triangles, ~cut).ravel()
    # The first fan of each uncut fan keeps the vertex, so sheets that only touch in a point go on touching there.
    _, first, fan = np.unique(fans, return_index=True, return_inverse=True)
    keepers = np.zeros(len(first), dtype=bool)
    _, first_of_whole = np.unique(whole[first], return_index=True)
    keepers[first_of_whole] = True

    vertex = triangles.ravel()[first]
    copies = np.flatnonzero(~keepers)
    copies = copies[np.argsort(vertex[copies], kind="stable")]
    sources = np.concatenate([np.arange(vertex_count), vertex[copies]])
    vertex[copies] = vertex_count + np.arange(len(copies))
    return vertex[fan].reshape(-1, 3), sources


def _open_cuts(edges, edge_triangles, letters, triangles, sources):
    """Edges between the separated vertices: every cut becomes two boundary edges with one triangle each."""
    cut = np.flatnonzero(letters == "C")
    edges = np.concatenate([edges, edges[cut, ::-1]])
    edge_triangles = np.concatenate([edge_triangles, np.stack([edge_triangles[cut, 1], np.full(len(cut), -1)], axis=1)])
    edge_triangles[cut, 1] = -1
    letters = np.concatenate([letters, letters[cut]])
    letters[letters == "C"] = "B"
    corners = triangles[edge_triangles[:, 0]]
    ends = [corners[np.arange(len(edges)), np.argmax(sources[corners] == edges[:, [k]], axis=1)] for k in (0, 1)]
    return np.stack(ends, axis=1), edge_triangles, letters
