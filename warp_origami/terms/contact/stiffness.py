"""Penalties from the penetration that they are to allow.

    eps_s = max(m v^2 / (2 d^2), p / d)
    eps_n = max(m_e v^2 / (5 d^2), p A_n / d, F / d)

Two equal free sheets of areal mass m that meet flat at the speed v penetrate by v sqrt(m / (2 eps_s)); under a pressure
p by p / eps_s. A point that hits a layer stops the mass that it moves, m_p: it penetrates by v sqrt(m_p / eps_n). For a
point of the sheet, m_p = 1 / (s^T M^-1 s) with its shape functions s; measured, it is 0.4 (median) to 0.9 of the mass
m_e of an element inside a sheet, and 0.01 to 0.02 of it at a free corner, whatever the sub-mesh. A pair of points
inside two sheets has half of that: with a fifth of m_e the worst pair goes 1.5 times as deep as wanted, a corner a
quarter. At a lasting pressure a node carries that of its part A_n of the area.

Both are taken as if nothing else helped; in `mixed`, where points of both kinds meet a layer, all go less deep.
"""

from dataclasses import dataclass

MOVED_SHARE = 0.2
"""Mass that two points that meet move, over that of an element."""


@dataclass(frozen=True)
class Film:
    """What is stopped: areal mass (kg/m^2), mean area of an element and area per node of the sub-mesh (m^2)."""

    areal_mass: float
    element_area: float
    node_area: float


def surface_stiffness(film: Film, speed: float, pressure: float, depth: float) -> float:
    """eps_s (N/m^3) for a penetration of `depth` (m) at a speed (m/s) or under a pressure (Pa), the larger."""
    return max(0.5 * film.areal_mass * (speed / depth) ** 2, pressure / depth)


def node_stiffness(film: Film, speed: float, pressure: float, force: float, depth: float) -> float:
    """eps_n (N/m), likewise, and under a force (N) on a single point."""
    mass = MOVED_SHARE * film.areal_mass * film.element_area
    return max(mass * (speed / depth) ** 2, pressure * film.node_area / depth, force / depth)
