"""Specht shape functions of the ANCF membrane triangle, paper (3), (4), (8).

With (i, j, k) cyclic, area coordinates L and c_i1 = y_j - y_k, c_i2 = x_k - x_j:

    S_i1 = L_i - L_i L_j + L_k L_i + 2 (P_i - P_k)
    S_i2 =  c_j2 (P_k - L_k L_i) + c_k2 P_i
    S_i3 = -c_j1 (P_k - L_k L_i) - c_k1 P_i
    P_i  = L_i^2 L_j + 1/2 L_i L_j L_k [3 (1 - mu_k) L_i + (1 + 3 mu_k) (L_k - L_j)]
    mu_i = (l_k^2 - l_j^2) / l_i^2,   l_i^2 = c_i1^2 + c_i2^2
"""

import warp as wp

from .precision import mat33, real, vec2, vec3, vec9


@wp.struct
class ShapeGradient:
    """Derivatives of the nine shape functions with respect to the flat coordinates x and y."""

    x: vec9
    y: vec9


@wp.func
def side_coefficients(x1: vec2, x2: vec2, x3: vec2):
    """c_i1, c_i2 of (4) as columns of a matrix: c[i, 0] = y_j - y_k, c[i, 1] = x_k - x_j; c[i, 2] = mu_i."""
    c = mat33()
    c[0, 0] = x2[1] - x3[1]
    c[0, 1] = x3[0] - x2[0]
    c[1, 0] = x3[1] - x1[1]
    c[1, 1] = x1[0] - x3[0]
    c[2, 0] = x1[1] - x2[1]
    c[2, 1] = x2[0] - x1[0]
    l0 = c[0, 0] * c[0, 0] + c[0, 1] * c[0, 1]
    l1 = c[1, 0] * c[1, 0] + c[1, 1] * c[1, 1]
    l2 = c[2, 0] * c[2, 0] + c[2, 1] * c[2, 1]
    c[0, 2] = (l2 - l1) / l0
    c[1, 2] = (l0 - l2) / l1
    c[2, 2] = (l1 - l0) / l2
    return c


@wp.func
def bubble(li: real, lj: real, lk: real, mu_k: real):
    """P_i of (8)."""
    bracket = real(3.0) * (real(1.0) - mu_k) * li + (real(1.0) + real(3.0) * mu_k) * (lk - lj)
    return li * li * lj + real(0.5) * li * lj * lk * bracket


@wp.func
def bubble_gradient(li: real, lj: real, lk: real, mu_k: real):
    """Derivatives of P_i with respect to L_i, L_j, L_k taken as independent."""
    a = real(3.0) * (real(1.0) - mu_k)
    b = real(1.0) + real(3.0) * mu_k
    bracket = a * li + b * (lk - lj)
    half = real(0.5)
    di = real(2.0) * li * lj + half * lj * lk * bracket + half * li * lj * lk * a
    dj = li * li + half * li * lk * bracket - half * li * lj * lk * b
    dk = half * li * lj * bracket + half * li * lj * lk * b
    return vec3(di, dj, dk)


@wp.func
def shape_values(area: vec3, c: mat33):
    """The nine shape functions at area coordinates `area`; `c` from side_coefficients."""
    s = vec9()
    for i in range(3):
        j = (i + 1) % 3
        k = (i + 2) % 3
        li = area[i]
        lj = area[j]
        lk = area[k]
        p_i = bubble(li, lj, lk, c[k, 2])
        p_k = bubble(lk, li, lj, c[j, 2])
        s[3 * i] = li - li * lj + lk * li + real(2.0) * (p_i - p_k)
        s[3 * i + 1] = c[j, 1] * (p_k - lk * li) + c[k, 1] * p_i
        s[3 * i + 2] = -c[j, 0] * (p_k - lk * li) - c[k, 0] * p_i
    return s


@wp.func
def shape_gradient(area: vec3, c: mat33):
    """Derivatives of the nine shape functions with respect to flat x and y, 1/m for r and 1 for gradients."""
    twice_area = c[0, 0] * c[1, 1] - c[1, 0] * c[0, 1]
    g = ShapeGradient()
    for i in range(3):
        j = (i + 1) % 3
        k = (i + 2) % 3
        li = area[i]
        lj = area[j]
        lk = area[k]
        dp_i = bubble_gradient(li, lj, lk, c[k, 2])  # by L_i, L_j, L_k
        dp_k = bubble_gradient(lk, li, lj, c[j, 2])  # by L_k, L_i, L_j
        # derivatives by L_i, L_j, L_k of S_i1 and of the two factors of S_i2, S_i3
        r_i = real(1.0) - lj + lk + real(2.0) * (dp_i[0] - dp_k[1])
        r_j = -li + real(2.0) * (dp_i[1] - dp_k[2])
        r_k = li + real(2.0) * (dp_i[2] - dp_k[0])
        f_i = dp_k[1] - lk
        f_j = dp_k[2]
        f_k = dp_k[0] - li
        ax = vec3(c[i, 0], c[j, 0], c[k, 0]) / twice_area
        ay = vec3(c[i, 1], c[j, 1], c[k, 1]) / twice_area
        r = vec3(r_i, r_j, r_k)
        f = vec3(f_i, f_j, f_k)
        fx = wp.dot(f, ax)
        fy = wp.dot(f, ay)
        px = wp.dot(dp_i, ax)
        py = wp.dot(dp_i, ay)
        g.x[3 * i] = wp.dot(r, ax)
        g.y[3 * i] = wp.dot(r, ay)
        g.x[3 * i + 1] = c[j, 1] * fx + c[k, 1] * px
        g.y[3 * i + 1] = c[j, 1] * fy + c[k, 1] * py
        g.x[3 * i + 2] = -c[j, 0] * fx - c[k, 0] * px
        g.y[3 * i + 2] = -c[j, 0] * fy - c[k, 0] * py
    return g


@wp.kernel(enable_backward=False, module="warp_origami.kernels.element")
def tabulate_shapes(
    vertices: wp.array(dtype=vec2),
    triangles: wp.array2d(dtype=wp.int32),
    elements: wp.array(dtype=wp.int32),
    areas: wp.array(dtype=vec3),
    # out
    values: wp.array2d(dtype=real),
    gradients: wp.array2d(dtype=vec2),
):
    """Shape functions and their gradients at given area coordinates of given elements, one thread per point."""
    p = wp.tid()
    e = elements[p]
    c = side_coefficients(vertices[triangles[e, 0]], vertices[triangles[e, 1]], vertices[triangles[e, 2]])
    s = shape_values(areas[p], c)
    g = shape_gradient(areas[p], c)
    for i in range(9):
        values[p, i] = s[i]
        gradients[p, i] = vec2(g.x[i], g.y[i])
