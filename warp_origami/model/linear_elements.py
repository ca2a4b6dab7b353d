"""Linear elements: plane triangles of constant strain, as cubic ones whose gradients follow from the positions.

The shape functions are complete for linear fields: where all gradients of an element are those of the plane through its
corners,

    grad r = sum_k r_k grad L_k,   L_k the area coordinates,

the element is that plane triangle, with constant strain and the consistent mass. With a sector of its own for every
element the sheet may fold along every edge. These equations stand in the place of the fold lines' (48), which they
imply, and of prescribed slopes, which follow from the positions that are prescribed with them:

    q = T y + P d(t),   y the free components of positions and of the rows of a hub, R q = y.

For sheets without bending stiffness that fold sharply where no crease is: cubic elements lock against bending.
Source: the constant strain triangle, e.g. O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, vol. 1, ch. 4.
"""

import numpy as np
from scipy.sparse import csr_matrix, hstack, identity, kron, vstack

from .constraints import FOLD_SOURCE, TIE_SOURCE, Constraints
from .coordinates import Coordinates
from .hub import ROWS, Hub
from .mesh import Mesh
from .prescribed import PrescribedRows, Prescriber


def build_linear_constraints(
    mesh: Mesh, coordinates: Coordinates, prescribers: list[Prescriber], rows: PrescribedRows, hub: Hub | None = None
) -> Constraints:
    """Equations of all gradients, of points that are fixed to a hub, and of prescribed positions."""
    own = np.zeros(coordinates.count, dtype=bool)
    own[coordinates.positions[coordinates.positions >= 0]] = True
    gradients = ~own
    ties = _ties(coordinates.count, hub)
    tied = np.diff(ties.indptr) > 0
    if hub is not None:
        own[hub.rows], gradients[hub.rows] = True, False
    own[tied] = False

    slopes = _gradients_from_positions(mesh, coordinates)
    positions = _selection(own) + ties
    everything = _for_components(positions + slopes @ positions)
    held = _held(rows, own)
    places = np.array(list(held), dtype=int)
    free = np.repeat(own, 3)
    free[places] = False
    free = np.flatnonzero(free)

    unit = identity(3 * coordinates.count, format="csr")
    slaves, fixed = np.flatnonzero(np.repeat(gradients, 3)), np.flatnonzero(np.repeat(tied, 3))
    equations = [(unit - _for_components(slopes))[slaves], (unit - _for_components(ties))[fixed], unit[places]]
    inverse = [unit[:, slaves], (unit + _for_components(slopes))[:, fixed], everything[:, places]]
    sources = [np.full(len(slaves), FOLD_SOURCE), np.full(len(fixed), TIE_SOURCE), np.array(list(held.values()), int)]
    return Constraints(
        equations=vstack(equations, format="csr"),
        null_space=everything[:, free].tocsr(),
        right_inverse=hstack(inverse, format="csr"),
        left_inverse=unit[free],
        sources=np.concatenate(sources),
        components=np.concatenate([slaves, fixed, places]) % 3,
        dropped=sum(len(components) for components in rows.components) - len(places),
        prescribers=prescribers,
        rows=rows,
    )


def _for_components(matrix: csr_matrix) -> csr_matrix:
    """(3n, 3n) matrix on q.ravel() that acts alike on x, y and z."""
    return kron(matrix, identity(3), format="csr")


def _ties(count: int, hub: Hub | None) -> csr_matrix:
    """(n, n) matrix that gives the positions of points fixed to a hub from its rows; their slopes follow."""
    points = [] if hub is None else [tie for tie in hub.ties if len(tie.entries) == 1]
    row = np.repeat([tie.entries[0][0] for tie in points], ROWS).astype(int)
    column = np.tile(hub.rows, len(points)) if points else row
    weight = np.concatenate([tie.hub for tie in points]) if points else np.zeros(0)
    return csr_matrix((weight, (row, column)), shape=(count, count))


def _gradients_from_positions(mesh: Mesh, coordinates: Coordinates) -> csr_matrix:
    """(n, n) matrix whose rows of gradients give r_x, r_y from the positions of their element."""
    corners = mesh.vertices[mesh.triangles]
    sides = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)  # of each corner, the side that faces it
    slopes = np.stack([-sides[:, :, 1], sides[:, :, 0]], axis=2) / (2.0 * mesh.areas[:, None, None])  # grad L_k
    nodes = coordinates.elements.reshape(-1, 3, 3)
    row = np.broadcast_to(nodes[:, :, None, 1:], (len(nodes), 3, 3, 2))  # element, corner, vertex, x or y
    column = np.broadcast_to(nodes[:, None, :, :1], row.shape)
    weight = np.broadcast_to(slopes[:, None, :, :], row.shape)
    shape = (coordinates.count, coordinates.count)
    return csr_matrix((weight.ravel(), (row.ravel(), column.ravel())), shape=shape)


def _selection(rows: np.ndarray) -> csr_matrix:
    """(n, n) matrix that keeps the rows (n,) bool and drops the others."""
    kept = np.flatnonzero(rows)
    return csr_matrix((np.ones(len(kept)), (kept, kept)), shape=(len(rows), len(rows)))


def _held(rows: PrescribedRows, own: np.ndarray) -> dict[int, int]:
    """Row of q.ravel() that is prescribed, of the rows `own` (n,) bool -> the first equation that does so."""
    held: dict[int, int] = {}
    for k, entries in enumerate(rows.entries):
        row = entries[0][0]
        if own[row]:
            for component in rows.components[k]:
                held.setdefault(3 * row + component, k)
    return held
