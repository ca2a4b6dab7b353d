"""The way between the stowed and the flat state with the least strain, and how large that strain is.

With l the lengths of the edges and of braces across every smooth edge (between the two corners that do not lie on it),
L those of the flat sheet, b the angles at smooth edges, c by how much creases are folded beyond pi, and g the mean
square distance of the vertices from their centre,

    sum ((l^2 - L^2) / (2 L^2))^2 + sum b^2 + sum c^2 = min
    at   g = g_flat - (1 - s)^2 (g_flat - g_stowed),   s = 0 (stowed) ... 1 (flat)

solved by Newton's method (Gauss-Newton, with the constraint by a multiplier) from one state to the next. Folding
brings no two points farther apart than they are in the flat sheet, so g is largest there, and its loss goes with the
square of the fold angles. Creases that are folded flat are opened first, as their letters want it: there the mean of
the fold angles is given instead of g.

Where a pattern folds rigidly the sum is zero to round-off all the way; where it does not, what is found is a minimum
near the path that was followed: an upper bound of the least strain. A film has next to no bending stiffness: with
`plane` false its panels may bend along the sides of the elements, without braces and b^2 with the weight SOFT^2.
"""

from dataclasses import dataclass

import numpy as np

from .crossing import find_crossing
from .fold_angles import fold_angles
from .mesh import SMOOTH, Mesh
from .panels import Panels, spread

LARGEST = 3000
"""Vertices of the largest pattern whose path is looked for: beyond, it takes minutes."""

RIGID = 1e-8
"""Strain that counts as none: what Newton's method leaves of a rigid folding."""


@dataclass(frozen=True)
class FoldingPath:
    """States from stowed to flat.

    Attributes:
        progress: (n,) s, 0 stowed to 1 flat.
        positions: (n, nv, 3) m.
        strain: (n,) largest strain |l - L| / L of edges, and of braces if panels are to stay plane.
        mean_strain: (n,) root mean square of it.
        bending: (n,) largest angle between the two elements at a smooth edge, rad.
        crossing: (n,) whether panels pass through each other.
    """

    progress: np.ndarray
    positions: np.ndarray
    strain: np.ndarray
    mean_strain: np.ndarray
    bending: np.ndarray
    crossing: np.ndarray

    @property
    def rigid(self) -> bool:
        """Whether all states are free of strain and bending."""
        return bool(self.strain.max() < RIGID and self.bending.max() < RIGID)


def folding_path(mesh: Mesh, stowed: np.ndarray, states: int = 21, plane: bool = True) -> FoldingPath | None:
    """Path from the stowed to the flat state.

    None for more than LARGEST vertices, and where the stowed state is flat or spread out as wide as the flat one.

    Args:
        stowed: (nv, 3) m.
        states: number of them, both ends included.
        plane: whether panels are to stay plane.
    """
    flat = np.column_stack([mesh.vertices, np.zeros(len(mesh.vertices))])
    flat_spread, stowed_spread = spread(flat), spread(stowed)
    if len(flat) > LARGEST or flat_spread - stowed_spread < 1e-9 * flat_spread:
        return None
    panels = Panels(mesh, flat, stowed, plane)
    found = [stowed]
    ajar = panels.ajar(stowed)
    if ajar is not None and spread(ajar) < flat_spread:
        found.append(ajar)
    begun = 1.0 - np.sqrt((flat_spread - spread(found[-1])) / (flat_spread - stowed_spread))
    progress = np.linspace(max(begun, 0.0), 1.0, states + 1 - len(found))
    for s in progress[1:-1]:
        start = 2.0 * found[-1] - found[-2] if len(found) > 1 else stowed
        found.append(panels.widened(start, flat_spread - (1.0 - s) ** 2 * (flat_spread - stowed_spread)))
    found.append(flat)
    strains = [np.abs(panels.strains(points)) for points in found]
    bends = [fold_angles(mesh, points)[mesh.edge_kinds == SMOOTH] for points in found]
    return FoldingPath(
        np.concatenate([[0.0], progress]) if len(found) > len(progress) else progress,
        np.array(found),
        np.array([s.max() for s in strains]),
        np.array([np.sqrt(np.mean(s**2)) for s in strains]),
        np.array([np.abs(bend).max(initial=0.0) for bend in bends]),
        np.array([find_crossing(points, mesh.edges, mesh.triangles) is not None for points in found]),
    )
