"""Force of sunlight on one element, and its tangent.

With a = r_x x r_y (area and normal of the front per flat area), J = |a|, u the direction of the light, c = a . u, and
for the side that is lit (the front where c < 0) the specular share rho_s, the diffuse share rho_d, the absorbed share
rho_a and e = B rho_d + rho_a (eps B - eps' B') / (eps + eps'), primes for the other side,

    f(a) = P { (1 - rho_s) |c| u + 2 rho_s |c| c a / J^2 + e c a / J }
    F_i  = int S_i f(a) dA,     dF_i/dq_j = int S_i df/da (S_j,y [r_x]x - S_j,x [r_y]x) dA

which is the flat-plate law P A cos(alpha) { (1 - rho_s) u + (2 rho_s cos(alpha) + e) n }, n along the light. Source:
C. R. McInnes, Solar Sailing, Springer 1999, section 2.6.
"""

import warp as wp

from .membrane import NODES, element_nodes, mat93, surface_gradient
from .precision import mat33, real, vec2, vec3
from .pressure import skew

wp.set_module_options({"max_unroll": 0})


@wp.struct
class Light:
    """Direction of the light; of each side 1 - rho_s, 2 rho_s and e."""

    direction: vec3
    front: vec3
    back: vec3


@wp.func
def traction(light: Light, a: vec3):
    """f(a) over P."""
    c = wp.dot(a, light.direction)
    side = light.back
    if c < real(0.0):
        side = light.front
    j2 = wp.dot(a, a)
    size = wp.abs(c)
    return side[0] * size * light.direction + (side[1] * size * c / j2 + side[2] * c / wp.sqrt(j2)) * a


@wp.func
def traction_derivative(light: Light, a: vec3):
    """df/da over P."""
    u = light.direction
    c = wp.dot(a, u)
    side = light.back
    if c < real(0.0):
        side = light.front
    j2 = wp.dot(a, a)
    j = wp.sqrt(j2)
    size = wp.abs(c)
    eye = wp.identity(n=3, dtype=real)
    two = real(2.0)
    au = wp.outer(a, u)
    aa = wp.outer(a, a)
    d = (side[0] * wp.sign(c)) * wp.outer(u, u)
    d += (side[1] / j2) * (two * size * au + size * c * eye - (two * size * c / j2) * aa)
    d += (side[2] / j) * (au + c * eye - (c / j2) * aa)
    return d


@wp.kernel(enable_backward=False)
def sunlight_force(
    q: wp.array(dtype=vec3),
    elements: wp.array2d(dtype=wp.int32),
    lit: wp.array(dtype=wp.int32),
    values: wp.array3d(dtype=real),
    shapes: wp.array3d(dtype=vec2),
    areas: wp.array2d(dtype=real),
    light: Light,
    begin: int,
    # out
    force: wp.array2d(dtype=vec3),
):
    """Nodal forces over P, one thread per element that may be lit."""
    t = begin + wp.tid()
    nodes = element_nodes(q, elements, lit[t])
    total = mat93()
    for p in range(areas.shape[1]):
        r = surface_gradient(shapes, t, p, nodes)
        f = areas[t, p] * traction(light, wp.cross(r.x, r.y))
        for i in range(NODES):
            total[i] = total[i] + values[t, p, i] * f
    for i in range(NODES):
        force[t, i] = total[i]


@wp.kernel(enable_backward=False)
def sunlight_tangent(
    q: wp.array(dtype=vec3),
    elements: wp.array2d(dtype=wp.int32),
    lit: wp.array(dtype=wp.int32),
    values: wp.array3d(dtype=real),
    shapes: wp.array3d(dtype=vec2),
    areas: wp.array2d(dtype=real),
    light: Light,
    begin: int,
    # out
    tangents: wp.array3d(dtype=mat33),
):
    """dF_i/dq_j over P, one thread per element that may be lit."""
    t = begin + wp.tid()
    nodes = element_nodes(q, elements, lit[t])
    for i in range(NODES):
        for j in range(NODES):
            tangents[t, i, j] = mat33()
    for p in range(areas.shape[1]):
        r = surface_gradient(shapes, t, p, nodes)
        d = areas[t, p] * traction_derivative(light, wp.cross(r.x, r.y))
        by_x = -d * skew(r.y)
        by_y = d * skew(r.x)
        for j in range(NODES):
            s = shapes[t, p, j]
            by_j = s[0] * by_x + s[1] * by_y
            for i in range(NODES):
                tangents[t, i, j] = tangents[t, i, j] + values[t, p, i] * by_j


@wp.kernel(enable_backward=False)
def add_symmetric_part(
    tangents: wp.array3d(dtype=mat33),
    lit: wp.array(dtype=wp.int32),
    pressure: real,
    begin: int,
    # out
    blocks: wp.array2d(dtype=mat33),
):
    """Adds minus the symmetric part of the tangents, times P, to the element tangents of the membrane."""
    t = begin + wp.tid()
    e = lit[t]
    k = wp.int32(0)
    for i in range(NODES):
        for j in range(i, NODES):
            both = tangents[t, i, j] + wp.transpose(tangents[t, j, i])
            blocks[e, k] = blocks[e, k] - real(0.5) * pressure * both
            k += 1
