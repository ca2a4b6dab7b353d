"""A crease pattern, and its stowed state, from a FOLD 1.2 file."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from .connectivity import ConnectivityError
from .fold_angles import fold_angles
from .fold_file import (
    STATE_CLASS,
    Entry,
    Frame,
    assignments_of,
    coordinates_of,
    edges_of,
    face_orders_of,
    faces_of,
    fold_angles_of,
    load_frames,
    unit_of,
)
from .letter_order import concluded_orders, find_circle, letter_orders
from .mesh import CREASE, SMOOTH, Mesh, build_mesh
from .pattern import Pattern
from .planar import coincident_vertices, find_collision
from .planar_graph import faces_of_edges
from .rigid_fold import fold_rigidly
from .triangulate import polygon_area, triangulate

FLATNESS = 1e-9
"""Heights, gaps and overlaps of the flat pattern that count as none, relative to its size."""

ISOMETRY = 1e-4
"""Relative change of length that a stowed state may have: an edge of 0.1 m with ends rounded to 0.01 mm."""

KINK = 1e-3
"""Fold angle (rad) that a stowed state may have where the sheet is smooth: the strain is its square over 8."""


@dataclass(frozen=True)
class _Creases:
    """Edges of the file.

    Attributes:
        lines: (k, 2) vertices.
        letters: (k,) as the mesh wants them.
        entry: `edges_vertices`, None where the file has none.
    """

    lines: np.ndarray
    letters: np.ndarray
    entry: Entry | None


@dataclass(frozen=True)
class _Orders:
    """Layer orders of the file.

    Attributes:
        rows: (k, 3) as in Pattern.face_orders.
        numbers: (k,) of the rows in the file.
        entry: `faceOrders`, None where the file has none.
    """

    rows: np.ndarray
    numbers: np.ndarray
    entry: Entry | None


def read_fold(path: Path) -> Pattern:
    """Pattern of a FOLD file.

    The crease pattern is the first frame of class creasePattern, else the first that is no foldedForm. The stowed state
    is the first foldedForm frame, else what `edges_foldAngle` of the crease pattern describe if they are not all zero.
    Where creases are folded shut their letters are layer orders, too.
    Without `faces_vertices` the faces are those between the edges (`model/planar_graph.py`). Faces are triangulated
    without creases and turned counter-clockwise; `Mesh.sources` are the file's vertex numbers.

    Raises:
        InputError: naming file, key and index of what is wrong.
    """
    path = Path(path)
    frames = load_frames(path)
    flat_frame, folded_frame = _choose_frames(path, frames)
    vertices = _flat_vertices(flat_frame, frames[0])
    entry = _faces_entry(flat_frame, folded_frame, vertices)
    faces = faces_of(entry, len(vertices))
    creases = _read_creases(flat_frame, entry, faces, len(vertices))
    triangles, owners = _triangulate_faces(vertices, faces, entry)
    mesh = _build(flat_frame, entry, vertices, triangles, owners, creases)
    _check_planar(mesh, entry, owners)

    angles = _fold_angles(flat_frame, creases)
    stowed = None
    if folded_frame is not None and "vertices_coords" in folded_frame.own:
        stowed = _folded_form(flat_frame, folded_frame, mesh, creases, faces)
    elif folded_frame is not None:
        angles = _fold_angles(folded_frame, creases)
        if angles is None:
            raise InputError(f"{folded_frame.name}vertices_coords", "nothing", "the folded positions of the vertices")
    if stowed is None and angles is not None:
        stowed = _fold_by_angles(folded_frame or flat_frame, mesh, creases, angles)
    orders = _face_orders(flat_frame, folded_frame, vertices, faces)
    rows = orders.rows if stowed is None else _with_letters(orders, mesh, owners, stowed, creases)
    return Pattern(mesh, stowed, owners, rows)


def _choose_frames(path: Path, frames: list[Frame]) -> tuple[Frame, Frame | None]:
    """The crease pattern's frame and that of the folded form."""
    candidates = [f for f in frames if not f.is_a("foldedForm") and f.get("vertices_coords")]
    named = [f for f in candidates if f.is_a("creasePattern")]
    if not candidates:
        raise InputError(f"{path}: vertices_coords", "no frame with a flat pattern", "a frame of class creasePattern")
    flat = (named or candidates)[0]
    folded = [f for f in frames if f.is_a("foldedForm") and not f.is_a(STATE_CLASS)]
    return flat, folded[0] if folded else None


def _flat_vertices(frame: Frame, key_frame: Frame) -> np.ndarray:
    """(n, 2) flat coordinates, m."""
    entry = frame.need("vertices_coords", "the coordinates of the flat pattern")
    points = unit_of(frame, key_frame) * coordinates_of(entry)
    size = np.linalg.norm(np.ptp(points[:, :2], axis=0))
    raised = np.abs(points[:, 2]) > FLATNESS * size
    if raised.any():
        i = int(np.argmax(raised))
        raise entry.refuse((i, 2), entry.value[i][2], "0: the crease pattern is flat (a folded state is a foldedForm)")
    return points[:, :2]


def _faces_entry(flat_frame: Frame, folded_frame: Frame | None, vertices: np.ndarray) -> Entry:
    """`faces_vertices` of the crease pattern, else of the folded form, else the faces between the edges."""
    for frame in (flat_frame, folded_frame):
        entry = None if frame is None else frame.get("faces_vertices")
        if entry is not None:
            return entry
    name = f"{flat_frame.name}faces_vertices"
    for frame in (flat_frame, folded_frame):
        orders = None if frame is None else frame.get("faceOrders")
        if orders is not None and orders.value != []:
            raise InputError(name, "nothing", "the vertices of each face, which faceOrders numbers")
    lines = flat_frame.get("edges_vertices")
    if lines is None:
        raise InputError(name, "nothing", "the vertices of each face (or edges_vertices, between which they lie)")
    edges = edges_of(lines, len(vertices))
    assignment = flat_frame.get("edges_assignment")
    letters = None if assignment is None else assignments_of(assignment, len(edges))
    return Entry(faces_of_edges(vertices, edges, letters, lines), f"{name} (found between the edges)")


def _read_creases(frame: Frame, faces_entry: Entry, faces: list[list[int]], vertex_count: int) -> _Creases:
    """Edges and letters; without `edges_assignment` edges inside the sheet are U."""
    sides = _sides(faces, faces_entry, vertex_count)
    entry = frame.get("edges_vertices")
    assignment = frame.get("edges_assignment")
    if entry is None:
        for key in ("edges_assignment", "edges_foldAngle"):
            if frame.get(key):
                raise InputError(f"{frame.name}edges_vertices", "nothing", f"the edges that {key} is about")
        lines = np.array([edge for edge, owners in sides.items() if len(owners) == 2], dtype=np.int64).reshape(-1, 2)
        return _Creases(lines, np.full(len(lines), "U"), None)

    lines = edges_of(entry, vertex_count)
    listed = set()
    for i, (a, b) in enumerate(lines.tolist()):
        edge = (min(a, b), max(a, b))
        listed.add(edge)
        if edge not in sides:
            raise entry.refuse(i, [a, b], "a side of a face in faces_vertices")
    for edge, owners in sides.items():
        if len(owners) == 2 and edge not in listed:
            raise faces_entry.fault(owners[1], f"the side {list(edge)}", "every side between faces in edges_vertices")
    inner = np.array([len(sides[min(a, b), max(a, b)]) == 2 for a, b in lines.tolist()], dtype=bool)
    if assignment is None:
        return _Creases(lines, np.where(inner, "U", "B"), entry)
    letters = assignments_of(assignment, len(lines))
    for i in np.flatnonzero((letters == "B") & inner):
        raise assignment.refuse(int(i), "B", "another letter: faces lie on both sides of this edge (C is a cut)")
    for i in np.flatnonzero(np.isin(letters, ["M", "V"]) & ~inner):
        raise assignment.refuse(int(i), str(letters[i]), "B: this edge has a face on one side only")
    return _Creases(lines, letters, entry)


def _sides(faces: list[list[int]], entry: Entry, vertex_count: int) -> dict[tuple[int, int], list[int]]:
    """Faces at each side, by its vertices in increasing order."""
    sides: dict[tuple[int, int], list[int]] = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            owners = sides.setdefault((min(a, b), max(a, b)), [])
            owners.append(f)
            if len(owners) > 2:
                raise entry.refuse(f, face, f"at most 2 faces at the edge {[a, b]} (faces {owners[0]}, {owners[1]})")
    return sides


def _triangulate_faces(vertices, faces, entry) -> tuple[np.ndarray, np.ndarray]:
    """Triangles and the face of each."""
    triangles, owners = [], []
    for f, face in enumerate(faces):
        local = triangulate(vertices[face])
        if local is None:
            raise entry.refuse(f, face, "a simple polygon with an area and no two vertices in one place")
        triangles.append(np.asarray(face)[local])
        owners.append(np.full(len(local), f))
    return np.concatenate(triangles), np.concatenate(owners)


def _build(frame, entry, vertices, triangles, owners, creases) -> Mesh:
    try:
        return build_mesh(vertices, triangles, creases.lines, creases.letters)
    except ConnectivityError as error:
        at = [f for f, t in zip(owners, triangles, strict=True) if set(error.ends) <= set(t.tolist())]
        raise entry.fault(int(at[-1]), f"the side {list(error.ends)}", f"no overlap: {error.reason}") from None


def _check_planar(mesh: Mesh, entry: Entry, owners: np.ndarray) -> None:
    """Refuses flat patterns whose faces overlap, meet in part of a side, or have vertices in the same place."""
    given = np.unique(mesh.sources, return_index=True)[1]  # a cut's copies lie in one place
    same = coincident_vertices(mesh.vertices[given], FLATNESS * mesh.size)
    if same is not None:
        a, b = (int(mesh.sources[given[k]]) for k in same)
        raise InputError(
            entry.name.replace("faces_vertices", f"vertices_coords[{b}]"),
            f"the place of vertex {a}",
            "one vertex where faces meet (edges of a cut have the letter C), separate sheets apart",
        )
    whole = mesh.sources[mesh.triangles]
    points = np.zeros((mesh.sources.max() + 1, 2))
    points[mesh.sources] = mesh.vertices
    collision = find_collision(points, whole, FLATNESS * mesh.size)
    if collision is None:
        return
    f, g = (int(owners[t]) for t in collision.triangles)
    if collision.vertex is None:
        raise entry.fault(f, f"overlap with face {g}", "faces side by side in the flat pattern")
    raise entry.fault(g, f"vertex {collision.vertex} on a side", "every vertex on its sides among its vertices")


def _fold_angles(frame: Frame, creases: _Creases) -> np.ndarray | None:
    """(k,) fold angle of each edge of the file, rad; None where the file has none or all are zero."""
    entry = frame.get("edges_foldAngle")
    if entry is None or creases.entry is None:
        return None
    angles = fold_angles_of(entry, len(creases.lines))
    for letter, wrong, wants in (
        ("M", angles > 0, "a negative angle: the edge is a mountain (M)"),
        ("V", angles < 0, "a positive angle: the edge is a valley (V)"),
        ("FJB", np.abs(angles) > 0, "0: the edge is no crease"),
    ):
        for i in np.flatnonzero(wrong & np.isin(creases.letters, list(letter))):
            raise entry.refuse(int(i), entry.value[i], wants)
    folds = np.isin(creases.letters, list("MVU"))
    if not np.any(np.abs(angles[folds]) > 0):
        return None
    for i in np.flatnonzero(folds & np.isnan(angles)):
        raise entry.fault(int(i), "null", "an angle (other creases have one)")
    return np.radians(np.where(folds, angles, 0.0))


def _fold_by_angles(frame: Frame, mesh: Mesh, creases: _Creases, angles: np.ndarray) -> np.ndarray:
    """(nv, 3) stowed positions from fold angles, m."""
    by_edge = {(min(a, b), max(a, b)): x for (a, b), x in zip(creases.lines.tolist(), angles, strict=True)}
    mesh_angles = np.zeros(len(mesh.edges))
    for d in np.flatnonzero(mesh.edge_kinds == CREASE):
        a, b = mesh.sources[mesh.edges[d]].tolist()
        mesh_angles[d] = by_edge[min(a, b), max(a, b)]
    points, gap = fold_rigidly(mesh, mesh_angles)
    if gap.max() > ISOMETRY * mesh.size:
        v = int(np.argmax(gap))
        raise frame.get("edges_foldAngle").fault(
            None,
            f"panels that miss each other by {gap[v]:.3g} m at vertex {mesh.sources[v]}",
            f"angles of a rigid fold (within {ISOMETRY:g} of the size)",
        )
    _check_stress_free(frame.get("edges_foldAngle"), mesh, points, creases)
    return points


def _folded_form(flat_frame: Frame, frame: Frame, mesh: Mesh, creases: _Creases, faces: list) -> np.ndarray:
    """(nv, 3) stowed positions from a foldedForm frame, m."""
    entry = frame.get("vertices_coords")
    count = len(flat_frame.get("vertices_coords").value)
    points = unit_of(frame, flat_frame) * coordinates_of(entry)
    if len(points) != count:
        raise entry.fault(None, f"{len(points)} points", f"{count}, one for each vertex of the crease pattern")
    own = frame.get("faces_vertices") if "faces_vertices" in frame.own else None
    if own is not None:
        same = [sorted(face) for face in faces_of(own, count)] == [sorted(face) for face in faces]
        if not same:
            raise own.fault(None, "other faces", "the faces of the crease pattern, or none")
    stowed = points[mesh.sources]
    _check_stress_free(entry, mesh, stowed, creases)
    return stowed


def _check_stress_free(entry: Entry, mesh: Mesh, points: np.ndarray, creases: _Creases) -> None:
    """Refuses a stowed state that stretches a side of a triangle or is kinked where there is no crease."""
    a, b = mesh.edges.T
    flat = np.linalg.norm(mesh.vertices[b] - mesh.vertices[a], axis=1)
    stretch = np.linalg.norm(points[b] - points[a], axis=1) / flat - 1.0
    if np.abs(stretch).max() > ISOMETRY:
        d = int(np.argmax(np.abs(stretch)))
        raise entry.fault(
            None,
            f"{_name_edge(mesh, d, creases)} stretched by {stretch[d]:.3g}",
            f"a folded state with the flat pattern's lengths (to {ISOMETRY:g}, relative)",
        )
    kink = np.where(mesh.edge_kinds == SMOOTH, np.abs(fold_angles(mesh, points)), 0.0)
    if kink.max() > KINK:
        d = int(np.argmax(kink))
        raise entry.fault(
            None,
            f"{_name_edge(mesh, d, creases)} folded by {np.degrees(kink[d]):.3g} degrees",
            "folds at creases only (M, V, U): faces stay plane, and F and J edges are smooth",
        )


def _name_edge(mesh: Mesh, d: int, creases: _Creases) -> str:
    """What to call a mesh edge: its number in the file if it has one."""
    ends = mesh.sources[mesh.edges[d]].tolist()
    numbers = np.flatnonzero((np.sort(creases.lines, axis=1) == sorted(ends)).all(axis=1))
    name = f"edge {numbers[0]}" if creases.entry and len(numbers) else "the line"
    return f"{name} between vertices {ends[0]} and {ends[1]}"


def _face_orders(flat_frame: Frame, folded_frame: Frame | None, vertices: np.ndarray, faces: list) -> _Orders:
    """Rows with s about the normal of the counter-clockwise face g; unknown orders are left out."""
    frame = folded_frame if folded_frame is not None and folded_frame.get("faceOrders") else flat_frame
    entry = frame.get("faceOrders")
    if entry is None:
        return _Orders(np.zeros((0, 3), dtype=int), np.zeros(0, dtype=int), None)
    own = frame.get("faces_vertices")  # its faces, which may be turned
    faces = faces if own is None else own.value
    orders = face_orders_of(entry, len(faces))
    numbers = np.flatnonzero(orders[:, 2] != 0)
    orders = orders[numbers]
    clockwise = np.array([polygon_area(vertices[face].tolist()) < 0 for face in faces])
    orders[clockwise[orders[:, 1]], 2] *= -1
    return _Orders(orders, numbers, entry)


def _with_letters(orders: _Orders, mesh: Mesh, owners: np.ndarray, stowed: np.ndarray, creases: _Creases) -> np.ndarray:
    """(k, 3) the rows of the file, what the letters of creases folded shut tell, and what follows from both.

    Raises:
        InputError: both contradict each other, or faces lie above each other in a circle.
    """
    told = letter_orders(mesh, owners, stowed)
    known = set()
    for number, (f, g, side) in zip(orders.numbers.tolist(), orders.rows.tolist(), strict=True):
        pair = min(f, g), max(f, g)
        known.add(pair)
        letter_side, d = told.get(pair, (side, 0))
        if side != letter_side:
            wants = f"the order of its letter, {mesh.edge_assignments[d]}: {_name_edge(mesh, d, creases)} joins them"
            raise orders.entry.refuse(number, orders.entry.value[number], wants)
    more = [(f, g, side) for (f, g), (side, _) in told.items() if (f, g) not in known]
    rows = np.concatenate([orders.rows, np.array(more, dtype=int).reshape(-1, 3)])
    rows = np.array([*rows.tolist(), *concluded_orders(mesh, owners, rows, stowed)], dtype=int).reshape(-1, 3)
    circle = find_circle(mesh, owners, rows, stowed)
    if circle is not None:
        above = " above ".join(str(f) for f in (*circle, circle[0]))
        name = creases.entry.name.replace("edges_vertices", "edges_assignment") if orders.entry is None else ""
        entry = orders.entry or Entry(None, name)
        raise entry.fault(None, f"face {above}", "layers in one order wherever they lie on each other")
    return rows
