"""Isotropic plane stress without wrinkling: (11) at every strain.

S = E / (1 - nu^2) [E11 + nu E22, nu E11 + E22, (1 - nu) E12],   2 W = S : E
"""

import warp as wp

from .precision import mat33, real, vec3

NAME = "linear"
TAUT = 2


@wp.struct
class Parameters:
    """Material constants."""

    nu: real
    e_taut: real  # E / (1 - nu^2), Pa


def parameters(youngs_modulus: float, poisson_ratio: float, s1: float, s2: float) -> Parameters:
    """Constants of the law on the host; Young's modulus in Pa. The stiffness ratios have no meaning in this law."""
    p = Parameters()
    p.nu = poisson_ratio
    p.e_taut = youngs_modulus / (1.0 - poisson_ratio**2)
    return p


@wp.func
def stress(p: Parameters, strain: vec3):
    """Energy density (J/m^3) and stress (Pa) at the Green-Lagrange strain (E11, E22, 2 E12)."""
    s = p.e_taut * vec3(
        strain[0] + p.nu * strain[1],
        p.nu * strain[0] + strain[1],
        real(0.5) * (real(1.0) - p.nu) * strain[2],
    )
    return real(0.5) * wp.dot(s, strain), s


@wp.func
def tangent(p: Parameters, strain: vec3):
    """Energy density (J/m^3), stress (Pa) and tangent dS/dE (Pa) at the strain (E11, E22, 2 E12)."""
    w, s = stress(p, strain)
    zero = real(0.0)
    coupling = p.e_taut * p.nu
    shear = real(0.5) * (p.e_taut - coupling)
    c = mat33(p.e_taut, coupling, zero, coupling, p.e_taut, zero, zero, zero, shear)
    return w, s, c


@wp.func
def next_strain(p: Parameters, at: vec3, to: vec3):
    """Strain to linearize the law at next, after a step to the strain `to` with the law linearized `at`."""
    return to


@wp.func
def state(p: Parameters, strain: vec3):
    """Always taut: this law knows no other state."""
    return TAUT
