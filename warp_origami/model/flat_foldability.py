"""Whether creases around a vertex can be folded flat: the theorems of Kawasaki and Maekawa.

    Kawasaki:  the creases are even in number, and every second angle between them add up to pi
    Maekawa:   the numbers of mountains and valleys differ by two

Both are necessary, and hold at every vertex inside a sheet that is folded flat (E. Demaine and J. O'Rourke, Geometric
Folding Algorithms, 2007, section 12.1). A vertex whose creases are not all folded by pi, such as those on the medians
of the leaf-in, needs neither.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from .fold_angles import fold_angles
from .mesh import BOUNDARY, CREASE, Mesh

ANGLE = 1e-7
"""Round-off of angles around a vertex and of fold angles, rad."""


@dataclass(frozen=True)
class VertexFolds:
    """The vertices inside the sheet at which creases meet, cuts being its boundary.

    Attributes:
        vertices: (k,) of the mesh.
        degrees: (k,) creases at each.
        kawasaki: (k,) how much every second angle miss pi, rad; pi where the creases are odd in number.
        maekawa: (k,) mountains less valleys.
        assigned: (k,) whether all creases are mountain or valley.
    """

    vertices: np.ndarray
    degrees: np.ndarray
    kawasaki: np.ndarray
    maekawa: np.ndarray
    assigned: np.ndarray

    @property
    def flat_foldable(self) -> np.ndarray:
        """(k,) bool: nothing stands against folding the vertex flat."""
        return (self.kawasaki < ANGLE) & ((np.abs(self.maekawa) == 2) | ~self.assigned)


def vertex_folds(mesh: Mesh, folded: np.ndarray | None = None) -> VertexFolds:
    """Kawasaki and Maekawa at the inner vertices of a flat sheet.

    Args:
        folded: (nd,) bool, edges that count as folded; all creases by default.
    """
    folded = mesh.edge_kinds == CREASE if folded is None else folded
    rim = np.unique(mesh.edges[mesh.edge_kinds == BOUNDARY])
    edges = np.flatnonzero(folded)
    ends = np.concatenate([mesh.edges[edges], mesh.edges[edges, ::-1]])
    inside = ~np.isin(ends[:, 0], rim)
    ends, letters = ends[inside], np.tile(mesh.edge_assignments[edges], 2)[inside]
    along = mesh.vertices[ends[:, 1]] - mesh.vertices[ends[:, 0]]
    angles = np.arctan2(along[:, 1], along[:, 0])
    order = np.lexsort((angles, ends[:, 0]))
    vertices, first, degrees = np.unique(ends[order, 0], return_index=True, return_counts=True)
    kawasaki, maekawa, assigned = [], [], []
    for start, degree in zip(first.tolist(), degrees.tolist(), strict=True):
        own = order[start : start + degree]
        sectors = np.diff(angles[own], append=angles[own[0]] + 2.0 * np.pi)
        kawasaki.append(np.pi if degree % 2 else abs(float(sectors[::2].sum()) - np.pi))
        counts = [int((letters[own] == letter).sum()) for letter in "MV"]
        maekawa.append(counts[0] - counts[1])
        assigned.append(sum(counts) == degree)
    return VertexFolds(
        vertices, degrees, np.array(kawasaki), np.array(maekawa, dtype=int), np.array(assigned, dtype=bool)
    )


def flat_folded_vertices(mesh: Mesh, stowed: np.ndarray) -> VertexFolds:
    """Those inner vertices whose creases are all folded by pi or not at all in the stowed state, m; creases that are
    not folded are left out. Kawasaki and Maekawa must hold there."""
    angles = np.abs(fold_angles(mesh, stowed))
    creases = mesh.edge_kinds == CREASE
    partly = creases & (angles > ANGLE) & (angles < np.pi - ANGLE)
    found = vertex_folds(mesh, creases & (angles > ANGLE))
    whole = ~np.isin(found.vertices, mesh.edges[partly])
    return VertexFolds(
        *(getattr(found, name)[whole] for name in ("vertices", "degrees", "kawasaki", "maekawa", "assigned"))
    )


def check_flat_foldable(mesh: Mesh, key: str, got: object, folds: VertexFolds | None = None) -> None:
    """Refuses a pattern with a vertex that cannot be folded flat.

    Args:
        key, got: the parameter that is to blame, and its value.
        folds: vertices that must be flat-foldable; all inner ones by default.

    Raises:
        InputError: naming the first such vertex and what is wrong there.
    """
    folds = vertex_folds(mesh) if folds is None else folds
    wrong = np.flatnonzero(~folds.flat_foldable)
    if not len(wrong):
        return
    k = int(wrong[0])
    x, y = mesh.vertices[folds.vertices[k]]
    if folds.kawasaki[k] >= ANGLE:
        wants = f"every second angle between creases adding up to pi (Kawasaki): {folds.kawasaki[k]:.3g} rad off"
    else:
        wants = f"mountains and valleys that differ by 2 (Maekawa), not by {abs(folds.maekawa[k])}"
    raise InputError(key, got, f"{wants} at vertex {folds.vertices[k]} at ({x:.6g}, {y:.6g})")
