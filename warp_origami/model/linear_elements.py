"""Linear elements: plane triangles of constant strain, as cubic ones whose gradients follow from the positions.

The shape functions are complete for linear fields: where all gradients of an element are those of the plane through its
corners,

    grad r = sum_k r_k grad L_k,   L_k the area coordinates,

the element is that plane triangle, with constant strain and the consistent mass. With a sector of its own for every
element the sheet may fold along every edge. These equations stand in the place of the fold lines' (48), which they
imply, and of prescribed slopes, which follow from the positions that are prescribed with them:

    q = T y + P d(t),   y the free components of positions, R y = q there.

For sheets without bending stiffness that fold sharply where no crease is: cubic elements lock against bending.
Source: the constant strain triangle, e.g. O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, vol. 1, ch. 4.
"""

import numpy as np
from scipy.sparse import csr_matrix, hstack, identity, kron, vstack

from .constraints import Constraints
from .coordinates import Coordinates
from .mesh import Mesh
from .prescribed import PrescribedRows, Prescriber


def build_linear_constraints(
    mesh: Mesh, coordinates: Coordinates, prescribers: list[Prescriber], rows: PrescribedRows
) -> Constraints:
    """Equations of all gradients and of prescribed positions."""
    gradients = _gradients_from_positions(mesh, coordinates)
    positions = np.zeros(coordinates.count, dtype=bool)
    positions[coordinates.positions[coordinates.positions >= 0]] = True
    everything = kron(gradients + _selection(positions), identity(3), format="csr")

    held = _held(rows)
    places = np.array(list(held), dtype=int)
    free = np.repeat(positions, 3)
    free[places] = False
    free = np.flatnonzero(free)
    slaves = np.flatnonzero(np.repeat(~positions, 3))

    unit = identity(3 * coordinates.count, format="csr")
    equations = vstack([(unit - kron(gradients, identity(3), format="csr"))[slaves], unit[places]], format="csr")
    equations_asked = sum(len(components) for components in rows.components)
    return Constraints(
        equations=equations,
        null_space=everything[:, free].tocsr(),
        right_inverse=hstack([unit[:, slaves], everything[:, places]], format="csr"),
        left_inverse=unit[free],
        sources=np.concatenate([np.full(len(slaves), -1), np.array(list(held.values()), dtype=int)]),
        components=np.concatenate([slaves % 3, places % 3]),
        dropped=equations_asked - len(places),
        prescribers=prescribers,
        rows=rows,
    )


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


def _held(rows: PrescribedRows) -> dict[int, int]:
    """Row of q.ravel() that is prescribed -> the first equation that does so."""
    held: dict[int, int] = {}
    for k in np.flatnonzero(~rows.slopes):
        ((row, _),) = rows.entries[k]
        for component in rows.components[k]:
            held.setdefault(3 * row + component, int(k))
    return held
