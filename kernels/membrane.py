"""Strain energy, its gradient and its tangent for one element, paper (16), (17), (20), (21).

With r_x = sum_i q_i S_i,x and r_y likewise, E = ((r_x.r_x - 1) / 2, (r_y.r_y - 1) / 2, r_x.r_y), w the volumes
of the quadrature points and (W, S, C) the law:

    U_e   = sum w W(E)
    g_i   = sum w (S_i,x t_x + S_i,y t_y),   t_x = S11 r_x + S12 r_y,   t_y = S12 r_x + S22 r_y
    K_ij  = sum w (S_i,x S_j,x D_xx + S_i,x S_j,y D_xy + S_i,y S_j,x D_xy' + S_i,y S_j,y D_yy)
    D_ab  = P_a C P_b' + S_ab I,   P_x = [r_x, 0, r_y],   P_y = [0, r_y, r_x]

so that a pair of shape functions costs 18 multiplications a point. The nine shape functions make 45 pairs i <= j, kept
as 3x3 blocks in the order (0,0), (0,1) .. (0,8), (1,1) ..; K_ji = K_ij'.

Newton's mixed iteration has strains of its own at the quadrature points, e, with S(e) + C(e) (E - e) for S in the
gradient, S(e) for S in the tangent, and C(e) for C; a step d of q takes them a part l of the way to the linearized
strain,

    e' = (1 - l) e + l (E + B d),   B d = (r_x.d_x, r_y.d_y, r_x.d_y + r_y.d_x),

and from there to where the law says that it should be linearized next.
"""

from dataclasses import dataclass
from functools import cache
from types import ModuleType

import warp as wp

from .precision import mat33, real, vec2, vec3

NODES = 9
PAIRS = 45

mat93 = wp.types.matrix(shape=(NODES, 3), dtype=real)


@wp.struct
class SurfaceGradient:
    """Derivatives of the position with respect to the flat coordinates."""

    x: vec3
    y: vec3


@wp.struct
class PointStiffness:
    """D_xx, D_xy, D_yy at a quadrature point, times its weight."""

    xx: mat33
    xy: mat33
    yy: mat33


@wp.func
def element_nodes(q: wp.array(dtype=vec3), elements: wp.array2d(dtype=wp.int32), e: int):
    """Nodal coordinates (6) of an element, one a row."""
    nodes = mat93()
    for i in range(NODES):
        nodes[i] = q[elements[e, i]]
    return nodes


@wp.func
def surface_gradient(shapes: wp.array3d(dtype=vec2), e: int, p: int, nodes: mat93):
    """r_x and r_y at point p of an element."""
    r = SurfaceGradient()
    for i in range(NODES):
        d = shapes[e, p, i]
        r.x += d[0] * nodes[i]
        r.y += d[1] * nodes[i]
    return r


@wp.func
def green_strain(r: SurfaceGradient):
    """Green-Lagrange strain (16)."""
    half = real(0.5)
    one = real(1.0)
    return vec3(half * (wp.dot(r.x, r.x) - one), half * (wp.dot(r.y, r.y) - one), wp.dot(r.x, r.y))


@wp.func
def point_stiffness(r: SurfaceGradient, s: vec3, c: mat33, w: real):
    """Material and geometric part of the tangent between gradients of the position."""
    xx = wp.outer(r.x, r.x)
    xy = wp.outer(r.x, r.y)
    yx = wp.transpose(xy)
    yy = wp.outer(r.y, r.y)
    eye = wp.identity(n=3, dtype=real)
    d = PointStiffness()
    d.xx = (w * c[0, 0]) * xx + (w * c[0, 2]) * (xy + yx) + (w * c[2, 2]) * yy + (w * s[0]) * eye
    d.xy = (w * c[0, 1]) * xy + (w * c[0, 2]) * xx + (w * c[1, 2]) * yy + (w * c[2, 2]) * yx + (w * s[2]) * eye
    d.yy = (w * c[1, 1]) * yy + (w * c[1, 2]) * (xy + yx) + (w * c[2, 2]) * xx + (w * s[1]) * eye
    return d


def _gradient_kernel(law: ModuleType, module: wp.Module) -> wp.Kernel:
    Parameters, law_stress = law.Parameters, law.stress

    @wp.kernel(enable_backward=False, module=module)
    def membrane_gradient(
        q: wp.array(dtype=vec3),
        elements: wp.array2d(dtype=wp.int32),
        shapes: wp.array3d(dtype=vec2),
        volumes: wp.array2d(dtype=real),
        parameters: Parameters,
        begin: int,
        # out
        energy: wp.array(dtype=real),
        gradient: wp.array2d(dtype=vec3),
    ):
        """Energy and its gradient, one thread per element."""
        e = begin + wp.tid()
        nodes = element_nodes(q, elements, e)
        g = mat93()
        total = real(0.0)
        for p in range(volumes.shape[1]):
            r = surface_gradient(shapes, e, p, nodes)
            density, s = law_stress(parameters, green_strain(r))
            w = volumes[e, p]
            total += w * density
            tx = w * (s[0] * r.x + s[2] * r.y)
            ty = w * (s[2] * r.x + s[1] * r.y)
            for i in range(NODES):
                d = shapes[e, p, i]
                g[i] = g[i] + d[0] * tx + d[1] * ty
        for i in range(NODES):
            gradient[e, i] = g[i]
        energy[e] = total

    return membrane_gradient


def _tangent_kernel(law: ModuleType, module: wp.Module) -> wp.Kernel:
    Parameters, law_tangent = law.Parameters, law.tangent

    @wp.kernel(enable_backward=False, module=module)
    def membrane_tangent(
        q: wp.array(dtype=vec3),
        elements: wp.array2d(dtype=wp.int32),
        shapes: wp.array3d(dtype=vec2),
        volumes: wp.array2d(dtype=real),
        parameters: Parameters,
        strains: wp.array2d(dtype=vec3),
        mixed: wp.bool,
        geometric: wp.bool,
        begin: int,
        # out
        energy: wp.array(dtype=real),
        gradient: wp.array2d(dtype=vec3),
        blocks: wp.array2d(dtype=mat33),
    ):
        """Energy, its gradient and its tangent, one thread per element; `mixed`: with the law at `strains`."""
        e = begin + wp.tid()
        nodes = element_nodes(q, elements, e)
        for k in range(PAIRS):
            blocks[e, k] = mat33()
        g = mat93()
        total = real(0.0)
        for p in range(volumes.shape[1]):
            r = surface_gradient(shapes, e, p, nodes)
            strain = green_strain(r)
            at = strain
            if mixed:
                at = strains[e, p]
            density, own, c = law_tangent(parameters, at)
            s = own + c * (strain - at)
            w = volumes[e, p]
            total += w * density
            tx = w * (s[0] * r.x + s[2] * r.y)
            ty = w * (s[2] * r.x + s[1] * r.y)
            if not geometric:
                own = vec3()
            stiffness = point_stiffness(r, own, c, w)
            k = wp.int32(0)
            for i in range(NODES):
                d = shapes[e, p, i]
                g[i] = g[i] + d[0] * tx + d[1] * ty
                along_x = d[0] * stiffness.xx + d[1] * wp.transpose(stiffness.xy)
                along_y = d[0] * stiffness.xy + d[1] * stiffness.yy
                for j in range(i, NODES):
                    dj = shapes[e, p, j]
                    blocks[e, k] = blocks[e, k] + dj[0] * along_x + dj[1] * along_y
                    k += 1
        for i in range(NODES):
            gradient[e, i] = g[i]
        energy[e] = total

    return membrane_tangent


def _strains_kernel(law: ModuleType, module: wp.Module) -> wp.Kernel:
    Parameters, law_next_strain = law.Parameters, law.next_strain

    @wp.kernel(enable_backward=False, module=module)
    def advance_strains(
        q: wp.array(dtype=vec3),
        step: wp.array(dtype=vec3),
        elements: wp.array2d(dtype=wp.int32),
        shapes: wp.array3d(dtype=vec2),
        parameters: Parameters,
        length: real,
        afresh: wp.bool,
        begin: int,
        # out
        strains: wp.array2d(dtype=vec3),
    ):
        """Strains at the quadrature points after a part of the step; `afresh`: those of q."""
        e = begin + wp.tid()
        nodes = element_nodes(q, elements, e)
        steps = element_nodes(step, elements, e)
        for p in range(strains.shape[1]):
            r = surface_gradient(shapes, e, p, nodes)
            strain = green_strain(r)
            if afresh:
                strains[e, p] = strain
            else:
                at = strains[e, p]
                d = surface_gradient(shapes, e, p, steps)
                strain += vec3(wp.dot(r.x, d.x), wp.dot(r.y, d.y), wp.dot(r.x, d.y) + wp.dot(r.y, d.x))
                strains[e, p] = law_next_strain(parameters, at, at + length * (strain - at))

    return advance_strains


def _sample_kernel(law: ModuleType, module: wp.Module) -> wp.Kernel:
    Parameters, law_stress, law_state = law.Parameters, law.stress, law.state

    @wp.kernel(enable_backward=False, module=module)
    def membrane_sample(
        q: wp.array(dtype=vec3),
        elements: wp.array2d(dtype=wp.int32),
        points: wp.array(dtype=wp.int32),
        shapes: wp.array2d(dtype=vec2),
        parameters: Parameters,
        # out
        principal_stress: wp.array(dtype=vec2),
        states: wp.array(dtype=wp.int32),
    ):
        """Principal second Piola-Kirchhoff stresses and the state, one thread per point; points[k] is its element."""
        k = wp.tid()
        e = points[k]
        r = SurfaceGradient()
        for i in range(NODES):
            d = shapes[k, i]
            node = q[elements[e, i]]
            r.x += d[0] * node
            r.y += d[1] * node
        strain = green_strain(r)
        _, s = law_stress(parameters, strain)
        mean = real(0.5) * (s[0] + s[1])
        difference = real(0.5) * (s[0] - s[1])
        radius = wp.sqrt(difference * difference + s[2] * s[2])
        principal_stress[k] = vec2(mean + radius, mean - radius)
        states[k] = law_state(parameters, strain)

    return membrane_sample


@dataclass(frozen=True)
class MembraneKernels:
    """Kernels of one law and the name of their Warp module."""

    module: str
    gradient: wp.Kernel
    tangent: wp.Kernel
    strains: wp.Kernel
    sample: wp.Kernel


@cache
def membrane_kernels(law: ModuleType) -> MembraneKernels:
    """Kernels for a law: a module with NAME, Parameters and the functions stress, tangent, next_strain and state.

    They live in a Warp module of their own, so that only the law of the scene is compiled.
    """
    module = wp.get_module(f"{__name__}_{law.NAME}")
    module.options["max_unroll"] = 0  # unrolled by Warp the nine-by-nine loops compile four times as long
    return MembraneKernels(
        module.name,
        _gradient_kernel(law, module),
        _tangent_kernel(law, module),
        _strains_kernel(law, module),
        _sample_kernel(law, module),
    )
