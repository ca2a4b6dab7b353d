"""Every triangle split into n^2 similar ones; a vertex of the given mesh keeps its index."""

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_matrix

from .connectivity import edge_keys, list_edges
from .lattice import edge_points, element_points, lattice
from .mesh import BOUNDARY, Mesh, assemble_mesh
from .pattern import Pattern


def refine_pattern(pattern: Pattern, n: int) -> Pattern:
    """Pattern with every triangle split into n^2.

    Stowed positions are interpolated linearly on each triangle; vertices of rings are added on circles.
    """
    if n == 1:
        return pattern
    weights = interpolation(pattern.mesh, n)
    mesh, rings = refine(pattern.mesh, n), pattern.rings
    if rings is not None:
        rings = rings.interpolated(weights)
        mesh = replace(mesh, vertices=rings.vertices)
    return replace(
        pattern,
        mesh=mesh,
        stowed=None if pattern.stowed is None else weights @ pattern.stowed,
        pattern_faces=np.repeat(pattern.pattern_faces, n * n),
        rings=rings,
    )


def refine(mesh: Mesh, n: int) -> Mesh:
    """Mesh with every triangle split into n^2: those of triangle e are e n^2 ... (e + 1) n^2 - 1.

    Edges and vertices on an edge of `mesh` inherit its kind; edges inside a triangle are smooth.

    Raises:
        ValueError: n < 1.
    """
    if n < 1:
        raise ValueError(f"refinement {n}, wants at least 1")
    if n == 1:
        return mesh
    _, cells, _ = lattice(n)
    triangles = element_points(mesh, n)[:, cells].reshape(-1, 3)
    weights = interpolation(mesh, n)
    added = weights.shape[0] - len(mesh.vertices)

    edges, edge_triangles = list_edges(triangles, weights.shape[0])
    letters = np.full(len(edges), "F", dtype="<U1")
    chains = edge_points(mesh, n)
    keys = edge_keys(*edges.T, weights.shape[0])
    at = np.searchsorted(keys, edge_keys(chains[:, :-1].ravel(), chains[:, 1:].ravel(), weights.shape[0]))
    letters[at] = np.repeat(mesh.edge_assignments, n)

    parents = np.full((weights.shape[0], 2), -1)
    parents[: len(mesh.vertices)] = mesh.boundary_parents
    rim = mesh.edge_kinds == BOUNDARY
    parents[chains[rim, 1:-1]] = _pattern_edge(mesh, mesh.edges[rim])[:, None, :]
    return assemble_mesh(
        weights @ mesh.vertices,
        triangles,
        edges,
        edge_triangles,
        letters,
        np.concatenate([mesh.sources, np.full(added, -1)]),
        parents,
    )


def interpolation(mesh: Mesh, n: int) -> csr_matrix:
    """(nv of the refined mesh, nv) weights of the given vertices in each vertex of `refine(mesh, n)`."""
    nv, nd, ne = len(mesh.vertices), len(mesh.edges), len(mesh.triangles)
    t = np.arange(1, n) / n
    areas, _, _ = lattice(n)
    inner = areas[(areas > 0).all(axis=1)] / n
    columns = np.concatenate(
        [np.arange(nv), np.repeat(mesh.edges, n - 1, axis=0).ravel(), np.repeat(mesh.triangles, len(inner), 0).ravel()]
    )
    values = np.concatenate(
        [np.ones(nv), np.tile(np.stack([1 - t, t], axis=1).ravel(), nd), np.tile(inner.ravel(), ne)]
    )
    lengths = np.repeat([1, 2, 3], [nv, nd * (n - 1), ne * len(inner)])
    starts = np.concatenate([[0], np.cumsum(lengths)])
    return csr_matrix((values, columns, starts), shape=(len(lengths), nv))


def _pattern_edge(mesh: Mesh, edges: np.ndarray) -> np.ndarray:
    """Ends of the edges of the unrefined pattern that boundary edges of a (possibly refined) mesh are parts of."""
    a, b = (mesh.boundary_parents[edges[:, k]] for k in (0, 1))
    return np.where(a[:, :1] >= 0, a, np.where(b[:, :1] >= 0, b, edges))
