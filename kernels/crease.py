"""Rotational springs along creases: energy, its gradient and its tangent at points of each crease.

With t = dr/ds along the crease (s the flat length), b the derivative across it, from the right element to the left one,
in the element on either side, and normals n = t x b, the fold angle is that between the normals about t,

    theta = atan2(|t| t . (b_R x b_L), |t|^2 b_R . b_L - (t . b_R) (t . b_L)),
    U     = sum_p w_p k / 2 (theta - theta_0)^2.

Of the angles that differ by full turns the one nearest to a reference is taken. With G = |t| n / |n|^2 and
s = t . b / |t|^2

    theta,b_L = G_L,   theta,b_R = -G_R,   theta,t = s_R G_R - s_L G_L
    dG/db = |t| / |n|^2 H [t]x,    dG/dt = n t' / (|t| |n|^2) - |t| / |n|^2 H [b]x,    H = I - 2 n n' / |n|^2
    ds/dt = (b - 2 s t) / |t|^2

A crease joins the nine rows of q of each of its two elements; t is taken from the left one, for the fold condition (48)
makes both the same. Source of the angle's derivatives: E. Grinspun et al., Discrete shells, SCA 2003, 62-67.
"""

import warp as wp

from .membrane import NODES
from .precision import mat33, real, vec3
from .pressure import skew

ROWS = 18
"""Rows of q that a crease joins."""

TURN = wp.constant(real(6.283185307179586))

wp.set_module_options({"max_unroll": 0})


@wp.struct
class Frame:
    """t, b_L and b_R at a point."""

    along: vec3
    left: vec3
    right: vec3


@wp.struct
class Arm:
    """The part that one side has in the angle: G, s, dG/db, dG/dt and minus d(s G)/dt."""

    g: vec3
    s: real
    by_across: mat33
    by_along: mat33
    along_along: mat33


@wp.func
def frame_at(q: wp.array(dtype=vec3), rows: wp.array2d(dtype=wp.int32), shapes: wp.array3d(dtype=vec3), e: int, p: int):
    """Derivatives along and across crease e at its point p."""
    f = Frame()
    for i in range(2 * NODES):
        c = shapes[e, p, i]
        node = q[rows[e, i]]
        f.along += c[0] * node
        f.left += c[1] * node
        f.right += c[2] * node
    return f


@wp.func
def fold_angle(f: Frame, reference: real):
    """theta within half a turn of the reference."""
    t2 = wp.dot(f.along, f.along)
    y = wp.sqrt(t2) * wp.dot(f.along, wp.cross(f.right, f.left))
    x = t2 * wp.dot(f.right, f.left) - wp.dot(f.along, f.right) * wp.dot(f.along, f.left)
    theta = wp.atan2(y, x)
    return theta + TURN * wp.round((reference - theta) / TURN)


@wp.func
def arm(t: vec3, b: vec3):
    """What one side contributes."""
    t2 = wp.dot(t, t)
    length = wp.sqrt(t2)
    n = wp.cross(t, b)
    n2 = wp.dot(n, n)
    h = (length / n2) * (wp.identity(n=3, dtype=real) - (real(2.0) / n2) * wp.outer(n, n))
    a = Arm()
    a.g = (length / n2) * n
    a.s = wp.dot(t, b) / t2
    a.by_across = h * skew(t)
    a.by_along = wp.outer(n, t) / (length * n2) - h * skew(b)
    a.along_along = -wp.outer(a.g, (b - real(2.0) * a.s * t) / t2) - a.s * a.by_along
    return a


@wp.kernel(enable_backward=False)
def crease_gradient(
    q: wp.array(dtype=vec3),
    rows: wp.array2d(dtype=wp.int32),
    shapes: wp.array3d(dtype=vec3),
    stiffness: wp.array2d(dtype=real),
    rest: wp.array(dtype=real),
    reference: wp.array2d(dtype=real),
    begin: int,
    # out
    energy: wp.array(dtype=real),
    gradient: wp.array2d(dtype=vec3),
    angles: wp.array2d(dtype=real),
):
    """Energy, its gradient and the fold angles, one thread per crease edge; stiffness is w_p k."""
    e = begin + wp.tid()
    total = real(0.0)
    for i in range(ROWS):
        gradient[e, i] = vec3()
    for p in range(stiffness.shape[1]):
        f = frame_at(q, rows, shapes, e, p)
        theta = fold_angle(f, reference[e, p])
        left = arm(f.along, f.left)
        right = arm(f.along, f.right)
        k = stiffness[e, p]
        moment = k * (theta - rest[e])
        total += real(0.5) * moment * (theta - rest[e])
        along = right.s * right.g - left.s * left.g
        for i in range(ROWS):
            c = shapes[e, p, i]
            gradient[e, i] = gradient[e, i] + moment * (c[0] * along + c[1] * left.g - c[2] * right.g)
        angles[e, p] = theta
    energy[e] = total


@wp.kernel(enable_backward=False)
def crease_tangent(
    q: wp.array(dtype=vec3),
    rows: wp.array2d(dtype=wp.int32),
    shapes: wp.array3d(dtype=vec3),
    stiffness: wp.array2d(dtype=real),
    rest: wp.array(dtype=real),
    reference: wp.array2d(dtype=real),
    geometric: wp.bool,
    first: int,
    begin: int,
    # out
    blocks: wp.array(dtype=mat33),
):
    """Tangents of the pairs of rows i <= j, one thread per crease edge, in `blocks` from `first` on."""
    e = begin + wp.tid()
    start = first + e * ((ROWS * (ROWS + 1)) // 2)
    for k in range((ROWS * (ROWS + 1)) // 2):
        blocks[start + k] = mat33()
    for p in range(stiffness.shape[1]):
        f = frame_at(q, rows, shapes, e, p)
        left = arm(f.along, f.left)
        right = arm(f.along, f.right)
        w = stiffness[e, p]
        moment = real(0.0)
        if geometric:
            moment = w * (fold_angle(f, reference[e, p]) - rest[e])
        along = right.s * right.g - left.s * left.g
        tt = w * wp.outer(along, along) + moment * (left.along_along - right.along_along)
        lt = w * wp.outer(left.g, along) + moment * left.by_along
        rt = -w * wp.outer(right.g, along) - moment * right.by_along
        ll = w * wp.outer(left.g, left.g) + moment * left.by_across
        rr = w * wp.outer(right.g, right.g) - moment * right.by_across
        lr = -w * wp.outer(left.g, right.g)
        k = start
        for i in range(ROWS):
            c = shapes[e, p, i]
            by_t = c[0] * tt + c[1] * lt + c[2] * rt  # its transpose is what row i has with t
            by_l = c[0] * wp.transpose(lt) + c[1] * ll + c[2] * wp.transpose(lr)
            by_r = c[0] * wp.transpose(rt) + c[1] * lr + c[2] * rr
            for j in range(i, ROWS):
                d = shapes[e, p, j]
                blocks[k] = blocks[k] + d[0] * by_t + d[1] * by_l + d[2] * by_r
                k += 1
