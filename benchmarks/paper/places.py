"""Names of places on the flat sheet: the paper's points, ring corners P_k and ring middles Q_k of the pattern.

By four-fold mirror symmetry every place has a representative in the eighth between the median y = 0 and the diagonal.
"""

from collections.abc import Iterable

import numpy as np

from warp_origami.model.mesh import CREASE, Mesh


def into_eighth(flat: np.ndarray) -> np.ndarray:
    """(..., 2) representatives x >= y >= 0 of flat positions, m."""
    return np.sort(np.abs(flat), axis=-1)[..., ::-1]


def vertex_name(flat: np.ndarray) -> str:
    """O, P1 to P3 or Q1 to Q3 for a vertex of the pattern; M for the middle of O-P1."""
    x, y = into_eighth(flat)
    if x < 1e-9:
        return "O"
    ring = x * 10.0
    if abs(ring - round(ring)) < 1e-9 and abs(x - y) < 1e-9:
        return f"P{round(ring)}"
    return "M" if abs(x - y) < 1e-9 else f"Q{int(np.ceil(ring - 1e-9))}"


def face_name(mesh: Mesh, face: int) -> str:
    """Corners of a face, such as Q1-P2-P1."""
    vertices = np.unique(mesh.triangles[mesh.faces == face])
    names = {vertex_name(mesh.vertices[v]) for v in vertices} - {"M"}
    return _joined(names)


def crease_name(mesh: Mesh, flat: np.ndarray, tolerance: float = 1e-6) -> str | None:
    """Ends of the crease through a flat position, or the vertex there; None inside a face."""
    near = np.linalg.norm(mesh.vertices - flat, axis=1)
    if near.min() < tolerance:
        return vertex_name(mesh.vertices[np.argmin(near)])
    for a, b in mesh.edges[mesh.edge_kinds == CREASE]:
        start, along = mesh.vertices[a], mesh.vertices[b] - mesh.vertices[a]
        share = (flat - start) @ along / (along @ along)
        if 0.0 < share < 1.0 and np.linalg.norm(start + share * along - flat) < tolerance:
            return _joined(vertex_name(mesh.vertices[v]) for v in (a, b))
    return None


def _joined(names: Iterable[str]) -> str:
    return "-".join(sorted(names, key=lambda name: (name[1:], name[0])))
