"""The frames of a FOLD 1.2 file, checked entry by entry.

Format: https://github.com/edemaine/fold/blob/main/doc/spec.md
"""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from .limits import MOST_CORNERS, MOST_FRAMES, check_elements

MAX_BYTES = 100_000_000
MAX_COORDINATE = 1e9
METRES = {
    "unit": 1.0,
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "in": 0.0254,
    "pt": 0.0254 / 72.0,
}
ASSIGNMENTS = "BMVFUCJ"
STATE_CLASS = "warp_origami:state"
"""Class of the folded forms that are states of a run: none of them is the stowed state."""


@dataclass(frozen=True)
class Entry:
    """A value of the file and what to call it in a message: file, frame and key."""

    value: object
    name: str

    def refuse(self, index: object, got: object, wants: str) -> InputError:
        """Error that quotes an element of the value; `index` is like 3 or (3, 1), None for the whole."""
        return self.fault(index, shorten(got), wants)

    def fault(self, index: object, found: str, wants: str) -> InputError:
        """Error about an element of the value, in words."""
        indices = () if index is None else index if isinstance(index, tuple) else (index,)
        return InputError(self.name + "".join(f"[{i}]" for i in indices), found, wants)


@dataclass(frozen=True)
class Frame:
    """Entries of a frame by key, inherited ones included.

    Attributes:
        name: what to call the frame in a message.
        entries: all its entries.
        own: keys that the frame itself has.
    """

    name: str
    entries: dict[str, Entry]
    own: frozenset[str]

    def get(self, key: str) -> Entry | None:
        """Entry of a key, None where it is missing or null."""
        entry = self.entries.get(key)
        return None if entry is None or entry.value is None else entry

    def need(self, key: str, wants: str) -> Entry:
        """Entry of a key that must be there."""
        entry = self.get(key)
        if entry is None:
            raise InputError(f"{self.name}{key}", "nothing", wants)
        return entry

    def is_a(self, kind: str) -> bool:
        """Whether `frame_classes` names the kind."""
        entry = self.get("frame_classes")
        return entry is not None and kind in entry.value


def load_frames(path: Path) -> list[Frame]:
    """The key frame and `file_frames`, each with what it inherits.

    Raises:
        InputError: the file cannot be read, is no JSON object, or its frames are malformed.
    """
    data = _load_json(path)
    frames = data.get("file_frames", [])
    if not isinstance(frames, list):
        raise InputError(f"{path}: file_frames", shorten(frames), "a list of frames")
    if len(frames) > MOST_FRAMES:
        raise InputError(f"{path}: file_frames", f"{len(frames)} frames", f"at most {MOST_FRAMES}")
    for i, frame in enumerate(frames):
        if not isinstance(frame, dict):
            raise InputError(f"{path}: file_frames[{i}]", shorten(frame), "an object")
    key_frame = {k: v for k, v in data.items() if not k.startswith("file_")}
    raw = [key_frame, *frames]
    names = [f"{path}: ", *(f"{path}: file_frames[{i}]." for i in range(len(frames)))]
    return [_inherit(i, raw, names) for i in range(len(raw))]


def _load_json(path: Path) -> dict:
    try:
        if path.exists() and not path.is_file():  # a pipe or a device would be read for ever
            raise InputError(f"{path}", "no regular file", "a FOLD file")
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise InputError(f"{path}", "a larger file", f"a FOLD file of at most {MAX_BYTES} bytes")
        data = json.loads(content.decode("utf-8-sig"))
    except OSError as error:
        raise InputError(f"{path}", error.strerror or type(error).__name__, "a FOLD file that can be read") from None
    except RecursionError:
        raise InputError(f"{path}", "lists or objects nested too deeply", "a FOLD file (JSON)") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}", f"no UTF-8 at byte {error.start}", "a FOLD file (JSON)") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: line {error.lineno}", error.msg, "a FOLD file (JSON)") from None
    except ValueError as error:  # a whole number of thousands of digits
        raise InputError(f"{path}", str(error), "a FOLD file (JSON)") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}", shorten(data), "a FOLD file: an object at the top")
    return data


def _inherit(index: int, raw: list[dict], names: list[str]) -> Frame:
    """Frame with the entries of its ancestors that it does not override (`frame_inherit`, `frame_parent`)."""
    entries: dict[str, Entry] = {}
    at, seen = index, set()
    while True:
        seen.add(at)
        frame = raw[at]
        for key, value in frame.items():
            entries.setdefault(key, Entry(value, names[at] + key))
        inherit = frame.get("frame_inherit", False)
        if not isinstance(inherit, bool):
            raise InputError(f"{names[at]}frame_inherit", shorten(inherit), "true or false")
        if at == 0 or not inherit:
            break
        parent = frame.get("frame_parent", 0)
        if not _is_index(parent, len(raw)):
            raise InputError(f"{names[at]}frame_parent", shorten(parent), f"a frame, 0 to {len(raw) - 1}")
        if parent in seen:
            raise InputError(f"{names[at]}frame_parent", parent, "a frame that does not inherit from this one")
        at = parent
    classes = entries.get("frame_classes")
    if classes is not None and classes.value is not None:
        if not isinstance(classes.value, list) or not all(isinstance(c, str) for c in classes.value):
            raise InputError(classes.name, shorten(classes.value), "a list of names")
    return Frame(names[index], entries, frozenset(raw[index]))


def unit_of(*frames: Frame) -> float:
    """Metres per unit, from the first of the frames that states it; 1 where none does."""
    for frame in frames:
        entry = frame.get("frame_unit")
        if entry is not None:
            if not isinstance(entry.value, str) or entry.value not in METRES:
                raise entry.refuse(None, entry.value, f"one of {', '.join(METRES)}")
            return METRES[entry.value]
    return 1.0


def coordinates_of(entry: Entry) -> np.ndarray:
    """(n, 3) `vertices_coords`, in the file's unit; z is 0 where it is not given."""
    if not _list(entry, "a list of points"):
        raise entry.refuse(None, entry.value, "at least one point")
    points = np.zeros((len(entry.value), 3))
    for i, point in enumerate(entry.value):
        if not isinstance(point, list) or len(point) not in (2, 3):
            raise entry.refuse(i, point, "2 or 3 coordinates")
        for k, x in enumerate(point):
            if not _is_number(x) or abs(x) > MAX_COORDINATE:
                raise entry.refuse((i, k), x, f"a number of size up to {MAX_COORDINATE:g}")
            points[i, k] = x
    return points


def faces_of(entry: Entry, vertex_count: int) -> list[list[int]]:
    """`faces_vertices`: the vertices of each face, all different."""
    if not _list(entry, "a list of faces"):
        raise entry.refuse(None, entry.value, "at least one face")
    check_elements(entry.name, sum(len(face) - 2 for face in entry.value if isinstance(face, list)))
    for i, face in enumerate(entry.value):
        if not isinstance(face, list) or not 3 <= len(face) <= MOST_CORNERS:
            raise entry.refuse(i, face, f"3 to {MOST_CORNERS} vertices")
        _check_vertices(entry, i, face, vertex_count)
        if len(set(face)) < len(face):
            raise entry.refuse(i, face, "each vertex once")
    return entry.value


def edges_of(entry: Entry, vertex_count: int) -> np.ndarray:
    """(k, 2) `edges_vertices`, each edge once."""
    seen: dict[tuple[int, int], int] = {}
    for i, edge in enumerate(_list(entry, "a list of edges")):
        if not isinstance(edge, list) or len(edge) != 2:
            raise entry.refuse(i, edge, "2 vertices")
        _check_vertices(entry, i, edge, vertex_count)
        if edge[0] == edge[1]:
            raise entry.refuse(i, edge, "2 different vertices")
        first = seen.setdefault((min(edge), max(edge)), i)
        if first != i:
            raise entry.refuse(i, edge, f"each edge once (it is edge {first} too)")
    return np.array(entry.value, dtype=np.int64).reshape(-1, 2)


def assignments_of(entry: Entry, edge_count: int) -> np.ndarray:
    """(k,) letters of `edges_assignment`."""
    _check_length(entry, edge_count)
    for i, letter in enumerate(entry.value):
        if not isinstance(letter, str) or len(letter) != 1 or letter not in ASSIGNMENTS:
            raise entry.refuse(i, letter, f"one of {', '.join(ASSIGNMENTS)}")
    return np.array(entry.value, dtype="<U1")


def fold_angles_of(entry: Entry, edge_count: int) -> np.ndarray:
    """(k,) `edges_foldAngle`, degrees; NaN where the file has null."""
    _check_length(entry, edge_count)
    for i, angle in enumerate(entry.value):
        if angle is not None and not (_is_number(angle) and abs(angle) <= 180):
            raise entry.refuse(i, angle, "an angle from -180 to 180 (degrees) or null")
    return np.array([np.nan if angle is None else float(angle) for angle in entry.value])


def face_orders_of(entry: Entry, face_count: int) -> np.ndarray:
    """(k, 3) rows (f, g, s) of `faceOrders`, s = 1, -1, or 0 for unknown."""
    for i, row in enumerate(_list(entry, "a list of [f, g, s]")):
        good = isinstance(row, list) and len(row) == 3 and all(_is_index(f, face_count) for f in row[:2])
        if not good or row[0] == row[1] or type(row[2]) is not int or row[2] not in (-1, 0, 1):
            raise entry.refuse(i, row, f"[f, g, s]: two faces below {face_count} and -1, 0 or 1")
    return np.array(entry.value, dtype=int).reshape(-1, 3)


def shorten(value: object) -> str:
    """The value as it could stand in a file, cut to a length that fits in a message."""
    try:
        text = json.dumps(value)
    except RecursionError:
        text = "lists or objects nested too deeply"
    return text if len(text) <= 80 else text[:77] + "..."


def _list(entry: Entry, wants: str) -> list:
    if not isinstance(entry.value, list):
        raise entry.refuse(None, entry.value, wants)
    return entry.value


def _check_length(entry: Entry, count: int) -> None:
    if len(_list(entry, "a list")) != count:
        raise entry.fault(None, f"{len(entry.value)} entries", f"{count}, one per edge of edges_vertices")


def _check_vertices(entry: Entry, index: int, vertices: list, vertex_count: int) -> None:
    for k, vertex in enumerate(vertices):
        if not _is_index(vertex, vertex_count):
            raise entry.refuse((index, k), vertex, f"a vertex, 0 to {vertex_count - 1}")


def _is_index(value: object, count: int) -> bool:
    return type(value) is int and 0 <= value < count


def _is_number(value: object) -> bool:
    return type(value) is int or (type(value) is float and math.isfinite(value))
