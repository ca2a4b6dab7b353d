"""The animation as the page keeps it: chosen frames, positions as 16-bit numbers, fields as half floats.

Positions are multiples of 1/65535 of the largest extent of the whole motion. A field is divided by a power of two so
that it fits half floats, whose relative precision of 1/2048 is the same for large values and small ones. Points on a
crease are split between its two sides, so that the surface is smooth up to the crease and sharp at it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warp_origami.output.animation_file import AnimationFile
from warp_origami.output.usd import FIXED_RANGES, LOCAL, PERCENTILES

from .coding import Blob

LARGEST = 18_000_000
"""Bytes of all frames, compressed: the page, in base64, then stays below 30 MB."""

LARGEST_UNPACKED = 120_000_000
"""Bytes of all frames as the browser holds them."""

STEPS = 65535
"""Positions between the two ends of the motion's extent."""

LARGEST_HALF = 30000.0
"""Fields are scaled below this; half floats end at 65504."""


SAMPLED = 4_000_000
"""Values that the percentiles are taken of, about."""


@dataclass(frozen=True)
class FieldRange:
    """Values of a field over the frames in the page.

    Attributes:
        scale: power of two that half floats are to be multiplied by.
        low, high: of the colours: percentiles over the whole run, so that neither a few elements nor a short time
            with extreme values take all the colours.
        least, largest: of all values.
    """

    scale: float
    low: float
    high: float
    least: float
    largest: float


@dataclass(frozen=True)
class DrawnSheet:
    """What the page draws.

    Attributes:
        blob: the arrays.
        stride: every so many-th frame of the file is in the page.
        frames: number of frames in the page.
        in_file: number of frames in the file.
        origin: (3,) least coordinates of the motion, m.
        step: m, of the positions.
        ranges: of each field.
    """

    blob: Blob
    stride: int
    frames: int
    in_file: int
    origin: np.ndarray
    step: float
    ranges: dict[str, FieldRange]


def draw_sheet(animation: AnimationFile, largest: int = LARGEST) -> DrawnSheet:
    """The frames of an animation, as many as fit `largest` (bytes), evenly chosen; first and last always.

    Raises:
        InputError: the file is damaged.
    """
    per_frame = len(animation.flat) * (6 + 2 * len(animation.fields))
    stride = 1
    while per_frame * len(animation.times) / stride > LARGEST_UNPACKED and stride < len(animation.times):
        stride *= 2
    sheet = _drawn(animation, stride)
    while sheet.blob.size > largest and sheet.frames > 2:
        stride *= 2  # also where a smaller one might do: the periods of modes have 16 frames
        sheet = _drawn(animation, stride)
    return sheet


def _drawn(animation: AnimationFile, stride: int) -> DrawnSheet:
    last = len(animation.times) - 1
    chosen = np.unique(np.append(np.arange(0, last + 1, stride), last))
    points = np.empty((len(chosen), len(animation.flat), 3), dtype=np.float32)
    fields = {name: np.empty(points.shape[:2], dtype=np.float32) for name in animation.fields}
    for k, frame in enumerate(animation.frames(chosen)):
        points[k] = np.nan_to_num(frame.points)
        for name, values in frame.fields.items():
            fields[name][k] = values

    blob = Blob()
    blob.add("times", animation.times[chosen])
    _add_topology(blob, animation)
    origin = points.min(axis=(0, 1)).astype(float)
    step = max(float((points.max(axis=(0, 1)) - origin).max()) / STEPS, 1e-12)
    # in place of one large array of whole numbers, frame by frame
    positions = np.empty(points.shape, dtype=np.uint16)
    for k in range(len(chosen)):
        positions[k] = np.rint((points[k] - origin) / step)
    blob.add("positions", positions, differences=True)
    ranges = {}
    for name, values in fields.items():
        ranges[name] = _range(name, values)
        half = (values / np.float32(ranges[name].scale)).astype(np.float16)
        blob.add(f"field {name}", half.view(np.uint16), differences=True)
    return DrawnSheet(blob, stride, len(chosen), last + 1, origin, step, ranges)


def _add_topology(blob: Blob, animation: AnimationFile) -> None:
    vertices, triangles = split_at_creases(animation.triangles, animation.creases)
    blob.add("vertices", vertices.astype(np.int32), differences=True)
    blob.add("triangles", triangles.astype(np.int32), differences=True)
    blob.add("creases", segments(animation.creases).astype(np.int32), differences=True)
    blob.add("rim", rim(animation.triangles).astype(np.int32), differences=True)
    blob.add("flat", animation.flat.astype(np.float32))


def _range(name: str, values: np.ndarray) -> FieldRange:
    """Of the values (frames, points) of a field."""
    known = [row[np.isfinite(row)] for row in values]
    known = [row for row in known if len(row)]
    if not known:
        return FieldRange(1.0, 0.0, 0.0, 0.0, 0.0)
    least, largest = float(min(row.min() for row in known)), float(max(row.max() for row in known))
    top = max(abs(least), abs(largest))
    scale = 2.0 ** np.ceil(np.log2(top / LARGEST_HALF)) if top > 0.0 else 1.0
    if name in FIXED_RANGES:
        return FieldRange(float(scale), *FIXED_RANGES[name], least, largest)
    shown = values[:, :: max(1, values.size // SAMPLED)]
    shown = shown[np.isfinite(shown)]
    if name in LOCAL and shown.any():
        shown = shown[shown != 0.0]
    low, high = np.percentile(shown, PERCENTILES) if len(shown) else (0.0, 0.0)
    low, high = min(0.0, float(low)), max(0.0, float(high))
    return FieldRange(float(scale), low, high, least, largest)


def segments(chains: np.ndarray) -> np.ndarray:
    """(n, 2) pairs of neighbours in chains (nc, k)."""
    return np.stack([chains[:, :-1], chains[:, 1:]], axis=-1).reshape(-1, 2)


def _sides(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The sides (3 nt, 2) of all triangles, ends in increasing order, and the triangle of each."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.sort(sides, axis=1), np.tile(np.arange(len(triangles)), 3)


def rim(triangles: np.ndarray) -> np.ndarray:
    """(n, 2) sides that belong to one triangle only: the outline of the sheet and its cuts."""
    sides, count = np.unique(_sides(triangles)[0], axis=0, return_counts=True)
    return sides[count == 1]


def split_at_creases(triangles: np.ndarray, creases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices for drawing: each point once for every face that it belongs to.

    A face is what can be reached from triangle to triangle without crossing a crease.

    Returns:
        (nv,) point of every vertex, and the triangles (nt, 3) as vertices.
    """
    sides, owner = _sides(triangles)
    count = int(triangles.max(initial=0)) + 1
    keys = sides[:, 0].astype(np.int64) * count + sides[:, 1]
    folds = np.sort(segments(creases), axis=1)
    smooth = ~np.isin(keys, folds[:, 0].astype(np.int64) * count + folds[:, 1])
    order = np.argsort(keys[smooth], kind="stable")
    keys, owner = keys[smooth][order], owner[smooth][order]
    same = np.flatnonzero(keys[1:] == keys[:-1])
    graph = coo_array((np.ones(len(same)), (owner[same], owner[same + 1])), shape=(len(triangles), len(triangles)))
    faces = connected_components(graph, directed=False)[1]
    corners = faces[:, None].astype(np.int64) * count + triangles
    vertices, numbers = np.unique(corners, return_inverse=True)
    return vertices % count, numbers.reshape(triangles.shape)
