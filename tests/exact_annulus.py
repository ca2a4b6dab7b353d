"""Exact solutions of a stretched annulus twisted in its plane by a rigid hub (numpy and scipy only).

Nothing here uses the program. Lengths are relative to the hub's radius a, stresses to Young's modulus E.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, fsolve

from exact_membranes import law_moduli


@dataclass(frozen=True)
class Twisted:
    """An annulus twisted by its hub."""

    torque: float
    """T / T_w, T_w = 2 pi t a^2 s0."""
    rotation: float
    """phi E / s0."""
    wrinkled_to: float | None
    """R / a inside which it is wrinkled; None if it is taut."""
    energy: float
    """Strain energy of the whole sheet, U E / (s0^2 t a^2), prestress included."""


# Small strain, tension field theory ----------------------------------------------------------------------------------


def tension_field_annulus(b_over_a, nu, wrinkled_to=None, angle=None):
    """Annulus clamped at a and b after a uniform prestress s0, wrinkled to R = wrinkled_to a or at phi E / s0 = angle.

    Limit s0 / E -> 0 with uniaxial stress where wrinkled. E = a = 1, T' = T / (2 pi t), e0 = (1 - nu) s0, u and e0 + u'
    relative to the prestressed and the free state:

        taut      s_r = A + B / r^2,  s_t = A - B / r^2,  s_rt = T' / r^2,
                  u = r ((1 - nu) (A - s0) - (1 + nu) B / r^2),  u(b) = 0
        wrinkled  s_r s_t = s_rt^2, (r s_r)^2 = C - T'^2 / r^2: straight tension lines that pass the centre at the
                  distance r0 = T' / sqrt(C); with the way x = sqrt(r^2 - r0^2) along them the stress is sqrt(C) / x

    The strain has the direction of the stress: sqrt(C) / x along it, and across it what the hoop strain e0 + u / r asks
    for, so that u' = r0^2 u / (r x^2) + (x^2 - r0^2) (sqrt(C) / x^3 - e0 / x^2) and with G below

        u = x / r (K + G(x)),  G = sqrt(C) (ln x + r0^2 / (2 x^2)) - e0 (x + r0^2 / x),  u(a) = 0
        shear strain = 2 r0 / x (sqrt(C) / x - e0 - u / r)

    Stresses and u are continuous at R. Stein and Hedgepeth, NASA TN D-813 (1961). First wrinkle: T = T_w,
    phi E / s0 = (1 + nu) (1 - a^2 / b^2). Raises ValueError where no finite rotation reaches such a radius, where the
    rotation wrinkles it to the rim, or where not one of wrinkled_to and angle is given.
    """
    first = (1.0 + nu) * (1.0 - 1.0 / b_over_a**2)
    if (angle is None) == (wrinkled_to is None):
        raise ValueError("wants one of wrinkled_to and angle")
    if angle is None:
        found = _tension_field(b_over_a, nu, wrinkled_to)[0]
        if found.torque < 0.0:  # it would need a prestress below zero
            raise ValueError(f"wrinkled_to = {wrinkled_to}: wants a radius that a finite rotation reaches")
        return found
    if angle <= first:
        prestressed = np.pi * (1.0 - nu) * (b_over_a**2 - 1.0)
        return Twisted(angle / first, angle, None, prestressed + np.pi * angle**2 / first)

    def error(radius):  # the rotation is infinite at a radius below b and negative beyond
        return 1.0 / _tension_field(b_over_a, nu, radius)[0].rotation - 1.0 / angle

    low, high = 1.0 + 1e-9, b_over_a * (1.0 - 1e-9)
    if error(high) > 0.0:
        raise ValueError(f"angle = {angle}: the wrinkles reach the rim before")
    radius = brentq(error, low, high, xtol=1e-13, rtol=1e-14) if error(low) > 0.0 else low
    return _tension_field(b_over_a, nu, radius)[0]


def _tension_field(b, nu, R):
    """The solution wrinkled to R, and there the direction of the stress from the radius and its size over s0."""
    if not 1.0 < R < b:
        raise ValueError(f"wrinkled_to = {R}: wants a radius above 1 and below b / a = {b}")

    def prestrain(direction):
        """e0 and u(R) of the taut part, for a uniaxial stress 1 at R: A = 1/2, B = R^2 cos(2 direction) / 2."""
        varying = 0.5 * np.cos(2.0 * direction)
        e0 = 0.5 * (1.0 - nu) - (1.0 + nu) * varying * (R / b) ** 2  # u(b) = 0
        return e0, R * (0.5 * (1.0 - nu) - e0 - (1.0 + nu) * varying)

    def wrinkled(direction):
        """r0, sqrt(C) and u(x), from R inwards."""
        lever, way = R * np.sin(direction), R * np.cos(direction)  # r0, x at R
        e0, u = prestrain(direction)

        def primitive(x):
            return way * (np.log(x) + 0.5 * (lever / x) ** 2) - e0 * (x + lever**2 / x)

        constant = u * R / way - primitive(way)
        return lever, way, lambda x: x / np.hypot(x, lever) * (constant + primitive(x))

    def hub(direction):
        lever, _, u = wrinkled(direction)
        return u(np.sqrt(1.0 - lever**2))

    # the steepest tension line touches the hub
    direction = brentq(hub, 1e-6, np.arcsin(1.0 / R) * (1.0 - 1e-12), xtol=1e-14, rtol=1e-14)
    lever, way, u = wrinkled(direction)
    e0, _ = prestrain(direction)

    def turn(x):
        r = np.hypot(x, lever)
        return 2.0 * lever / r**2 * (way / x - e0 - u(x) / r)

    torque, hub_way, fall = lever * way, np.sqrt(1.0 - lever**2), 1.0 / R**2 - 1.0 / b**2
    rotation = quad(turn, hub_way, way, epsabs=0.0, epsrel=1e-12)[0] + (1.0 + nu) * torque * fall
    # int of sqrt(C)^2 / (2 x^2) inside, of (1 - nu) A^2 + (1 + nu) (B^2 + T'^2) / r^4 outside, B^2 + T'^2 = R^4 / 4
    energy = way**2 * np.log(way / hub_way) + 0.25 * ((1.0 - nu) * (b**2 - R**2) + (1.0 + nu) * R**4 * fall)
    s0 = e0 / (1.0 - nu)
    twisted = Twisted(float(torque / s0), float(rotation / s0), R, float(np.pi * energy / s0**2))
    return twisted, direction, 1.0 / s0


def _solve(error, start):
    found, details, _, message = fsolve(error, start, xtol=1e-12, full_output=True)
    if not np.max(np.abs(details["fvec"])) < 1e-8:
        raise ValueError(f"no such state: {message}")
    return found


# Finite strain, the law of the program -------------------------------------------------------------------------------


def twisted_annulus(b_over_a, nu, s0_over_E, wrinkled_to=None, angle=None, s=0.0):
    """The same with the program's law at a finite prestress, residual stiffness s, angle = phi E / s0.

    Both edges are held at (1 + stretch) R, at which the uniform second Piola-Kirchhoff stress is s0, and the hub is
    then turned by phi about its centre. r(R) and the turn t(R) make int W R dR stationary with, in the polar frame,

        E_RR = (r'^2 + r^2 t'^2 - 1) / 2,  E_TT = (r^2 / R^2 - 1) / 2,  2 E_RT = r^2 t' / R
        (R r' S_RR)' = R r t'^2 S_RR + 2 r t' S_RT + r S_TT / R,  R (r^2 t' S_RR + r^2 / R S_RT) = T / (2 pi t)

    T_w = 2 pi t a^2 s0 with the flat hub radius a. Integrated from the wrinkle front, where stress is uniaxial, both
    ways: taut out to b, wrinkled in to a. Raises ValueError as `tension_field_annulus`.
    """
    if (angle is None) == (wrinkled_to is None):
        raise ValueError("wants one of wrinkled_to and angle")
    sheet = _Sheet(b_over_a, nu, s, s0_over_E)
    if angle is not None:
        taut = _taut(sheet, angle)
        if taut is not None:
            return taut
    field = tension_field_annulus(b_over_a, nu, wrinkled_to, angle)
    if field.wrinkled_to is None:  # just beyond the first wrinkle, which comes later in small strain
        field = tension_field_annulus(b_over_a, nu, 1.0 + 1e-6)
    _, direction, stress = _tension_field(b_over_a, nu, field.wrinkled_to)

    def front(unknowns):
        """Radius and state of the front, and the solution inwards and outwards of it."""
        R = wrinkled_to if angle is None else unknowns[2]
        y = sheet.uniaxial(R, unknowns[0], unknowns[1] * s0_over_E)
        return R, y, sheet.integrate(R, 1.0, y, taut=False), sheet.integrate(R, b_over_a, y, taut=True)

    def error(unknowns):
        _, _, inner, outer = front(unknowns)
        hub, rim = inner.y[:, -1] / s0_over_E, outer.y[:, -1] / s0_over_E
        return [hub[0], rim[0]] if angle is None else [hub[0], rim[0], rim[3] - hub[3] - angle]

    start = [direction, stress] if angle is None else [direction, stress, field.wrinkled_to]
    R, y, inner, outer = front(_solve(error, start))
    if min(sheet.switches(outer)[1:]) < 0.0 or max(sheet.switches(inner)[1:]) > 0.0:
        raise ValueError("no such state: wrinkled and taut parts are not one each")
    rotation, energy = outer.y[3:, -1] - inner.y[3:, -1]
    return _twisted(sheet, sheet.torque(R, y), rotation, float(R), energy)


def _taut(sheet, angle):
    """The solution without wrinkles, None if there is none."""

    def solution(unknowns):
        return sheet.integrate(1.0, sheet.b, np.array([0.0, *(sheet.s0 * unknowns), 0.0, 0.0]), taut=True)

    def error(unknowns):
        end = solution(unknowns).y[:, -1] / sheet.s0
        return [end[0], end[3] - angle]

    shear = 2.0 * angle / (1.0 - 1.0 / sheet.b**2)
    end = solution(_solve(error, [0.0, shear]))
    if min(sheet.switches(end)) < 0.0:
        return None
    rotation, energy = end.y[3:, -1]
    return _twisted(sheet, sheet.torque(1.0, end.y[:, 0]), rotation, None, energy)


def _twisted(sheet, torque, rotation, wrinkled_to, energy):
    s0 = sheet.s0
    return Twisted(float(torque / s0), float(rotation / s0), wrinkled_to, float(energy / s0**2))


@dataclass(frozen=True)
class _Sheet:
    """Equilibrium as an ODE in R of y = (u, u', w, t, energy): r = (1 + stretch) R + u, w = r t'; E = a = 1."""

    b: float
    nu: float
    s: float
    s0: float

    @property
    def prestrain(self):
        return (1.0 - self.nu) * self.s0

    @property
    def prestretch(self):
        return np.sqrt(1.0 + 2.0 * self.prestrain)

    def strain(self, R, y):
        """(E_RR, E_TT, 2 E_RT), from displacements so that small ones lose no digits."""
        u, v, w = y[:3]
        radial = self.prestrain + self.prestretch * v + 0.5 * (v * v + w * w)
        hoop = self.prestrain + self.prestretch * u / R + 0.5 * (u / R) ** 2
        return np.array([radial, hoop, w * (self.prestretch + u / R)])

    def uniaxial(self, R, direction, strain):
        """y where the strains are `strain` along `direction` from the radius and -nu of it across; t = energy = 0."""
        cos, sin = np.cos(direction), np.sin(direction)
        radial = strain * (cos**2 - self.nu * sin**2)
        hoop = strain * (sin**2 - self.nu * cos**2)
        shear = 2.0 * (1.0 + self.nu) * strain * sin * cos
        stretch = np.sqrt(1.0 + 2.0 * hoop)
        w = shear / stretch
        u = 2.0 * R * (hoop - self.prestrain) / (stretch + self.prestretch)
        v = 2.0 * (radial - self.prestrain) - w**2
        return np.array([u, v / (np.sqrt(1.0 + 2.0 * radial - w**2) + self.prestretch), w, 0.0, 0.0])

    def law(self, strain, taut):
        """Stress and tangent in (RR, TT, RT)."""
        k11, k12, k22 = law_moduli(taut, self.nu, self.s)
        if taut:
            tangent = np.array([[k11, k12, 0.0], [k12, k11, 0.0], [0.0, 0.0, 0.5 * (k11 - k12)]])
            return tangent @ strain, tangent
        difference, spread = strain[0] - strain[1], np.hypot(strain[0] - strain[1], strain[2])
        g1, g2 = 0.5 * (strain[0] + strain[1] + spread), 0.5 * (strain[0] + strain[1] - spread)
        t1, t2 = k11 * g1 + k12 * g2, k12 * g1 + k22 * g2
        c, s = difference / spread, strain[2] / spread
        along, across = 0.5 * np.array([1.0 + c, 1.0 - c, s]), 0.5 * np.array([1.0 - c, 1.0 + c, -s])
        turn = np.array([s, -s, -c])  # of the principal directions
        mixed = np.outer(along, across)
        tangent = k11 * np.outer(along, along) + k12 * (mixed + mixed.T) + k22 * np.outer(across, across)
        return t1 * along + t2 * across, tangent + 0.5 * (t1 - t2) / spread * np.outer(turn, turn)

    def slope(self, R, y, taut):
        """y', from the two balances of the docstring of `twisted_annulus` differentiated along R."""
        u, v, w = y[:3]
        hoop, radial = self.prestretch + u / R, self.prestretch + v
        hoop_slope = (v - u / R) / R
        strain = self.strain(R, y)
        stress, tangent = self.law(strain, taut)
        # dE = change (u'', w') + rest
        change = np.array([[radial, w], [0.0, 0.0], [0.0, hoop]])
        rest = tangent @ np.array([0.0, hoop * hoop_slope, w * hoop_slope])
        known = tangent @ change
        matrix = np.array([radial * known[0], w * known[0] + hoop * known[2]]) + stress[0] * np.eye(2)
        lever = (w * stress[0] + hoop * stress[2]) * (1.0 + radial / hoop) / R
        force = stress[0] * w**2 / hoop + stress[1] * hoop + 2.0 * stress[2] * w - radial * stress[0]
        right = [force / R - radial * rest[0], -lever - hoop_slope * stress[2] - w * rest[0] - hoop * rest[2]]
        (a, b), (c, d) = matrix
        determinant = a * d - b * c
        second = (d * right[0] - b * right[1]) / determinant, (a * right[1] - c * right[0]) / determinant
        return np.array([v, *second, w / (R * hoop), np.pi * R * (stress @ strain)])

    def integrate(self, start, end, y, taut):
        small = 1e-13 * self.s0 * np.array([1.0, 1.0, 1.0, 1.0, self.s0])
        return solve_ivp(self.slope, (start, end), y, args=(taut,), method="DOP853", rtol=1e-10, atol=small)

    def switches(self, solution):
        """f1 = g2 + nu g1 over s0 along a solution: negative where wrinkled."""
        e = np.array([self.strain(R, y) for R, y in zip(solution.t, solution.y.T, strict=True)])
        mean, half = 0.5 * (e[:, 0] + e[:, 1]), 0.5 * np.hypot(e[:, 0] - e[:, 1], e[:, 2])
        return (mean - half + self.nu * (mean + half)) / self.s0

    def torque(self, R, y):
        """T / (2 pi t) of a taut state."""
        stress, _ = self.law(self.strain(R, y), True)
        hoop = self.prestretch + y[0] / R
        return R**2 * hoop * (y[2] * stress[0] + hoop * stress[2])
