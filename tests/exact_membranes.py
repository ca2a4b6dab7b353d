"""Exact solutions of stretched and inflated membranes: drum, pressurized disc, pillow (numpy and scipy only).

Nothing here uses the program. Lengths are relative to the flat radius a where a function says so, stresses to Young's
modulus E, the load is q = p a / (E h).
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import beta, ellipk

POLE = 1e-5
"""Reference radius, relative to a, where the integration starts; what is left out inside is of its square."""


# Transverse motion of a stretched rectangle --------------------------------------------------------------------------


@dataclass(frozen=True)
class Mode:
    """A mode of the drum: half waves m along the first side and n along the second, frequency in Hz."""

    m: int
    n: int
    frequency: float


def drum(a, stress, density, count, b=None):
    """Lowest `count` modes of a rectangle a x b (m; b = a unless given) held at its rim, by frequency.

    f_mn = sqrt(S / rho) / 2 sqrt((m / a)^2 + (n / b)^2) with the uniform second Piola-Kirchhoff stress S (Pa) and the
    reference density rho (kg/m^3) on the flat sides: exact at any stretch. Rayleigh, Theory of Sound, section 198.
    """
    b = a if b is None else b
    speed = np.sqrt(stress / density)
    # the first count of them have m, n <= count
    pairs = [(m, n) for m in range(1, count + 1) for n in range(1, count + 1)]
    modes = [Mode(m, n, float(0.5 * speed * np.hypot(m / a, n / b))) for m, n in pairs]
    return sorted(modes, key=lambda mode: (mode.frequency, mode.m))[:count]


def drum_deflection(x=0.5, y=0.5, b_over_a=1.0):
    """Static deflection w S h / (p a^2) of the drum under a uniform pressure p, at the fractions x, y of its sides.

    Solves w_xx + w_yy = -1 on 1 x b/a, w = 0 on the rim, by the one-dimensional solution less the series of its
    trace, w = x (1 - x) / 2 - sum 4 / (pi k)^3 sin(k pi x) cosh(k pi (y - 1/2) b/a) / cosh(k pi b / (2 a)), k odd,
    summed until the terms fall below round-off. 0.0736714 at the centre of a square.
    """
    k = np.arange(1, 20001, 2)
    upper, middle = 0.5 * np.pi * k * b_over_a, np.pi * k * abs(y - 0.5) * b_over_a
    ratio = np.exp(middle - upper) * (1.0 + np.exp(-2.0 * middle)) / (1.0 + np.exp(-2.0 * upper))
    return 0.5 * x * (1.0 - x) - float(np.sum(4.0 / (np.pi * k) ** 3 * np.sin(np.pi * k * x) * ratio))


# The law in principal directions -------------------------------------------------------------------------------------


def law_moduli(taut, nu, s):
    """(K11, K12, K22) of t1 = K11 g1 + K12 g2, t2 = K12 g1 + K22 g2 relative to E, g1 >= g2, s1 = s2 = s.

    Taut where g2 + nu g1 >= 0: plane stress, St. Venant-Kirchhoff. Wrinkled below: the stiffness reduction model of
    the program, whose s = 0 is tension field theory (t2 = 0).
    """
    if taut:
        k = 1.0 / (1.0 - nu**2)
        return k, nu * k, k
    k = 1.0 / (1.0 - s * nu**2)
    return k, s * nu * k, s * k


# Axisymmetric membranes under pressure -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Revolved:
    """A membrane of revolution, lengths relative to the flat radius a, stresses (second Piola-Kirchhoff) to E."""

    w0: float
    """Height of the pole over the rim."""
    stress_pole: float
    stress_rim: float
    """Radial."""
    rim_radius: float
    volume: float
    """Between the membrane and the plane of its rim, relative to a^3; a pillow has two of it."""
    energy: float
    """Strain energy of this membrane, U / (E h a^2)."""
    wrinkled_from: float | None
    """Reference radius beyond which the hoops wrinkle; None if they do nowhere."""
    R: np.ndarray
    """Reference radii, n samples from the pole to 1; the arrays below are sampled there."""
    r: np.ndarray
    z: np.ndarray
    S1: np.ndarray
    """Radial stress."""
    S2: np.ndarray
    """Hoop stress."""


def clamped_disc(q, nu, follower=True, samples=201):
    """Disc whose rim is held at r = a, z = 0, under the pressure q = p a / (E h) or a dead load of that size along z.

    Minimizes 2 pi h int W R dR less the work of the load over r(R), z(R), St. Venant-Kirchhoff in plane stress, W per
    reference volume. With the stretches l1 = sqrt(r'^2 + z'^2), l2 = r / R, the Green-Lagrange strains
    e = (l^2 - 1) / 2 and the first Piola-Kirchhoff stresses T = l S, r' = l1 cos, z' = l1 sin of the slope:

        follower  R T1 sin = -q r^2 / 2,  (R T1 cos)' = T2 + q r z'
        dead      R T1 sin = -q R^2 / 2,  (R T1 cos)' = T2

    and shoots for r(1) = 1 from the strain of the pole. It is taut everywhere. Raises ValueError where q <= 0 or no
    solution is bracketed. Returns a `Revolved`.
    """
    return _shoot(_Membrane(q, nu, 0.0, follower), lambda end: end[0] - 1.0, samples)


def pillow(q, nu, s, samples=201):
    """One of the two discs of a circular pillow under the follower pressure q = p a / (E h), residual stiffness s.

    As `clamped_disc`, with the law of the program (taut or wrinkled hoops) and a free rim in the plane z = 0: no
    radial force there, R T1 cos = 0. Raises ValueError where q <= 0 or no solution is bracketed. Returns a `Revolved`.
    """
    return _shoot(_Membrane(q, nu, s, True), lambda end: end[1], samples)


def mylar_balloon():
    """(w0, rim radius, volume of both halves) of the inextensible pillow, relative to a.

    Radius sqrt(2) / K(1/2) and height int t^2 / sqrt(1 - t^4) dt of it. Paulsen, What is the shape of a Mylar
    balloon?, American Mathematical Monthly 101 (1994) 953.
    """
    radius = np.sqrt(2.0) / ellipk(0.5)
    return float(radius * beta(0.75, 0.5) / 4.0), float(radius), float(0.5 * np.pi * radius**3 * beta(1.25, 0.5))


@dataclass(frozen=True)
class _Membrane:
    """Right-hand side in R of y = (r, R T1 cos, drop of z, volume, energy); E = h = a = 1."""

    q: float
    nu: float
    s: float
    follower: bool

    def stresses(self, traction, hoop_strain):
        """(l1, S1, S2, W, f1) at T1 = traction > 0 and the hoop strain; f1 = e2 + nu e1 < 0 where wrinkled.

        In either state S1 = K11 e1 + K12 e2 makes l1 S1 = T1 a cubic in l1 with one positive root.
        """
        for taut in (True, False):
            k11, k12, k22 = law_moduli(taut, self.nu, self.s)
            stretch = _positive_root(2.0 * k12 / k11 * hoop_strain - 1.0, 2.0 * traction / k11)
            strain = 0.5 * (stretch - 1.0) * (stretch + 1.0)
            switch = hoop_strain + self.nu * strain
            if switch >= 0.0:
                break
        s1, s2 = k11 * strain + k12 * hoop_strain, k12 * strain + k22 * hoop_strain
        return stretch, s1, s2, 0.5 * (s1 * strain + s2 * hoop_strain), switch

    def state(self, R, y):
        """(sin of the slope, cos, l1, S1, S2, W, f1)."""
        hoop = y[0] / R
        vertical = -0.5 * self.q * (hoop * y[0] if self.follower else R)
        traction = np.hypot(y[1] / R, vertical)
        law = self.stresses(traction, 0.5 * (hoop - 1.0) * (hoop + 1.0))
        return vertical / traction, y[1] / R / traction, *law

    def slope(self, R, y):
        sin, cos, stretch, _, s2, density, _ = self.state(R, y)
        drop = -stretch * sin
        push = s2 * y[0] / R - (self.q * y[0] * drop if self.follower else 0.0)
        return [stretch * cos, push, drop, np.pi * y[0] ** 2 * drop, 2.0 * np.pi * R * density]

    def start(self, strain):
        """y at R = POLE where both strains of the pole are `strain`, by the leading terms of the series."""
        stretch = np.sqrt(1.0 + 2.0 * strain)
        traction = strain / (1.0 - self.nu) * stretch
        curvature = 0.5 * self.q * stretch / traction * (stretch**2 if self.follower else 1.0)
        return [stretch * POLE, traction * POLE, 0.5 * curvature * POLE**2, 0.0, 0.0]

    def integrate(self, strain, sampled=False):
        """Pieces of the solution from the pole to 1, cut where wrinkling starts or ends."""

        def switch(R, y):
            return self.state(R, y)[-1]

        switch.terminal = True
        pieces, R, y = [], POLE, self.start(strain)
        while R < 1.0:
            options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14, "events": switch}
            pieces.append(solve_ivp(self.slope, (R, 1.0), y, dense_output=sampled, **options))
            R, y = pieces[-1].t[-1], pieces[-1].y[:, -1]
            if R < 1.0:  # a small step beyond the switch, so that it is not found again
                step = min(1e-9, 1.0 - R)
                y = y + step * np.array(self.slope(R, y))
                R += step
        return pieces


def _positive_root(c, d):
    """The positive root of x^3 + c x = d > 0, by Newton from an upper bound: the cubic is convex there."""
    x = np.sqrt(max(-c, 0.0)) + np.cbrt(d)
    for _ in range(100):
        change = (x * (x * x + c) - d) / (3.0 * x * x + c)
        x -= change
        if abs(change) < 4e-16 * x:
            break
    return x


def _shoot(membrane, miss, samples):
    """The solution whose end y(1) makes miss(y) zero, found from the strain of the pole."""
    if membrane.q <= 0.0:
        raise ValueError(f"q = {membrane.q}: wants a pressure above zero")

    def error(log_strain):
        return miss(membrane.integrate(np.exp(log_strain))[-1].y[:, -1])

    # small strain, nu = 0.3: e = 0.3 q^(2/3); the error grows with the strain of the pole
    low = high = np.log(0.3 * membrane.q ** (2.0 / 3.0))
    below = above = error(low)
    for _ in range(40):
        if below < 0.0 < above:
            break
        if above <= 0.0:
            low, below, high = high, above, high + 0.3
            above = error(high)
        else:
            high, above, low = low, below, low - 0.3
            below = error(low)
    else:
        raise ValueError(f"q = {membrane.q}: no solution found")
    strain = np.exp(brentq(error, low, high, xtol=1e-13, rtol=1e-14))
    return _sampled(membrane, strain, samples)


def _sampled(membrane, strain, samples):
    pieces = membrane.integrate(strain, sampled=True)
    R = np.linspace(0.0, 1.0, samples)
    inner = np.maximum(R, POLE)
    ends = np.array([piece.t[-1] for piece in pieces[:-1]])
    y = np.array([pieces[np.searchsorted(ends, at)].sol(at) for at in inner])
    stresses = np.array([membrane.state(at, row)[3:5] for at, row in zip(inner, y, strict=True)])
    radius, _, drop, volume, energy = y[-1]
    return Revolved(
        w0=float(drop),
        stress_pole=float(strain / (1.0 - membrane.nu)),
        stress_rim=float(stresses[-1, 0]),
        rim_radius=float(radius),
        volume=float(volume),
        energy=float(energy),
        wrinkled_from=float(ends[0]) if len(ends) and ends[0] < 1.0 - 1e-8 else None,
        R=R,
        r=np.where(R > 0.0, y[:, 0], 0.0),
        z=drop - y[:, 2],
        S1=stresses[:, 0],
        S2=stresses[:, 1],
    )
