"""Assembly without atomics: every entry of the result sums its contributions in a fixed order.

    out_i = sum_{k in row i} w_k v[index_k]

One thread per row of a compressed sparse row map, so that repeated runs agree bitwise, on the CPU and on CUDA.
"""

import warp as wp

from .precision import real, vec3


@wp.kernel(enable_backward=False, module="warp_origami.kernels.element")
def gather_vectors(
    indptr: wp.array(dtype=wp.int32),
    index: wp.array(dtype=wp.int32),
    values: wp.array(dtype=vec3),
    begin: int,
    # out
    out: wp.array(dtype=vec3),
):
    """Sum of element vectors into one row of the coordinates, one thread per row."""
    i = begin + wp.tid()
    total = vec3()
    for k in range(indptr[i], indptr[i + 1]):
        total += values[index[k]]
    out[i] = total


@wp.kernel(enable_backward=False, module="warp_origami.kernels.element")
def gather_scalars(
    indptr: wp.array(dtype=wp.int32),
    index: wp.array(dtype=wp.int32),
    weight: wp.array(dtype=real),
    values: wp.array(dtype=real),
    begin: int,
    # out
    out: wp.array(dtype=real),
):
    """Weighted sum of entries of element tangents into one entry of a sparse matrix, one thread per entry; without
    weights all are one."""
    i = begin + wp.tid()
    total = real(0.0)
    if weight.shape[0] == 0:
        for k in range(indptr[i], indptr[i + 1]):
            total += values[index[k]]
    else:
        for k in range(indptr[i], indptr[i + 1]):
            total += weight[k] * values[index[k]]
    out[i] = total
