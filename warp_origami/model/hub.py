"""A rigid hub: an affine body whose coordinates are further rows of q, to which points of the sheet are tied.

    x(X) = c + X_1 d_1 + X_2 d_2 + X_3 d_3

c is the centre of mass and d_k a frame that is orthonormal at the start and kept so by a stiff energy (terms/hub.py).
What is fixed to the body then depends on q linearly with constant coefficients, alike in x, y, z, as folds do:

    r_v = c + sum_k X_k d_k,     tau . grad r_v = sum_k (tau . grad X_k) d_k

Source: L. Lan, D. M. Kaufman, M. Li, C. Jiang, Y. Yang, Affine body dynamics, ACM Trans. Graphics 41 (2022) 67.
"""

from dataclasses import dataclass, replace

import numpy as np

from .coordinates import Coordinates
from .mesh import Mesh
from .prescribed import Motion, PrescribedRows, Prescriber
from .selectors import Selection, held_directions

ROWS = 4
"""Rows of q of a hub: c, d_1, d_2, d_3."""


@dataclass(frozen=True)
class Tie:
    """An equation sum_i w_i q_i = sum_k h_k (c, d_1, d_2, d_3)_k on the coordinates of one vertex.

    Attributes:
        vertex: of the mesh.
        entries: pairs (row of q, w).
        hub: (4,) h.
    """

    vertex: int
    entries: list[tuple[int, float]]
    hub: np.ndarray


@dataclass(frozen=True)
class Hub:
    """A hub in its initial state.

    Attributes:
        first: row of c; those of d_1, d_2, d_3 follow.
        vertex: the number by which equations on its coordinates go, one more than the mesh's vertices have.
        centre: (3,) c, m.
        frame: (3, 3) rows d_1, d_2, d_3; d_3 along the axis.
        ties: what is fixed to it.
        radius: its size, m: the largest distance of what is fixed from c, at least its radius of gyration.
    """

    first: int
    vertex: int
    centre: np.ndarray
    frame: np.ndarray
    ties: list[Tie]
    radius: float

    @property
    def rows(self) -> np.ndarray:
        """(4,) rows of q."""
        return self.first + np.arange(ROWS)

    @property
    def state(self) -> np.ndarray:
        """(4, 3) these rows of q at the start."""
        return np.vstack([self.centre, self.frame])


def frame_along(axis: np.ndarray) -> np.ndarray:
    """(3, 3) rows of a right-handed orthonormal frame whose third vector is along `axis`."""
    third = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    first = np.eye(3)[np.argmin(np.abs(third))]
    first = first - (first @ third) * third
    first /= np.linalg.norm(first)
    return np.vstack([first, np.cross(third, first), third])


def fasten_hub(
    mesh: Mesh,
    coordinates: Coordinates,
    selection: Selection,
    q0: np.ndarray,
    axis: np.ndarray,
    centre: np.ndarray | None,
    gyration: float,
) -> Hub:
    """Hub to which selected vertices are fixed, elements that are selected as a whole, and boundary edges between
    selected vertices along their whole length.

    `coordinates` have its rows behind those of the sheet; `q0` (n, 3) is the initial state of the sheet;
    `gyration` the hub's radius of gyration, m.
    """
    positions = coordinates.positions[selection.vertices]
    centre = q0[positions].mean(axis=0) if centre is None else np.asarray(centre, dtype=float)
    frame = frame_along(axis)
    ties = [
        Tie(int(v), [(int(row), 1.0)], np.concatenate([[1.0], frame @ (q0[row] - centre)]))
        for v, row in zip(selection.vertices, positions, strict=True)
    ]
    for v, e, direction in _fixed_directions(mesh, selection):
        corner = int(np.flatnonzero(mesh.triangles[e] == v)[0])
        g = int(coordinates.elements[e, 3 * corner + 1])
        x, y = (float(part) for part in direction)
        slope = x * q0[g] + y * q0[g + 1]
        ties.append(Tie(v, [(g, x), (g + 1, y)], np.concatenate([[0.0], frame @ slope])))
    radius = max(gyration, float(np.linalg.norm(q0[positions] - centre, axis=1).max()))
    return Hub(coordinates.count - ROWS, len(mesh.vertices), centre, frame, ties, radius)


def _fixed_directions(mesh: Mesh, selection: Selection) -> list[tuple[int, int, np.ndarray]]:
    """Directions in which slopes go with the hub, as held_directions: along held boundary edges as a support holds
    them, so that a polygon that stands for a curve does not hold more than its mean direction; and along all edges of
    elements that are selected as a whole, which do not deform."""
    rows = held_directions(mesh, selection)
    fixed = np.zeros(len(mesh.vertices), dtype=bool)
    fixed[selection.vertices] = True
    for e in np.flatnonzero(fixed[mesh.triangles].all(axis=1)).tolist():
        corners = mesh.triangles[e].tolist()
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            along = mesh.vertices[b] - mesh.vertices[a]
            rows += [(v, e, along / np.linalg.norm(along)) for v in (a, b)]
    return rows


def hold_hub(
    hub: Hub, mount: str, motion: Motion | None, prescribers: list[Prescriber], rows: PrescribedRows
) -> tuple[list[Prescriber], PrescribedRows]:
    """Prescribers and their rows, with those of the hub.

    Args:
        mount: "free": none; "axis": c and d_3 stay, d_1 and d_2 turn about it; "driven": all follow `motion`.
    """
    held = {"free": [], "axis": [0, 3], "driven": [0, 1, 2, 3]}[mount]
    if not held:
        return prescribers, rows
    nothing = Selection(np.zeros(0, dtype=int), np.zeros(0, dtype=int), False)
    everything = (0, 1, 2)
    mine = hub.state[held]
    return [*prescribers, Prescriber("hub", "hub", nothing, everything, motion)], replace(
        rows,
        vertices=np.append(rows.vertices, np.full(len(held), hub.vertex)),
        prescribers=np.append(rows.prescribers, np.full(len(held), len(prescribers))),
        components=[*rows.components, *[everything] * len(held)],
        entries=[*rows.entries, *[[(hub.first + k, 1.0)] for k in held]],
        slopes=np.append(rows.slopes, np.array(held) > 0),
        initial=np.vstack([rows.initial, mine]),
        deployed=np.vstack([rows.deployed, mine]),
    )
