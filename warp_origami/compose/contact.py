"""The table of contact as terms: layers held apart, friction between them, numbers for every "auto"."""

import numpy as np

from ..errors import InputError
from ..model.constraints import Constraints
from ..model.coordinates import Coordinates
from ..model.crossing import find_crossing
from ..model.hub import Hub
from ..model.mesh import Mesh
from ..model.pattern import Pattern
from ..model.submesh import default_divisions
from ..scene import Scene
from ..scene.approach import expected_approach
from ..scene.settings import Contact as ContactTable
from ..terms.contact import Contact
from ..terms.contact.friction import FrictionLaw
from ..terms.contact.stiffness import Film, node_stiffness, surface_stiffness


def contact_settings(
    scene: Scene, mesh: Mesh, coordinates: Coordinates, constraints: Constraints, v0: np.ndarray, hub: Hub | None
) -> ContactTable:
    """The scene's table with the numbers that stand for every "auto"; `v0` (n, 3) is the initial velocity."""
    contact, material = scene.contact, scene.material
    if "auto" not in (contact.sts_stiffness, contact.nts_stiffness):
        return contact
    velocities = v0[coordinates.positions[coordinates.positions >= 0]]
    approach = expected_approach(scene, mesh, constraints, velocities, hub)
    speed = approach.speed if contact.expected_speed == "auto" else contact.expected_speed
    depth = contact.target_penetration * contact.thickness
    divisions = default_divisions(len(mesh.triangles))
    element = float(mesh.areas.mean())
    film = Film(material.density * material.thickness, element, 2.0 * element / divisions**2)
    found = {
        "sts_stiffness": surface_stiffness(film, speed, approach.pressure, depth),
        "nts_stiffness": node_stiffness(film, speed, approach.pressure, approach.force, depth),
    }
    numbers = {key: value for key, value in found.items() if getattr(contact, key) == "auto"}
    return contact.model_copy(update={"expected_speed": speed, **numbers})


def make_contact(
    scene: Scene,
    settings: ContactTable,
    pattern: Pattern,
    mesh: Mesh,
    coordinates: Coordinates,
    q0: np.ndarray,
    device: str,
) -> Contact:
    """Contact of the sheet with itself, from the initial state q0 (n, 3).

    Raises:
        InputError: layers cross or coincide in that state.
    """
    crossing = find_crossing(q0[np.maximum(coordinates.positions, 0)], mesh.edges, mesh.triangles)
    if crossing is not None:
        edge, triangle = crossing
        f, g = mesh.faces[[mesh.edge_triangles[edge, 0], triangle]]
        raise InputError(
            "pattern.initial",
            f"a state in which faces {f} and {g} cross",
            "faces that do not pass through each other, for contact keeps every layer on its side",
        )
    contact = Contact(
        mesh,
        coordinates,
        settings,
        q0,
        face_orders=pattern.face_orders,
        pattern_faces=pattern.pattern_faces,
        device=device,
        # in motion the paper's methods show what they let through; an equilibrium on the other side is an error
        guarded=scene.analysis.kind != "dynamic",
    )
    if len(contact.coincident_layers):
        f, g = contact.coincident_layers[0]
        raise InputError(
            "pattern.initial",
            f"stowed layers that coincide, such as faces {f} and {g}",
            "layers slightly apart, or faceOrders that say which lies above",
        )
    return contact


def make_friction(scene: Scene, mesh: Mesh, coordinates: Coordinates) -> FrictionLaw | None:
    """Friction between layers that touch; None for a scene without."""
    settings = scene.contact
    if settings is None or settings.friction == 0.0:
        return None
    return FrictionLaw(mesh, coordinates, settings.friction, settings.friction_speed)
