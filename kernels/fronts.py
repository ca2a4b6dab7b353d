"""Assembly of a front of the multifrontal Cholesky factorization: the updates of its children are added to it.

    F[p, q] += sum over children c of U_c[i, j],   p = place_c[i], q = place_c[j], i >= j

F has k pivot columns, kept as L11 (k, k) and L21 (m, k), and its own update U (m, m); all column after column, of
which the lower triangles count. The places of a child's rows in its parent increase. For the CPU, where it runs between
calls of LAPACK.
"""

import warp as wp

from .precision import real


@wp.kernel(enable_backward=False, module="warp_origami.kernels.fronts")
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
    """Adds the updates of the children to one front; shape: k, m, first and last of `child`, rows that are pivots of
    the parent; offset: of L11, L21, U, and of its own rows in `place`."""
    k, m = wp.int64(shape[front, 0]), wp.int64(shape[front, 1])
    for which in range(shape[front, 2], shape[front, 3]):
        c = child[which]
        size, pivots = shape[c, 1], shape[c, 4]
        rows = int(offset[c, 3])
        for j in range(size):
            q = wp.int64(place[rows + j])
            source = offset[c, 2] + wp.int64(j) * wp.int64(size)
            if j >= pivots:
                own = offset[front, 2] + (q - k) * m - k
                for i in range(j, size):
                    updates[own + wp.int64(place[rows + i])] += updates[source + wp.int64(i)]
            else:
                diagonal, below = offset[front, 0] + q * k, offset[front, 1] + q * m - k
                for i in range(j, pivots):
                    panels[diagonal + wp.int64(place[rows + i])] += updates[source + wp.int64(i)]
                for i in range(pivots, size):
                    panels[below + wp.int64(place[rows + i])] += updates[source + wp.int64(i)]
