"""A pattern as a FOLD 1.2 file: crease pattern, stowed state, further states of the same sheet.

Format: https://github.com/edemaine/fold/blob/main/doc/spec.md. The key frame is the crease pattern; its faces are the
elements, and sides between elements of one face are joins (J), so that reading the file gives the same mesh. The
stowed state and all others are frames that inherit everything but the coordinates from it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .fold_angles import fold_angles
from .fold_file import STATE_CLASS
from .mesh import CREASE, Mesh
from .pattern import Pattern
from .planar import separation

SAME_PLACE = 1e-9
"""Distance of the lips of a cut in the flat sheet, relative to its size."""

TIME_KEY = "warp_origami:time"
"""Of a frame: s, or the load factor in statics."""


@dataclass(frozen=True)
class State:
    """The sheet at one time.

    Attributes:
        time: s.
        points: (nv, 3) positions of the mesh's vertices, m.
    """

    time: float
    points: np.ndarray


def fold_document(pattern: Pattern, title: str, creator: str, states: Iterable[State] = ()) -> dict:
    """Content of a FOLD file, for `json.dump`.

    Args:
        title: of the pattern.
        creator: program and version.
        states: frames after the stowed state; their coordinates are taken for single precision if they are float32.
    """
    mesh = pattern.mesh
    sheet = _Sheet(mesh)
    frames = []
    if pattern.stowed is not None:
        frames.append(_stowed_frame(pattern, sheet))
    parent = 0
    states = list(states)
    if states and sheet.cut:
        frames.append(_opened_frame(mesh))
        parent = len(frames)
    frames += [_state_frame(state, parent, sheet) for state in states]
    letters = set(sheet.letters.tolist())
    document = {
        "file_spec": 1.2,
        "file_creator": creator,
        "file_title": title,
        "file_classes": ["singleModel", "animation"] if states else ["singleModel"],
        "frame_title": "crease pattern",
        "frame_classes": ["creasePattern"],
        "frame_attributes": [
            "2D",
            "manifold",
            "orientable",
            "nonSelfTouching",
            "convexFaces",
            "joins" if "J" in letters else "noJoins",
            "cuts" if "C" in letters else "noCuts",
        ],
        "frame_unit": "m",
        "vertices_coords": mesh.vertices[sheet.kept].tolist(),
        "edges_vertices": sheet.edges.tolist(),
        "edges_assignment": sheet.letters.tolist(),
        "faces_vertices": sheet.number[mesh.triangles].tolist(),
    }
    return document | ({"file_frames": frames} if frames else {})


class _Sheet:
    """The mesh with the lips of its cuts joined again, as FOLD has them.

    Attributes:
        number: (nv,) vertex in the file of each vertex of the mesh.
        kept: (n,) vertex of the mesh for each in the file.
        edges, letters: (k, 2) vertices in the file and the letter of each edge.
        first: (k,) one of the mesh edges of each.
        cut: whether there are cuts.
    """

    def __init__(self, mesh: Mesh):
        number = np.arange(len(mesh.vertices))
        for a, b in sorted(cKDTree(mesh.vertices).query_pairs(SAME_PLACE * mesh.size)):
            number[number == number[b]] = number[a]
        self.kept, self.number = np.unique(number, return_inverse=True)
        ends = np.sort(self.number[mesh.edges], axis=1)
        _, first, count = np.unique(ends, axis=0, return_index=True, return_counts=True)
        order = np.argsort(first)
        self.first, count = first[order], count[order]
        self.edges = self.number[mesh.edges[self.first]]
        letters = np.where(mesh.edge_assignments == "F", "J", mesh.edge_assignments)[self.first]
        self.letters = np.where(count > 1, "C", letters)
        self.cut = bool(np.any(count > 1)) or len(self.kept) < len(mesh.vertices)


def _stowed_frame(pattern: Pattern, sheet: _Sheet) -> dict:
    mesh = pattern.mesh
    angles = np.degrees(fold_angles(mesh, pattern.stowed))
    shut = (np.abs(angles) > 180.0 - 1e-6) & (mesh.edge_kinds == CREASE)
    angles[shut] = 180.0
    angles[mesh.edge_kinds != CREASE] = 0.0
    mountain = mesh.edge_assignments == "M"
    angles[mountain & shut] = -180.0
    orders = _element_orders(pattern)
    frame = {
        "frame_title": "stowed",
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["3D", "manifold", "orientable", "selfTouching" if len(orders) else "nonSelfTouching"],
        "frame_parent": 0,
        "frame_inherit": True,
        "vertices_coords": pattern.stowed[sheet.kept].tolist(),
        "edges_foldAngle": angles[sheet.first].tolist(),
    }
    return frame | ({"faceOrders": orders.tolist()} if len(orders) else {})


def _opened_frame(mesh: Mesh) -> dict:
    """The crease pattern with the two sides of its cuts as boundaries of their own, which states move apart."""
    letters = np.where(mesh.edge_assignments == "F", "J", mesh.edge_assignments)
    return {
        "frame_title": "crease pattern, cuts opened",
        "frame_classes": ["creasePattern"],
        "frame_parent": 0,
        "frame_inherit": True,
        "vertices_coords": mesh.vertices.tolist(),
        "edges_vertices": mesh.edges.tolist(),
        "edges_assignment": letters.tolist(),
        "faces_vertices": mesh.triangles.tolist(),
    }


def _state_frame(state: State, parent: int, sheet: _Sheet) -> dict:
    points = state.points if parent else state.points[sheet.kept]
    if points.dtype == np.float32:  # the shortest numbers that are the same in single precision
        coordinates: Sequence = [[float(str(x)) for x in point] for point in points]
    else:
        coordinates = points.tolist()
    return {
        "frame_title": f"t = {state.time:.6g}",
        "frame_classes": ["foldedForm", STATE_CLASS],
        "frame_attributes": ["3D", "manifold", "orientable"],
        "frame_parent": parent,
        "frame_inherit": True,
        "vertices_coords": coordinates,
        TIME_KEY: state.time,
    }


def _element_orders(pattern: Pattern) -> np.ndarray:
    """(k, 3) rows (f, g, s) for the elements of the faces that lie on each other, where these overlap."""
    mesh, orders = pattern.mesh, pattern.face_orders
    if not len(orders):
        return orders
    elements = [np.flatnonzero(pattern.pattern_faces == f) for f in range(int(orders[:, :2].max()) + 1)]
    rows = []
    for f, g, side in orders.tolist():
        own, other = elements[f], elements[g]
        one, two = (pair.ravel() for pair in np.meshgrid(own, other, indexing="ij"))
        rows.append(np.stack([one, two, np.full(len(one), side)], axis=1))
    rows = np.concatenate(rows)
    one, two = (pattern.stowed[mesh.triangles[rows[:, k]]] for k in (0, 1))
    along = two[:, 1] - two[:, 0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normal = np.cross(along, two[:, 2] - two[:, 0])
    across = np.cross(normal / np.linalg.norm(normal, axis=1, keepdims=True), along)
    axes = np.stack([along, across], axis=2)
    flat = [_counter_clockwise((corners - two[:, :1]) @ axes) for corners in (one, two)]
    return rows[np.maximum(separation(*flat), separation(*flat[::-1])) < -1e-9 * mesh.size]


def _counter_clockwise(triangles: np.ndarray) -> np.ndarray:
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    clockwise = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] < 0.0
    triangles = triangles.copy()
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    return triangles
