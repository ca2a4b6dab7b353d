"""Which boxes overlap which: a hash grid of axis-parallel boxes in classes of their size.

    pairs = { (i, j) : low_i <= high_j, low_j <= high_i in x, y and z }

Every class of boxes has cells of its own width, and each of its boxes is entered in all cells that it touches. A query
looks into the cells that it touches itself, of its own class and of all classes of larger boxes: boxes of any two sizes
meet in a few cells, and a graded mesh costs what an even one costs. Boxes that share several cells meet in one of them
only, that of the largest of their lower corners. Cells are numbered without bound and hashed to slots; an entry keeps
the number of its cell, so that what shares a slot by chance is not taken for near.
"""

import warp as wp

from .precision import real, vec3

CELLS = wp.constant(wp.int64(1 << 19))  # along each axis: what lies beyond counts to the last one
LAST_CELL = wp.constant(real((1 << 19) - 1))
GOLDEN = wp.constant(wp.uint64(0x9E3779B97F4A7C15))  # 2^64 over the golden ratio (D. Knuth, TAOCP 3, 6.4)


@wp.struct
class BoxGrid:
    """Boxes of all classes, from small to large, in one table.

    low, high: corners of the boxes, m; classes: of each box; origin, inverse_widths: cells of each class, 1/m;
    shift: 64 minus the binary digits of a slot; starts: first entry of each slot; items, cells: box and number of the
    cell of each entry, items increasing within a slot.
    """

    low: wp.array(dtype=vec3)
    high: wp.array(dtype=vec3)
    classes: wp.array(dtype=wp.int32)
    origin: vec3
    inverse_widths: wp.array(dtype=real)
    shift: wp.uint64
    starts: wp.array(dtype=wp.int32)
    items: wp.array(dtype=wp.int32)
    cells: wp.array(dtype=wp.int64)


@wp.struct
class BoxQueries:
    """What is looked up: corners, m (a point has two equal ones).

    among: 1 where query i is box i of the grid itself without its margin: then each pair is found once, by the box of
    the smaller class, within a class by the one of the larger number.
    """

    low: wp.array(dtype=vec3)
    high: wp.array(dtype=vec3)
    among: int


@wp.func
def cell_of(grid: BoxGrid, number: int, x: vec3):
    """Cell of a class in which a point lies."""
    at = (x - grid.origin) * grid.inverse_widths[number]
    zero = real(0.0)
    return wp.vec3i(
        int(wp.clamp(wp.floor(at[0]), zero, LAST_CELL)),
        int(wp.clamp(wp.floor(at[1]), zero, LAST_CELL)),
        int(wp.clamp(wp.floor(at[2]), zero, LAST_CELL)),
    )


@wp.func
def cell_number(number: int, cell: wp.vec3i):
    """Name of a cell of a class."""
    plane = wp.int64(number) * CELLS + wp.int64(cell[2])
    return (plane * CELLS + wp.int64(cell[1])) * CELLS + wp.int64(cell[0])


@wp.func
def slot_of(grid: BoxGrid, cell: wp.int64):
    """Slot of a cell in the table (multiplicative hashing)."""
    return int((wp.uint64(cell) * GOLDEN) >> grid.shift)


@wp.func
def boxes_overlap(low: vec3, high: vec3, other_low: vec3, other_high: vec3):
    """Whether two boxes overlap or touch."""
    return (
        low[0] <= other_high[0]
        and other_low[0] <= high[0]
        and low[1] <= other_high[1]
        and other_low[1] <= high[1]
        and low[2] <= other_high[2]
        and other_low[2] <= high[2]
    )


@wp.func
def visit_cell(
    grid: BoxGrid,
    queries: BoxQueries,
    query: int,
    number: int,
    cell: wp.vec3i,
    single: bool,
    place: int,
    items: wp.array(dtype=wp.int32),
):
    """Number of the boxes that a query meets in a cell, the `single` one that it touches or one of several.

    They are written to `items` from `place` on where there is room.
    """
    name = cell_number(number, cell)
    slot = slot_of(grid, name)
    low = queries.low[query]
    high = queries.high[query]
    every = queries.among == 0 or number > grid.classes[query]
    count = wp.int32(0)
    for entry in range(grid.starts[slot], grid.starts[slot + 1]):
        if grid.cells[entry] == name:
            item = grid.items[entry]
            if (every or item < query) and boxes_overlap(low, high, grid.low[item], grid.high[item]):
                if single or cell_of(grid, number, wp.max(low, grid.low[item])) == cell:
                    if place + count < items.shape[0]:
                        items[place + count] = item
                    count += 1
    return count


@wp.func
def visit_boxes(grid: BoxGrid, queries: BoxQueries, query: int, place: int, items: wp.array(dtype=wp.int32)):
    """Number of the boxes that a query overlaps; written to `items` from `place` on where there is room."""
    smallest = wp.int32(0)
    if queries.among != 0:
        smallest = grid.classes[query]
    count = wp.int32(0)
    for number in range(smallest, grid.inverse_widths.shape[0]):
        first = cell_of(grid, number, queries.low[query])
        last = cell_of(grid, number, queries.high[query])
        single = first == last
        for z in range(first[2], last[2] + 1):
            for y in range(first[1], last[1] + 1):
                for x in range(first[0], last[0] + 1):
                    cell = wp.vec3i(x, y, z)
                    count += visit_cell(grid, queries, query, number, cell, single, place + count, items)
    return count
