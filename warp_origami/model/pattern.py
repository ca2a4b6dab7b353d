"""A crease pattern ready to be simulated: the flat mesh and its stowed state."""

from dataclasses import dataclass

import numpy as np

from .mesh import Mesh
from .rings import Rings


@dataclass(frozen=True)
class Pattern:
    """What a generator or a FOLD file gives.

    Attributes:
        mesh: the flat sheet.
        stowed: (nv, 3) folded positions of the mesh's vertices, m; None where the pattern has no stowed state.
        pattern_faces: (ne,) face of the pattern as given (FOLD `faces_vertices`) that each element lies in.
        face_orders: (k, 3) int rows (f, g, s) of FOLD `faceOrders`: face f lies on the side s (+1, -1) of face g's
            normal, where g is counter-clockwise.
        rings: places of the vertices on concentric circles, which refinement keeps to; None where it divides straight
            edges and plane triangles evenly.
    """

    mesh: Mesh
    stowed: np.ndarray | None
    pattern_faces: np.ndarray
    face_orders: np.ndarray
    rings: Rings | None = None
