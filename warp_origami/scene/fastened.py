"""The hub of a scene and the springs along its creases, as the model and the terms want them."""

from dataclasses import dataclass

import numpy as np

from warp_origami.errors import InputError
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.hub import Hub, fasten_hub
from warp_origami.model.mesh import CREASE, Mesh
from warp_origami.model.pattern import Pattern
from warp_origami.model.prescribed import Motion, Prescriber
from warp_origami.model.selectors import select

from .document import Scene

RIGIDITY = 1e6
"""Energy that doubles the size of the hub over the energy of its rotation: it grows by half its inverse."""

STIFFER_THAN_FILM = 10.0
"""Stiffness of the hub over that of film of its size, at least."""


def scene_hub(
    scene: Scene, mesh: Mesh, coordinates: Coordinates, q0: np.ndarray, prescribers: list[Prescriber]
) -> Hub | None:
    """The hub in the initial state q0 (n, 3) of the sheet.

    Raises:
        InputError: a support or driver holds what is fixed to it.
    """
    if scene.hub is None:
        return None
    selection = select(scene.hub.at, mesh, "hub.at")
    for prescriber in prescribers:
        both = np.intersect1d(selection.vertices, prescriber.selection.vertices)
        if len(both):
            x, y = mesh.vertices[both[0]]
            wants = f"no points of the hub, to which the vertex at ({x:g}, {y:g}) is fixed"
            raise InputError(f"{prescriber.key}.at", "a selection with points of the hub", wants)
    centre = None if scene.hub.centre is None else np.asarray(scene.hub.centre, dtype=float)
    gyration = float(np.sqrt(scene.hub.axial_inertia / scene.hub.mass))
    return fasten_hub(mesh, coordinates, selection, q0, np.asarray(scene.hub.axis, dtype=float), centre, gyration)


def hub_motion(scene: Scene, hub: Hub) -> Motion | None:
    """The rotation of a driven hub about its axis."""
    if scene.hub.mount != "driven":
        return None
    profile = scene.hub.profile.factor()
    return Motion(profile, np.zeros(3), hub.frame[2], hub.centre, scene.hub.angle)


def hub_rate(scene: Scene, hub: Hub) -> np.ndarray:
    """(3,) angular velocity at the start in the hub's frame, rad/s."""
    rate = np.zeros(3)
    for load in scene.load:
        if load.kind == "initial_spin" and load.at.kind == "all":
            rate += load.rate * np.asarray(load.axis, dtype=float) / np.linalg.norm(load.axis)
    return hub.frame @ rate if scene.hub.mount == "free" else np.array([0.0, 0.0, rate @ hub.frame[2]])


def hub_stiffness(scene: Scene, hub: Hub) -> float:
    """J, of the energy that keeps it rigid: far above what its rotation and the sheet can do to it."""
    film = STIFFER_THAN_FILM * scene.material.youngs_modulus * scene.material.thickness * hub.radius**2
    if scene.analysis.kind != "dynamic":
        return film
    turning = max(scene.hub.axial_inertia, scene.hub.transverse_inertia)
    fastest = max(2.0 * np.pi / scene.analysis.end, float(np.linalg.norm(hub_rate(scene, hub))))
    return max(RIGIDITY * turning * fastest**2, film)


@dataclass(frozen=True)
class Springs:
    """Springs along creases.

    Attributes:
        edges: (k,) mesh edges; one that several tables select is there several times.
        stiffness: (k,) N m/rad per m.
        rest: (k,) fold angle without moment, rad.
    """

    edges: np.ndarray
    stiffness: np.ndarray
    rest: np.ndarray


def scene_springs(scene: Scene, pattern: Pattern) -> Springs | None:
    """Springs with a stiffness; None without any.

    Raises:
        InputError: a table selects no crease, or wants a stowed state that the pattern has not.
    """
    mesh, found = pattern.mesh, []
    for k, table in enumerate(scene.crease):
        chosen = np.zeros(len(mesh.vertices), dtype=bool)
        chosen[select(table.at, mesh, f"crease.{k}.at").vertices] = True
        creases = (mesh.edge_kinds == CREASE) & np.isin(mesh.edge_assignments, list(table.assignment))
        edges = np.flatnonzero(creases & chosen[mesh.edges].all(axis=1))
        if not len(edges):
            wants = f"creases with the letters {table.assignment} whose two ends are selected"
            raise InputError(f"crease.{k}", "a selection without such creases", wants)
        if table.rest_angle != "stowed":
            rest = np.full(len(edges), float(table.rest_angle))
        elif pattern.stowed is None:
            raise InputError(f"crease.{k}.rest_angle", '"stowed"', "a pattern with a stowed state, or a number (rad)")
        else:
            rest = _lettered(fold_angles(mesh, pattern.stowed), mesh.edge_assignments)[edges]
        if table.stiffness > 0.0:
            found.append((edges, np.full(len(edges), table.stiffness), rest))
    return Springs(*(np.concatenate(part) for part in zip(*found, strict=True))) if found else None


def _lettered(angles: np.ndarray, letters: np.ndarray) -> np.ndarray:
    """Fold angles whose sign at half a turn, where both mean the same place, is that of the crease's letter."""
    half = np.abs(np.abs(angles) - np.pi) < 1e-6
    sign = np.where(letters == "M", -1.0, np.where(letters == "V", 1.0, np.sign(angles)))
    return np.where(half, sign * np.abs(angles), angles)
