"""How fast layers may come to meet and how hard they are pressed on each other, from what the scene says alone.

    speed = largest difference between the speeds of two points, driven or given at the start, + gained
    gained = min(a T, sqrt(2 a L), a / alpha),   a = sum of |g|, |p| / (rho h), |F| / M

Where something is driven, the rest of the sheet may stand still. T is the duration, L the size of the sheet, alpha the
mass damping. Layers do not meet faster than that unless a mechanism near a singular position amplifies the drive. In
statics nothing moves.

    pressure = sum of |p|, rho h |g|, |F| / A  +  E h e / L

The last is that of a film strained by e = 1e-3 over a curve as wide as the sheet: what is taut presses on what it lies
on, even where nothing else does.
"""

from dataclasses import dataclass

import numpy as np

from warp_origami.model.constraints import Constraints
from warp_origami.model.hub import ROWS as HUB_ROWS
from warp_origami.model.hub import Hub
from warp_origami.model.mesh import Mesh
from warp_origami.model.prescribed import PrescribedRows, prescribed_motion

from .document import Scene
from .motion import Profile

SAMPLES = 200
"""Times at which motion and loads are looked at."""

WORKING_STRAIN = 1e-3
"""e, of taut films."""


@dataclass(frozen=True)
class Approach:
    """What presses layers together.

    Attributes:
        speed: at which they meet, m/s.
        pressure: that holds them on each other, Pa.
        force: largest force on a part of the sheet, which may press with a single point, N.
    """

    speed: float
    pressure: float
    force: float


def expected_approach(
    scene: Scene, mesh: Mesh, constraints: Constraints, velocities: np.ndarray, hub: Hub | None = None
) -> Approach:
    """The approach that a scene lets expect; `velocities` (k, 3) are those of points of the sheet at the start, m/s."""
    material, area = scene.material, float(mesh.areas.sum())
    areal_mass = material.density * material.thickness
    acceleration = force = 0.0
    pressure = material.youngs_modulus * material.thickness * WORKING_STRAIN / mesh.size
    for load in scene.load:
        if load.kind in ("initial_velocity", "initial_spin"):
            continue
        factor = _largest(load.profile, scene.analysis.end)
        if load.kind == "pressure":
            here = abs(load.value) * factor
        elif load.kind == "solar":
            here = 2.0 * load.value * factor
        elif load.kind == "gravity":
            strength = float(np.linalg.norm(load.acceleration)) * factor
            here = areal_mass * strength
            force = max([force, *(mass.value * strength for mass in scene.mass)])
        else:
            total = float(np.linalg.norm(load.value)) * factor
            here = total / area
            force = max(force, total if load.at.kind != "all" else 0.0)
        pressure += here
        acceleration += here / areal_mass
    if scene.analysis.kind != "dynamic":
        return Approach(0.0, pressure, force)
    gained = [acceleration * scene.analysis.end, np.sqrt(2.0 * acceleration * mesh.size)]
    if material.mass_damping > 0.0:
        gained.append(acceleration / material.mass_damping)
    speed = _largest_difference(constraints, velocities, scene.analysis.end, hub) + min(gained)
    return Approach(float(speed), pressure, force)


def _largest_difference(constraints: Constraints, velocities: np.ndarray, end: float, hub: Hub | None) -> float:
    """Between the velocities of points at the start, driven points at any time, and rest if anything is driven; m/s."""
    rows, prescribers = constraints.rows, constraints.prescribers
    profiles = [p.motion.profile for p in prescribers if p.motion is not None]
    if not profiles:
        return _span(velocities)
    kinks = {t for profile in profiles for t in profile.kinks if 0.0 <= t < end}
    still = np.append(velocities, np.zeros((1, 3)), axis=0)
    spans = []
    for time in [*np.linspace(0.0, end, SAMPLES + 1), *kinks]:
        driven = prescribed_motion(prescribers, rows, time)[1]
        spans.append(_span(np.concatenate([driven[~rows.slopes], _led_by(hub, rows, driven), still])))
    return max(spans)


def _led_by(hub: Hub | None, rows: PrescribedRows, driven: np.ndarray) -> np.ndarray:
    """(k, 3) velocities of the points that are fixed to a hub all of whose rows are driven."""
    mine = np.zeros(0, dtype=int) if hub is None else np.flatnonzero(rows.vertices == hub.vertex)
    if len(mine) < HUB_ROWS:
        return np.zeros((0, 3))
    return np.array([tie.hub @ driven[mine] for tie in hub.ties if len(tie.entries) == 1]).reshape(-1, 3)


def _span(velocities: np.ndarray) -> float:
    """Bound of the largest difference between velocities (k, 3)."""
    return float(np.linalg.norm(np.ptp(velocities, axis=0))) if len(velocities) else 0.0


def _largest(profile: Profile, end: float) -> float:
    """Largest magnitude of a factor until `end`."""
    factor = profile.factor()
    kinks = [t for t in factor.kinks if 0.0 <= t <= end]
    return max(abs(factor(time)) for time in [*np.linspace(0.0, end, SAMPLES + 1), *kinks])
