"""Weighted rows in the lower triangle of a symmetric sparse matrix: what contact adds to the tangent (38), (45).

    A_ij += sum_r w_r g_ri g_rj,   i >= j

Rows are sparse with increasing columns, as are the rows of A within its columns. For the CPU.
"""

import warp as wp

from .precision import real


@wp.kernel(enable_backward=False, module="warp_origami.kernels.weighted_rows")
def add_weighted_rows(
    indptr: wp.array(dtype=wp.int32),
    index: wp.array(dtype=wp.int32),
    value: wp.array(dtype=real),
    weight: wp.array(dtype=real),
    column_starts: wp.array(dtype=wp.int32),
    row_index: wp.array(dtype=wp.int32),
    stamp: wp.int32,
    # out
    entries: wp.array(dtype=real),
    used: wp.array(dtype=wp.int32),
    missing: wp.array(dtype=wp.int32),
):
    """All rows one after the other on one thread; stamps the entries it adds to, counts those that A does not have."""
    for r in range(weight.shape[0]):
        for a in range(indptr[r], indptr[r + 1]):
            column, scaled = index[a], weight[r] * value[a]
            slot, end = int(column_starts[column]), column_starts[column + 1]
            for b in range(a, indptr[r + 1]):
                row = index[b]
                while slot < end and row_index[slot] < row:
                    slot += 1
                if slot < end and row_index[slot] == row:
                    entries[slot] += scaled * value[b]
                    used[slot] = stamp
                else:
                    missing[0] += 1
