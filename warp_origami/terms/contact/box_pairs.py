"""Pairs of boxes that overlap: exact count, then fill; the grid and the launches that all searches of contact share.

Nothing is guessed, so that nothing can overflow: the entries of the grid and the pairs of every query are counted
before there is room for them. Pairs come in parts of bounded size, each of whole queries in their order.
"""

from collections.abc import Callable, Iterator

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix

from warp_origami.kernels import box_grid, broadphase
from warp_origami.kernels.precision import real, vec3

CLASS_RATIO = 4.0
"""Largest over smallest extent of the boxes of a class."""

CELL_SHARE = 0.6
"""Width of a cell over the median extent of the boxes of its class: smaller cells hold less that is not near, but
every box is in more of them."""

SMALLEST_CELL = 0.125
"""Least width of a cell over the largest extent of its class: no box is in more than 9^3 cells."""

PART = 1 << 22
"""Pairs that are looked at together at most, unless one query has more."""

MARGIN = 1.0 + 1e-9
"""Boxes grow by the radius times this: what is just within the radius must not be lost to round-off."""

Part = tuple[np.ndarray, np.ndarray, np.ndarray]


def near_pairs(
    low: wp.array,
    high: wp.array,
    boxes: tuple[np.ndarray, np.ndarray],
    radius: float,
    distances_of: Callable[[wp.array, wp.array], wp.array],
    members: np.ndarray | None = None,
    among: bool = False,
) -> Iterator[Part]:
    """Pairs of queries and items closer than `radius`, in parts, ordered by query.

    Args:
        low, high: (n,) vec3 corners of the queries' boxes, m; one array twice for points. With `among` they are those
            of the items.
        boxes: (m, 3) low and high corners of the items' boxes, m.
        radius: m.
        distances_of: distances (m) of given queries and items; never less than that of their boxes along any axis.
        members: the items to be looked at, in the order in which every query shall find them; None: all.
        among: queries are the items themselves; of a pair, either may be the query.

    Yields:
        queries, items (int32) and distances of pairs. A query finds members in their order where all are of one class.
    """
    device = low.device
    grid = build_grid(boxes[0] - MARGIN * radius, boxes[1] + MARGIN * radius, members, device)
    queries = box_grid.BoxQueries()
    queries.low, queries.high, queries.among = low, high, int(among)
    counts = wp.empty(len(low), dtype=wp.int32, device=device)
    nothing = wp.empty(0, dtype=wp.int32, device=device)
    wp.launch(broadphase.count_overlaps, dim=len(low), inputs=[grid, queries, nothing], outputs=[counts], device=device)
    ends = np.cumsum(counts.numpy(), dtype=np.int64)
    first = 0
    while first < len(low):
        before = ends[first - 1] if first else 0
        last = max(int(np.searchsorted(ends, before + PART, side="right")), first + 1)
        total = int(ends[last - 1] - before)
        if total:
            starts = np.concatenate([[0], ends[first : last - 1] - before]).astype(np.int32)
            found, items = (wp.empty(total, dtype=wp.int32, device=device) for _ in range(2))
            wp.launch(
                broadphase.fill_overlaps,
                dim=last - first,
                inputs=[grid, queries, first, wp.array(starts, device=device)],
                outputs=[found, items],
                device=device,
            )
            distances = distances_of(found, items).numpy()
            near = np.flatnonzero(distances <= radius)
            yield found.numpy()[near], items.numpy()[near], distances[near]
        first = last


def joined(parts: Iterator[Part]) -> Part:
    """All parts in one."""
    none = (np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32), np.zeros(0))
    return tuple(np.concatenate(arrays) for arrays in zip(none, *parts, strict=True))


def build_grid(low: np.ndarray, high: np.ndarray, members: np.ndarray | None, device: wp.Device) -> box_grid.BoxGrid:
    """Hash grid of the boxes `members` out of low, high (m, 3), m; cells follow the sizes that the boxes have."""
    members = np.arange(len(low)) if members is None else members
    finite = np.isfinite(low[members]).all(axis=1) & np.isfinite(high[members]).all(axis=1)
    members = members[finite]  # what is nowhere is near nothing
    classes, widths = size_classes((high[members] - low[members]).max(axis=1))
    origin = low[members].min(axis=0, initial=np.inf)
    origin[~np.isfinite(origin)] = 0.0

    inverse = 1.0 / widths
    last_cell = float(box_grid.LAST_CELL)
    first, last = (
        np.clip(np.floor((corner[members] - origin) * inverse[classes, None]), 0.0, last_cell).astype(np.int64)
        for corner in (low, high)
    )
    sizes = last - first + 1
    counts = sizes.prod(axis=1)
    strides = int(box_grid.CELLS) ** np.arange(3)
    lowest = classes * strides[2] * int(box_grid.CELLS) + first @ strides
    # entry number n of a box is in its cell (x, y, z), n = x + width (y + depth z)
    entry = np.repeat(np.arange(len(members), dtype=np.int32), counts)
    number = np.arange(len(entry), dtype=np.int32) - np.repeat((np.cumsum(counts) - counts).astype(np.int32), counts)
    width, depth = (sizes[:, axis].astype(np.int32)[entry] for axis in (0, 1))
    row = number // width
    plane = row // depth
    cells = lowest[entry] + (number - row * width) + strides[1] * (row - plane * depth) + strides[2] * plane

    digits = max(1, len(cells).bit_length())
    slots = ((cells.astype(np.uint64) * np.uint64(int(box_grid.GOLDEN))) >> np.uint64(64 - digits)).astype(np.int32)
    # a matrix of compressed rows is a counting sort that keeps the order of members
    ones = np.ones(len(cells), dtype=bool)
    rows = csr_matrix((ones, (slots, np.arange(len(cells)))), shape=(1 << digits, len(cells)))

    class_of = np.zeros(len(low), dtype=np.int32)
    class_of[members] = classes
    grid = box_grid.BoxGrid()
    grid.low, grid.high = (wp.array(corner, dtype=vec3, device=device) for corner in (low, high))
    grid.classes = wp.array(class_of, device=device)
    grid.origin = vec3(*origin)
    grid.inverse_widths = wp.array(inverse, dtype=real, device=device)
    grid.shift = 64 - digits
    grid.starts = wp.array(rows.indptr, dtype=wp.int32, device=device)
    grid.items = wp.array(members[entry[rows.indices]], dtype=wp.int32, device=device)
    grid.cells = wp.array(cells[rows.indices], dtype=wp.int64, device=device)
    return grid


def size_classes(extents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Classes (n,) of boxes, counted from the smallest ones on, and the width of the cells of each class, m."""
    if not len(extents):
        return np.zeros(0, dtype=int), np.ones(1)
    largest = extents.max()
    levels = np.floor(np.log(largest / extents) / np.log(CLASS_RATIO)).astype(int)
    present, classes = np.unique(-levels, return_inverse=True)
    classes = classes.ravel()
    widths = np.empty(len(present))
    for number in range(len(present)):
        of_class = extents[classes == number]
        widths[number] = max(CELL_SHARE * np.median(of_class), SMALLEST_CELL * of_class.max())
    return classes, widths
