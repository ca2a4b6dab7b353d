"""Projection of points on the cubic surface, paper (28), (29), from the element's middle: the reference for contact."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_origami.kernels import projection
from warp_origami.kernels.precision import vec2, vec3
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

ITERATIONS = 60


@dataclass(frozen=True)
class Projection:
    """Closest points: area coordinates (n, 3) in the given elements, positions (n, 3) and distances (n,), m."""

    areas: np.ndarray
    positions: np.ndarray
    distances: np.ndarray


def project(
    mesh: Mesh, coordinates: Coordinates, q: np.ndarray, points: np.ndarray, elements: np.ndarray
) -> Projection:
    """Closest point of element elements[i] for points[i] (n, 3), m, found from the element's middle; on the CPU.

    Where an element is bent so far that the distance has several minima, the one found need not be the least.
    """
    count = len(points)
    given = projection.Elements()
    given.vertices = wp.array(mesh.vertices, dtype=vec2, device="cpu")
    given.triangles = wp.array(mesh.triangles, dtype=wp.int32, device="cpu")
    given.rows = wp.array(coordinates.elements, dtype=wp.int32, device="cpu")
    given.q = wp.array(q, dtype=vec3, device="cpu")
    areas, positions = np.zeros((count, 3)), np.zeros((count, 3))
    wp.launch(
        projection.project_points,
        dim=count,
        inputs=[
            wp.array(points, dtype=vec3, device="cpu"),
            wp.array(np.asarray(elements, dtype=np.int32), device="cpu"),
            wp.array(np.full((count, 3), 1.0 / 3.0), dtype=vec3, device="cpu"),
            given,
            ITERATIONS,
        ],
        outputs=[
            wp.array(areas, dtype=vec3, device="cpu", copy=False),
            wp.array(positions, dtype=vec3, device="cpu", copy=False),
        ],
        device="cpu",
    )
    return Projection(areas, positions, np.linalg.norm(points - positions, axis=1))
