"""Force of a unit follower pressure on one element, and the symmetric part of its tangent.

A pressure pushes with r_x x r_y per flat area whatever the sheet does. With r = sum_i S_i q_i this is quadratic in q,
with constants of the flat element, so that no quadrature is left to do at run time:

    e_ijk   = int S_i (S_j,x S_k,y - S_k,x S_j,y) dA = -e_ikj
    F_i     = int S_i (r_x x r_y) dA = sum_{j<k} e_ijk q_j x q_k
    dF_i/dq_j = -[a_ij]x,   a_ij = sum_k e_ijk q_k
    1/2 (dF_i/dq_j + (dF_j/dq_i)') = -1/2 [a_ij - a_ji]x = -1/2 sum_k (e_ijk - e_jik) [q_k]x

where [a]x b = a x b. Pairs of different shape functions are kept in the order (0,1), (0,2) .. (0,8), (1,2) .. Source of
the load stiffness: K. Schweizerhof, E. Ramm, Displacement dependent pressure loads in nonlinear finite element
analyses, Computers & Structures 18 (1984) 1099-1114.
"""

import warp as wp

from .membrane import NODES, element_nodes, mat93
from .precision import mat33, real, vec3

wp.set_module_options({"max_unroll": 0})  # unrolled it compiles longer and runs no faster


@wp.func
def relative_nodes(q: wp.array(dtype=vec3), elements: wp.array2d(dtype=wp.int32), e: int):
    """Nodal coordinates with positions relative to the first corner: translations drop out without round-off."""
    nodes = element_nodes(q, elements, e)
    origin = nodes[0]
    for corner in range(3):
        nodes[3 * corner] = nodes[3 * corner] - origin
    return nodes


@wp.func
def skew(a: vec3):
    """Matrix of the product a x ."""
    zero = real(0.0)
    return mat33(zero, -a[2], a[1], a[2], zero, -a[0], -a[1], a[0], zero)


@wp.kernel(enable_backward=False)
def pressure_force(
    q: wp.array(dtype=vec3),
    elements: wp.array2d(dtype=wp.int32),
    pressed: wp.array(dtype=wp.int32),
    constants: wp.array3d(dtype=real),
    begin: int,
    # out
    force: wp.array2d(dtype=vec3),
):
    """Nodal forces of a unit pressure, one thread per pressed element."""
    t = begin + wp.tid()
    nodes = relative_nodes(q, elements, pressed[t])
    f = mat93()
    pair = wp.int32(0)
    for j in range(NODES):
        for k in range(j + 1, NODES):
            product = wp.cross(nodes[j], nodes[k])
            for i in range(NODES):
                f[i] = f[i] + constants[t, i, pair] * product
            pair += 1
    for i in range(NODES):
        force[t, i] = f[i]


@wp.kernel(enable_backward=False)
def pressure_stiffness(
    q: wp.array(dtype=vec3),
    elements: wp.array2d(dtype=wp.int32),
    pressed: wp.array(dtype=wp.int32),
    differences: wp.array3d(dtype=real),
    pressure: real,
    begin: int,
    # out
    blocks: wp.array2d(dtype=mat33),
):
    """Adds minus pressure times the symmetric tangent of the force to the element tangents of the membrane."""
    t = begin + wp.tid()
    e = pressed[t]
    nodes = relative_nodes(q, elements, e)
    factor = real(0.5) * pressure
    pair = wp.int32(0)
    for i in range(NODES):
        for _ in range(i + 1, NODES):
            a = vec3()
            for k in range(NODES):
                a += differences[t, pair, k] * nodes[k]
            block = pair + i + 1  # in the order of the membrane, which has (i, i) as well
            blocks[e, block] = blocks[e, block] + factor * skew(a)
            pair += 1
