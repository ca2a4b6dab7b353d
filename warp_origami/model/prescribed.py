"""Prescribed motion: what supports hold and drivers move, as equations on the coordinates of single vertices."""

from dataclasses import dataclass

import numpy as np

from warp_origami.errors import InputError

from .coordinates import Coordinates
from .mesh import Mesh
from .profile import Profile
from .selectors import Selection, held_directions


@dataclass(frozen=True)
class Motion:
    """Rigid motion or straight path that a driver prescribes; a support has none.

    Attributes:
        profile: factor f(t).
        translate: (3,) m, reached at f = 1.
        axis, centre, angle: rotation by f * angle (rad) about the unit vector `axis` through `centre`, done first.
        overstretch: with a number, every point goes straight to where the flat sheet has it, scaled by 1 + overstretch;
            translate and rotation are then not used.
    """

    profile: Profile
    translate: np.ndarray
    axis: np.ndarray
    centre: np.ndarray
    angle: float
    overstretch: float | None = None


@dataclass(frozen=True)
class Prescriber:
    """A support (motion is None) or a driver.

    Attributes:
        name: as in the scene; None for one whose reactions nobody asked for.
        key: where the scene has it, for messages.
        selection: what it holds.
        components: subset of (0, 1, 2) for x, y, z.
        motion: of a driver.
    """

    name: str | None
    key: str
    selection: Selection
    components: tuple[int, ...]
    motion: Motion | None


@dataclass(frozen=True)
class PrescribedRows:
    """Equations a . q = d(t), each on the coordinates of one vertex, alike in its components.

    Attributes:
        vertices: (k,) vertex of each row.
        prescribers: (k,) index of the prescriber of each row.
        components: k subsets of (0, 1, 2).
        entries: k lists of (row of q, coefficient).
        slopes: (k,) bool, whether the row prescribes a slope (else a position).
        initial: (k, 3) a . q in the initial state.
        deployed: (k, 3) a . q of the flat sheet.
    """

    vertices: np.ndarray
    prescribers: np.ndarray
    components: list[tuple[int, ...]]
    entries: list[list[tuple[int, float]]]
    slopes: np.ndarray
    initial: np.ndarray
    deployed: np.ndarray


def prescribed_rows(
    mesh: Mesh, coordinates: Coordinates, prescribers: list[Prescriber], initial: np.ndarray, flat: np.ndarray
) -> PrescribedRows:
    """Rows of all prescribers, in their order: positions, then slopes along held edges or of the whole surface.

    `initial` and `flat` are q (n, 3) of the initial state and of the flat sheet.

    Raises:
        InputError: a driver prescribes a component that a support or another driver prescribes at the same vertex.
    """
    _refuse_conflicts(mesh, prescribers)
    vertices, owners, components, entries, slopes = [], [], [], [], []

    def add(vertex, owner, components_of_row, entry, slope):
        vertices.append(int(vertex))
        owners.append(owner)
        components.append(components_of_row)
        entries.append(entry)
        slopes.append(slope)

    for k, prescriber in enumerate(prescribers):
        everything = prescriber.components
        for v in prescriber.selection.vertices:
            if coordinates.positions[v] >= 0:
                add(v, k, everything, [(int(coordinates.positions[v]), 1.0)], False)
        if prescriber.selection.whole:
            for v, g in zip(coordinates.sector_vertices, coordinates.sector_gradients, strict=True):
                add(v, k, everything, [(int(g), 1.0)], True)
                add(v, k, everything, [(int(g) + 1, 1.0)], True)
            continue
        for some, others in _held_by_others(prescribers, k):
            for v, e, direction in held_directions(mesh, prescriber.selection, others):
                corner = int(np.flatnonzero(mesh.triangles[e] == v)[0])
                g = int(coordinates.elements[e, 3 * corner + 1])
                add(v, k, some, [(g, float(direction[0])), (g + 1, float(direction[1]))], True)

    def applied(q):
        return np.array([sum(w * q[i] for i, w in entry) for entry in entries]).reshape(-1, 3)

    return PrescribedRows(
        np.array(vertices, dtype=int),
        np.array(owners, dtype=int),
        components,
        entries,
        np.array(slopes, dtype=bool),
        applied(initial),
        applied(flat),
    )


def _held_by_others(prescribers: list[Prescriber], k: int) -> list[tuple[tuple[int, ...], np.ndarray]]:
    """Components of prescriber k in groups, each with the edges that other prescribers hold in these: a curved rim is
    one, whether one support holds it or several do piece by piece."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for c in prescribers[k].components:
        selections = [p.selection for j, p in enumerate(prescribers) if j != k and c in p.components]
        edges = {edge for one in selections if not one.whole for edge in one.edges.tolist()}
        groups.setdefault(tuple(sorted(edges)), []).append(c)
    return [(tuple(some), np.array(edges, dtype=int)) for edges, some in groups.items()]


def _refuse_conflicts(mesh: Mesh, prescribers: list[Prescriber]) -> None:
    holder = np.full((len(mesh.vertices), 3), -1)
    for k, prescriber in enumerate(prescribers):
        for c in prescriber.components:
            vertices = prescriber.selection.vertices
            for v in vertices[holder[vertices, c] >= 0]:
                other = prescribers[holder[v, c]]
                if prescriber.motion is not None or other.motion is not None:
                    x, y = mesh.vertices[v]
                    raise InputError(
                        prescriber.key,
                        f"{'xyz'[c]} of the vertex at ({x:g}, {y:g}), which {other.key} prescribes too",
                        "each component of a vertex prescribed by one driver only",
                    )
            free = vertices[holder[vertices, c] < 0]
            holder[free, c] = k


def prescribed_motion(
    prescribers: list[Prescriber], rows: PrescribedRows, time: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k, 3) right-hand sides d(t) of the rows and their first and second time derivatives."""
    value = rows.initial.copy()
    velocity, acceleration = np.zeros_like(value), np.zeros_like(value)
    for k, prescriber in enumerate(prescribers):
        motion = prescriber.motion
        if motion is None:
            continue
        mine = rows.prescribers == k
        start = rows.initial[mine]
        f, f1, f2 = (motion.profile(time, order) for order in range(3))
        if motion.overstretch is not None:
            path = (1.0 + motion.overstretch) * rows.deployed[mine] - start
            value[mine], velocity[mine], acceleration[mine] = start + f * path, f1 * path, f2 * path
            continue
        slope = rows.slopes[mine, None]  # slopes turn with the rotation and know nothing of places
        centre, shift = np.where(slope, 0.0, motion.centre), np.where(slope, 0.0, motion.translate)
        arm = (start - centre) @ rotation_matrix(motion.axis, f * motion.angle).T
        spin = motion.angle * np.cross(motion.axis, arm)
        value[mine] = centre + arm + f * shift
        velocity[mine] = f1 * (spin + shift)
        acceleration[mine] = f2 * (spin + shift) + f1**2 * motion.angle * np.cross(motion.axis, spin)
    return value, velocity, acceleration


def rotation_matrix(axis: np.ndarray, angle: float) -> np.ndarray:
    """(3, 3) rotation by `angle` (rad) about the unit vector `axis` (Rodrigues)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew
