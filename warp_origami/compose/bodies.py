"""Masses, the hub and the springs along creases: what is fastened to the sheet."""

import numpy as np
from scipy.sparse import csr_matrix, diags

from ..model.coordinates import Coordinates
from ..model.hub import Hub
from ..model.mesh import Mesh
from ..model.pattern import Pattern
from ..model.selectors import select
from ..scene import Scene
from ..scene.fastened import hub_rate, hub_stiffness, scene_springs
from ..terms.added_mass import added_mass
from ..terms.crease import CreaseSprings
from ..terms.hub import RigidHub, hub_masses, spinning_stress
from ..terms.inertia import mass_matrix


def make_mass(scene: Scene, mesh: Mesh, coordinates: Coordinates, hub: Hub | None) -> csr_matrix:
    """(n, n) scalar mass matrix, alike in x, y, z, of sheet, added masses and hub."""
    mass = mass_matrix(mesh, coordinates, scene.material.density, scene.material.thickness)
    for k, table in enumerate(scene.mass):
        mass = mass + table.value * added_mass(mesh, coordinates, select(table.at, mesh, f"mass.{k}.at"))
    if hub is not None:
        diagonal = np.zeros(coordinates.count)
        diagonal[hub.rows] = hub_masses(scene.hub.mass, scene.hub.axial_inertia, scene.hub.transverse_inertia)
        mass = mass + diags(diagonal)
    return csr_matrix(mass)


def make_hub(scene: Scene, hub: Hub | None, mass: csr_matrix) -> RigidHub | None:
    """What keeps the hub rigid; None for a scene without."""
    if hub is None:
        return None
    stress = spinning_stress(mass.diagonal()[hub.rows], hub_rate(scene, hub))
    return RigidHub(hub.first, hub_stiffness(scene, hub), stress)


def make_springs(
    scene: Scene, pattern: Pattern, mesh: Mesh, coordinates: Coordinates, device: str
) -> CreaseSprings | None:
    """Springs along creases; None for a scene without."""
    found = scene_springs(scene, pattern)
    if found is None:
        return None
    return CreaseSprings(mesh, coordinates, found.edges, found.stiffness, found.rest, device)
