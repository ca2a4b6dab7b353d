"""The sheet that every program simulates, and what is read off its motion. NumPy only: every environment has it.

A square of side L = 0.6 m and thickness 0.5 mm, E = 2.5 GPa, nu = 0.34, rho = 1420 kg/m^3, without bending stiffness,
released flat and at rest under gravity. `swinging`: pinned along x = 0, 1 s. `sagging`: pinned along its rim, 0.1 s.

Position error: root of the mean square distance, over the 36 material points at (1/2 + i, 1/2 + j) L / 6 at 0.4 s, from
the reference. Energy drift: kinetic + strain + potential energy at the end less that of the start, over m g L / 2. Peak
strain: largest principal Green-Lagrange strain of the triangles between the nodes, sampled every millisecond.
"""

from dataclasses import dataclass, field

import numpy as np

SIDE, THICKNESS, YOUNG, POISSON, DENSITY, GRAVITY = 0.6, 5e-4, 2.5e9, 0.34, 1420.0, 9.81
AREAL_MASS = DENSITY * THICKNESS
ENERGY_SCALE = AREAL_MASS * SIDE**2 * GRAVITY * SIDE / 2.0
WAVE_SPEED = np.sqrt(YOUNG / DENSITY / (1.0 - POISSON**2))
DURATION = {"swinging": 1.0, "sagging": 0.1}
SAMPLE_STEP = 1e-3
POSITION_TIME = 0.4
_centres = (np.arange(6) + 0.5) * SIDE / 6
POINTS = np.stack(np.meshgrid(_centres, _centres, indexing="ij"), axis=-1).reshape(-1, 2)
_lines = np.linspace(0.0, SIDE, 23)
SAG_POINTS = np.stack(np.meshgrid(_lines, _lines, indexing="ij"), axis=-1).reshape(-1, 2)
SAG_TIMES = np.linspace(0.01, 0.1, 10)
SAG_REFERENCE = -1e-3 * np.array([0.40, 1.20, 1.55, 1.10, 0.50, 0.14, 0.33, 1.17, 1.71, 0.94])


@dataclass(frozen=True)
class Grid:
    """nx x ny cells of two triangles; vertex (i, j) has number i (ny + 1) + j.

    Attributes:
        flat: (n, 2) vertices, m.
        triangles: (t, 3) with diagonals in turns.
    """

    nx: int
    ny: int
    flat: np.ndarray = field(init=False)
    triangles: np.ndarray = field(init=False)

    def __post_init__(self):
        x, y = np.linspace(0.0, SIDE, self.nx + 1), np.linspace(0.0, SIDE, self.ny + 1)
        object.__setattr__(self, "flat", np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2))
        i, j = (k.ravel() for k in np.meshgrid(np.arange(self.nx), np.arange(self.ny), indexing="ij"))
        a, b = i * (self.ny + 1) + j, (i + 1) * (self.ny + 1) + j
        c, d = b + 1, a + 1
        even = np.stack([a, b, c, a, c, d], axis=1)
        odd = np.stack([a, b, d, b, c, d], axis=1)
        triangles = np.where(((i + j) % 2 == 1)[:, None], odd, even).reshape(-1, 3)
        object.__setattr__(self, "triangles", triangles)

    def held(self, scene: str) -> np.ndarray:
        """(n,) whether a vertex is pinned."""
        x, y = self.flat.T
        left = x < 1e-9
        if scene == "swinging":
            return left
        return left | (x > SIDE - 1e-9) | (y < 1e-9) | (y > SIDE - 1e-9)

    def at(self, q: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(p, 3) values at flat points of values (n, 3) at the vertices, bilinear in each cell."""
        u = points / SIDE * (self.nx, self.ny)
        cell = np.minimum(u.astype(int), (self.nx - 1, self.ny - 1))
        s, t = (u - cell).T[:, :, None]
        first = cell[:, 0] * (self.ny + 1) + cell[:, 1]
        up = first + self.ny + 1
        return (1 - s) * ((1 - t) * q[first] + t * q[first + 1]) + s * ((1 - t) * q[up] + t * q[up + 1])


class Triangles:
    """Strains and energies of flat triangles with linear displacements.

    Attributes:
        areas: (t,) m^2.
        masses: (n,) kg, a third of each triangle at its vertices.
    """

    def __init__(self, flat: np.ndarray, triangles: np.ndarray):
        self.triangles = triangles
        e1, e2 = (flat[triangles[:, k]] - flat[triangles[:, 0]] for k in (1, 2))
        det = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
        self.areas = 0.5 * np.abs(det)
        self.inverse = (
            np.stack([e2[:, 1], -e2[:, 0], -e1[:, 1], e1[:, 0]], axis=1).reshape(-1, 2, 2) / det[:, None, None]
        )
        shares = np.repeat(self.areas * AREAL_MASS / 3.0, 3)
        self.masses = np.bincount(triangles.ravel(), shares, len(flat))

    def strains(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(t,) Green-Lagrange strains xx, yy, xy of positions q (n, 3)."""
        corners = q[self.triangles]
        edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
        slopes = edges @ self.inverse
        x, y = slopes[:, :, 0], slopes[:, :, 1]
        return 0.5 * ((x * x).sum(1) - 1.0), 0.5 * ((y * y).sum(1) - 1.0), 0.5 * (x * y).sum(1)

    def peak_strain(self, q: np.ndarray) -> float:
        """Largest principal strain."""
        xx, yy, xy = self.strains(q)
        return float(np.max(0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)))

    def energy(self, q: np.ndarray, v: np.ndarray) -> float:
        """Kinetic + strain + potential energy of positions q (n, 3) and velocities v (n, 3), J."""
        xx, yy, xy = self.strains(q)
        density = xx**2 + yy**2 + 2.0 * POISSON * xx * yy + 2.0 * (1.0 - POISSON) * xy**2
        strain = 0.5 * YOUNG * THICKNESS / (1.0 - POISSON**2) * float(self.areas @ density)
        motion = 0.5 * float(self.masses @ (v * v).sum(1)) + GRAVITY * float(self.masses @ q[:, 2])
        return strain + motion


class Recorder:
    """Takes what is asked for from positions at times that are multiples of SAMPLE_STEP."""

    def __init__(self, grid: Grid, triangles: np.ndarray):
        self.grid, self.elements = grid, Triangles(grid.flat, triangles)
        self.peak, self.positions, self.sags, self.first_energy, self.last_energy = 0.0, None, {}, None, None

    def add(self, sample: int, q: np.ndarray, v: np.ndarray | None = None) -> None:
        """State at sample * SAMPLE_STEP: positions (n, 3), m, velocities, m/s, in the order of the grid."""
        if not np.all(np.isfinite(q)):
            raise FloatingPointError(f"not a number at {sample * SAMPLE_STEP:.3f} s")
        self.peak = max(self.peak, self.elements.peak_strain(q))
        if self.peak > 1.0:
            raise FloatingPointError(f"unstable at {sample * SAMPLE_STEP:.3f} s")
        if sample == round(POSITION_TIME / SAMPLE_STEP):
            self.positions = self.grid.at(q, POINTS)
        if sample % 10 == 0:
            self.sags[sample // 10] = float(self.grid.at(q, SAG_POINTS)[:, 2].mean())
        if v is not None:
            self.last_energy = self.elements.energy(q, v)
            if self.first_energy is None:
                self.first_energy = self.last_energy

    def result(self) -> dict:
        """What was asked for, for JSON."""
        drift = None if self.first_energy is None else (self.last_energy - self.first_energy) / ENERGY_SCALE
        return {
            "peak_strain": self.peak,
            "energy_drift": drift,
            "positions": None if self.positions is None else self.positions.tolist(),
            "sags": [self.sags.get(k) for k in range(1, 11)],
        }


def position_error(positions: np.ndarray, reference: np.ndarray) -> float:
    """Root mean square distance of (p, 3) positions, m."""
    return float(np.sqrt(np.mean(np.sum((np.asarray(positions) - reference) ** 2, axis=1))))


def sag_error(sags: np.ndarray, until: float = 0.1) -> float:
    """Largest error of the mean deflection at 10, 20, ... ms, up to a time (s), m."""
    count = round(until / 0.01)
    return float(np.max(np.abs(np.asarray(sags[:count], dtype=float) - SAG_REFERENCE[:count])))
