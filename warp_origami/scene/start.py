"""Velocities at the start: those that the scene gives, as far as the constraints leave them free."""

import numpy as np

from warp_origami.model.constraints import Constraints
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.hub import Hub
from warp_origami.model.mesh import Mesh
from warp_origami.model.selectors import select

from .document import Scene


def initial_velocity(
    scene: Scene, mesh: Mesh, coordinates: Coordinates, constraints: Constraints, hub: Hub | None, q0: np.ndarray
) -> np.ndarray:
    """(n, 3) velocity of q at the start; raises InputError for a selection of nothing."""
    v = np.zeros_like(q0)
    for k, load in enumerate(scene.load):
        if load.kind not in ("initial_velocity", "initial_spin"):
            continue
        selection = select(load.at, mesh, f"load.{k}.at")
        positions = coordinates.positions[selection.vertices]
        if load.kind == "initial_velocity":
            v[positions] += np.asarray(load.value)
            if hub is not None and selection.whole:
                v[hub.first] += np.asarray(load.value)
            continue
        rate = load.rate * np.asarray(load.axis, dtype=float) / np.linalg.norm(load.axis)
        sectors = np.isin(coordinates.sector_vertices, selection.vertices)
        slopes = coordinates.sector_gradients[sectors, None] + np.arange(2)
        slopes = slopes.ravel()
        if hub is not None and selection.whole:
            positions, slopes = np.append(positions, hub.first), np.append(slopes, hub.rows[1:])
        v[positions] += np.cross(rate, q0[positions] - np.asarray(load.centre))
        v[slopes] += np.cross(rate, q0[slopes])
    velocity, _ = constraints.derivatives(0.0)
    free = constraints.null_space @ (constraints.left_inverse @ (v.ravel() - constraints.right_inverse @ velocity))
    return (free + constraints.right_inverse @ velocity).reshape(v.shape)
