"""Stiffness reduction model of a wrinkling membrane, paper (9)-(15), (20).

With principal strains g1 >= g2, f1 = g2 + nu g1, f2 = g1 + s1 nu g2 and E Young's modulus:

    taut      f1 >= 0           2 W / E = g1^2 + f1^2 / (1 - nu^2)
    wrinkled  f1 < 0, f2 > 0    2 W / E = s1 g2^2 + f2^2 / (1 - s1 nu^2)
    slack     f2 <= 0           2 W / E = s1 g2^2 + s2 f2^2 / (1 - s1 s2 nu^2)

which are gamma' Gamma gamma of (11)-(13) as sums of squares: W is continuously differentiable over both switches.
With c = (E11 - E22) / R, s = 2 E12 / R, R = g1 - g2, the stress and the tangent in (E11, E22, 2 E12) are

    S = (t1 + t2) / 2 [1, 1, 0] + kappa / 2 [E11 - E22, E22 - E11, 2 E12],   kappa = (t1 - t2) / R
    C = H11 n1 n1' + H12 (n1 n2' + n2 n1') + H22 n2 n2' + kappa / 2 t t'
    n1 = [1 + c, 1 - c, s] / 2,   n2 = [1 - c, 1 + c, -s] / 2,   t = [s, -s, -c]

kappa is a constant where taut, and where slack if s1 = s2, so that equal principal strains need no limit. With s1 != s2
the slack law has a kink at g1 = g2 < 0; kappa is bounded there.

Newton's mixed iteration does not linearize the law next at the strain e' that a step leads to, but at the state of the
law closest to e' and to the stress s' that the linearized law gave it, in the metric of a modulus m between the
stiffnesses of taut and slack film: e + S(e) / m = e' + s' / m. Strain and stress then have equal parts in telling a
state from another, as in primal-dual methods (T. F. Chan, G. H. Golub, P. Mulet, SIAM J. Sci. Comput. 20 (1999)
1964-1977).
"""

import warp as wp

from .precision import mat22, mat33, real, vec2, vec3

NAME = "srm"
SLACK, WRINKLED, TAUT = 0, 1, 2

_SMALLEST_STRAIN = wp.constant(real(1e-150))  # its square is still a normal number
_KINK = wp.constant(real(1e-10))  # smallest R relative to |g2| in the bounded kappa
_SOFTER = wp.constant(real(100.0))  # e_taut / m: the mean, on a scale of powers, of stiffnesses that differ by 1e4


@wp.struct
class Parameters:
    """Material constants: Poisson's ratio, the stiffness ratios and the factors of (11)-(13)."""

    nu: real
    s1: real
    s2: real
    e_taut: real  # E / (1 - nu^2), Pa
    e_wrinkled: real  # E / (1 - s1 nu^2), Pa
    e_slack: real  # E / (1 - s1 s2 nu^2), Pa


@wp.struct
class Principal:
    """Principal strains g1 >= g2, direction (c, s) = (cos, sin) of twice the angle, and R = g1 - g2."""

    g: vec2
    c: real
    s: real
    r: real


def parameters(youngs_modulus: float, poisson_ratio: float, s1: float, s2: float) -> Parameters:
    """Constants of the law on the host; Young's modulus in Pa."""
    p = Parameters()
    nu2 = poisson_ratio**2
    p.nu, p.s1, p.s2 = poisson_ratio, s1, s2
    p.e_taut = youngs_modulus / (1.0 - nu2)
    p.e_wrinkled = youngs_modulus / (1.0 - s1 * nu2)
    p.e_slack = youngs_modulus / (1.0 - s1 * s2 * nu2)
    return p


@wp.func
def principal(strain: vec3):
    """Principal strains (10) and their direction."""
    difference = strain[0] - strain[1]
    mean = real(0.5) * (strain[0] + strain[1])
    p = Principal()
    p.r = wp.sqrt(difference * difference + strain[2] * strain[2])
    half = real(0.5) * p.r
    p.g = vec2(mean + half, mean - half)
    p.c = real(1.0)
    p.s = real(0.0)
    if p.r > _SMALLEST_STRAIN:
        inverse = real(1.0) / p.r
        p.c = difference * inverse
        p.s = strain[2] * inverse
    return p


@wp.func
def state_of(p: Parameters, g: vec2):
    """The criterion (15)."""
    if g[1] + p.nu * g[0] >= real(0.0):
        return TAUT
    if g[0] + p.s1 * p.nu * g[1] > real(0.0):
        return WRINKLED
    return SLACK


@wp.func
def principal_tangent(p: Parameters, state: int):
    """Gamma of (11)-(13), Pa: dt/dg, and t = Gamma g."""
    if state == TAUT:
        return mat22(p.e_taut, p.e_taut * p.nu, p.e_taut * p.nu, p.e_taut)
    if state == WRINKLED:
        coupling = p.e_wrinkled * p.s1 * p.nu
        return mat22(p.e_wrinkled, coupling, coupling, p.e_wrinkled * p.s1)
    coupling = p.e_slack * p.s1 * p.s2 * p.nu
    return mat22(p.e_slack * p.s2, coupling, coupling, p.e_slack * p.s1)


@wp.func
def rotation_modulus(p: Parameters, h: mat22, state: int, g: vec2, r: real):
    """kappa = (t1 - t2) / (g1 - g2), Pa."""
    if state == TAUT:
        return h[0, 0] - h[0, 1]
    floor = wp.max(r, wp.max(_KINK * wp.abs(g[1]), _SMALLEST_STRAIN))
    return h[0, 0] - h[0, 1] + (h[0, 0] - h[1, 1]) * g[1] / floor


@wp.func
def stress_from(strain: vec3, t: vec2, kappa: real):
    """Second Piola-Kirchhoff stress (S11, S22, S12), Pa, from principal stresses."""
    mean = real(0.5) * (t[0] + t[1])
    half = real(0.5) * kappa
    deviator = half * (strain[0] - strain[1])
    return vec3(mean + deviator, mean - deviator, half * strain[2])


@wp.func
def stress(p: Parameters, strain: vec3):
    """Energy density (J/m^3) and stress (Pa) at the Green-Lagrange strain (E11, E22, 2 E12)."""
    e = principal(strain)
    state = state_of(p, e.g)
    h = principal_tangent(p, state)
    t = h * e.g
    kappa = rotation_modulus(p, h, state, e.g, e.r)
    return real(0.5) * wp.dot(t, e.g), stress_from(strain, t, kappa)


@wp.func
def tangent(p: Parameters, strain: vec3):
    """Energy density (J/m^3), stress (Pa) and tangent dS/dE (Pa) at the strain (E11, E22, 2 E12)."""
    e = principal(strain)
    state = state_of(p, e.g)
    h = principal_tangent(p, state)
    t = h * e.g
    kappa = rotation_modulus(p, h, state, e.g, e.r)

    # n1 + n2 = [1, 1, 0] and n1 - n2 = [c, -c, s]
    quarter = real(0.25)
    a = quarter * (h[0, 0] + real(2.0) * h[0, 1] + h[1, 1])
    b = quarter * (h[0, 0] - h[1, 1])
    d = quarter * (h[0, 0] - real(2.0) * h[0, 1] + h[1, 1])
    half = real(0.5) * kappa
    deviator = d * e.c * e.c + half * e.s * e.s
    mixed = (d - half) * e.c * e.s
    bc = real(2.0) * b * e.c
    bs = b * e.s
    shear = d * e.s * e.s + half * e.c * e.c
    c = mat33(
        a + bc + deviator,
        a - deviator,
        bs + mixed,
        a - deviator,
        a - bc + deviator,
        bs - mixed,
        bs + mixed,
        bs - mixed,
        shear,
    )
    return real(0.5) * wp.dot(t, e.g), stress_from(strain, t, kappa), c


@wp.func
def principal_resolvent(p: Parameters, state: int, z: vec2):
    """g with g + Gamma g / m = z in a given state."""
    h = (_SOFTER / p.e_taut) * principal_tangent(p, state)
    a = real(1.0) + h[0, 0]
    d = real(1.0) + h[1, 1]
    inverse = real(1.0) / (a * d - h[0, 1] * h[0, 1])
    return vec2(inverse * (d * z[0] - h[0, 1] * z[1]), inverse * (a * z[1] - h[0, 1] * z[0]))


@wp.func
def next_strain(p: Parameters, at: vec3, to: vec3):
    """Strain to linearize the law at next, after a step to the strain `to` with the law linearized `at`."""
    _, s, c = tangent(p, at)
    s += c * (to - at)
    compliance = _SOFTER / p.e_taut
    z = principal(to + compliance * vec3(s[0], s[1], real(2.0) * s[2]))
    g = principal_resolvent(p, TAUT, z.g)
    if state_of(p, g) != TAUT:
        g = principal_resolvent(p, WRINKLED, z.g)
        if state_of(p, g) != WRINKLED:
            g = principal_resolvent(p, SLACK, z.g)
    mean = real(0.5) * (g[0] + g[1])
    half = wp.max(real(0.5) * (g[0] - g[1]), real(0.0))  # s1 != s2: at the kink of the slack law
    return vec3(mean + half * z.c, mean - half * z.c, real(2.0) * half * z.s)


@wp.func
def state(p: Parameters, strain: vec3):
    """State of the membrane, 0 slack, 1 wrinkled, 2 taut (15)."""
    return state_of(p, principal(strain).g)
