"""The tables of loads as external forces."""

import numpy as np

from ..errors import InputError
from ..model.coordinates import Coordinates
from ..model.mesh import Mesh
from ..model.selectors import select
from ..scene import Scene
from ..scene.loads import Load
from ..terms.external import DeadForce, ExternalForces, Pressure
from ..terms.loads import force_weights, normal_weights
from ..terms.pressure import FollowerPressure
from ..terms.sunlight import Side, Sunlight


def make_loads(
    scene: Scene, mesh: Mesh, coordinates: Coordinates, weight: np.ndarray, q0: np.ndarray, device: str
) -> ExternalForces:
    """Gravity, forces, pressure and sunlight.

    Args:
        weight: (n,) generalized force of a unit acceleration of everything.
        q0: (n, 3) initial state, whose normals dead pressure has.

    Raises:
        InputError: a load on elements whose selection holds none.
    """
    dead, pressures = [], []
    for k, load in enumerate(scene.load):
        if load.kind in ("initial_velocity", "initial_spin"):
            continue
        profile = load.profile.factor()
        if load.kind == "gravity":
            dead.append(DeadForce(np.outer(weight, load.acceleration), profile))
            continue
        selection = select(load.at, mesh, f"load.{k}.at")
        if load.kind == "force":
            dead.append(DeadForce(np.outer(force_weights(mesh, coordinates, selection), load.value), profile))
            continue
        elements = np.flatnonzero(np.isin(mesh.triangles, selection.vertices).all(axis=1))
        if not len(elements):
            raise InputError(f"load.{k}.at", "a selection without whole elements", "all corners of some elements")
        if load.kind == "solar":
            sides = [Side(**vars(side)) for side in (load.front, load.back)]
            term = Sunlight(mesh, coordinates, elements, np.asarray(load.direction), *sides, device=device)
            pressures.append(Pressure(term, load.value, profile))
        elif load.follower:
            term = FollowerPressure(mesh, coordinates, elements, device=device)
            pressures.append(Pressure(term, load.value, profile))
        else:
            dead.append(DeadForce(load.value * normal_weights(mesh, coordinates, elements, q0), profile))
    return ExternalForces(coordinates.count, tuple(dead), tuple(pressures))


def load_name(load: Load) -> str:
    """What a load is called where a scene's terms are listed."""
    if load.kind == "solar":
        return Sunlight.name
    if load.kind != "pressure":
        return load.kind.replace("_", " ")
    return "follower pressure" if load.follower else "dead pressure"
