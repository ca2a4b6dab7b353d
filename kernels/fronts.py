"""Assembly of a front of the multifrontal Cholesky factorization: the updates of its children are added to it.

    F[p, q] += sum over children c of U_c[i, j],   p = place_c[i], q = place_c[j], i >= j

F has k pivot columns, kept as L11 (k, k) and L21 (m, k), and its own update U (m, m); all column after column, of
which the lower triangles count. The places of a child's rows in its parent increase. For the CPU, where it runs between
calls of LAPACK.
"""

import warp as wp

from .precision import real


@wp.kernel(enable_backward=False, module="warp_origami.kernels.matrix")
def assemble_front(
    front: wp.int32,
    shape: wp.array2d(dtype=wp.int32),
    offset: wp.array2d(dtype=wp.int64),
    child: wp.array(dtype=wp.int32),
    place: wp.array(dtype=wp.int32),
    # out
    panels: wp.array(dtype=real),
    updates: wp.array(dtype=real),
):
    """Clears the update of one front and adds those of its children; shape: k, m, first and last of `child`; offset: of
    L11, L21, U, and of its own rows in `place`."""
    k, m = shape[front, 0], shape[front, 1]
    diagonal, below, own = offset[front, 0], offset[front, 1], offset[front, 2]
    for j in range(m):
        for i in range(j, m):
            updates[own + wp.int64(j * m + i)] = real(0.0)
    for which in range(shape[front, 2], shape[front, 3]):
        c = child[which]
        size = shape[c, 1]
        for j in range(size):
            source = offset[c, 2] + wp.int64(j * size)
            rows = offset[c, 3]
            q = place[rows + wp.int64(j)]
            for i in range(j, size):
                p = place[rows + wp.int64(i)]
                value = updates[source + wp.int64(i)]
                if q >= k:
                    updates[own + wp.int64((q - k) * m + p - k)] += value
                elif p >= k:
                    panels[below + wp.int64(q * m + p - k)] += value
                else:
                    panels[diagonal + wp.int64(q * k + p)] += value
