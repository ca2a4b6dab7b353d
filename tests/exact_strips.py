"""Exact solutions of strips: stretched, and bent in their plane until one side wrinkles."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Stretched:
    """A strip pulled to 1 + strain times its length."""

    force: float
    """N."""
    stress: float
    """Second Piola-Kirchhoff, Pa."""
    energy: float
    """Per reference volume, J/m^3."""
    width: float
    """Stretch of the width."""


def uniaxial(youngs_modulus, nu, strain, width=1.0, thickness=1.0):
    """Strip of free sides pulled to the stretch 1 + strain (engineering strain), lengths in m, modulus in Pa.

    St. Venant-Kirchhoff: e = strain + strain^2 / 2, S = E e, force S (1 + strain) times the reference section, energy
    E e^2 / 2, lateral strain -nu e. The program's law gives the same for any residual stiffness.
    """
    e = strain + 0.5 * strain**2
    force = youngs_modulus * e * (1.0 + strain) * width * thickness
    return Stretched(force, youngs_modulus * e, 0.5 * youngs_modulus * e**2, math.sqrt(1.0 - 2.0 * nu * e))


@dataclass(frozen=True)
class Bent:
    """A rectangle under a centred force P and a moment M, bent in its plane to the curvature kappa."""

    moment: float
    """2 M / (P H), positive where the stretched side is y > 0."""
    wrinkled: float
    """Height of the compressed part, b / H."""
    strain: float
    """Axial strain eps0 on the centre line y = 0."""
    curvature: float
    """kappa H: the axial strain is eps0 + kappa y."""


def bent_rectangle(k, load=1e-5, s=0.0):
    """Rectangle of height H at k' = E t H^2 kappa / (2 P) >= 0 and load = P / (E t H), residual stiffness s < 1.

    Uniaxial law sigma = E e, e = eps0 + kappa y, on -H/2 < y < H/2, and s E e where e < 0 (the program's slack side
    with free lateral motion). For k' <= 1 nothing is compressed: eps0 = load, 2 M / (P H) = k' / 3. Beyond, for the
    compressed height c = b / H, with f = 1 - c:

        1 / k' = f^2 - s c^2,   2 M / (P H) = k' (f^2 (1 - 2 f/3) + s c^2 (1 - 2 c/3)),   eps0 = kappa H (1/2 - c)

    For s = 0 these are b / H = 1 - k'^(-1/2), 2 M / (P H) = 1 - 2/3 k'^(-1/2). Stein and Hedgepeth, Analysis of partly
    wrinkled membranes, NASA TN D-813 (1961). To hold the state prescribe the axial displacements
    +- (eps0 + kappa y) L / 2 on the ends of a strip of length L. Small strain and small deflection kappa L^2 / 8.
    """
    curvature = 2.0 * load * k
    if k <= 1.0:
        return Bent(k / 3.0, 0.0, load, curvature)
    # (1 - s) c^2 - 2 c + 1 - 1/k = 0
    rest = 1.0 - 1.0 / k
    c = rest / (1.0 + math.sqrt(1.0 - (1.0 - s) * rest))
    f = 1.0 - c
    moment = k * (f**2 * (1.0 - 2.0 * f / 3.0) + s * c**2 * (1.0 - 2.0 * c / 3.0))
    return Bent(moment, c, curvature * (0.5 - c), curvature)
