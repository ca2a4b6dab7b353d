"""Sheets and materials for the tests of the membrane element."""

from dataclasses import dataclass

import numpy as np

from warp_origami.model.coordinates import number_coordinates
from warp_origami.model.mesh import build_mesh


@dataclass(frozen=True)
class Film:
    """A material as the membrane wants it; polyimide of the paper's section 5."""

    youngs_modulus: float = 2.5e9
    poisson_ratio: float = 0.34
    thickness: float = 5e-4
    model: str = "srm"
    s1: float = 1e-4
    s2: float = 1e-4


def square_mesh(n, side=0.6, distortion=0.0, crease=None):
    """Square of n x n cells of two triangles, inner vertices moved by `distortion` cells, one grid column a crease."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    inner = (x > 0) & (x < n) & (y > 0) & (y < n)
    shift = distortion * np.random.default_rng(3).uniform(-1.0, 1.0, (2, *x.shape)) * inner
    vertices = side / n * np.stack([x + shift[0], y + shift[1]], axis=-1).reshape(-1, 2)
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = number[:-1, :-1].ravel(), number[:-1, 1:].ravel(), number[1:, 1:].ravel(), number[1:, :-1].ravel()
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    if crease is None:
        return build_mesh(vertices, triangles)
    column = number[:, crease]
    edges = np.stack([column[:-1], column[1:]], axis=1)
    return build_mesh(vertices, triangles, edges, np.full(len(edges), "M"))


def distorted_sheet(n=3, crease=None):
    """An irregular mesh and its coordinates."""
    mesh = square_mesh(n, distortion=0.25, crease=crease)
    return mesh, number_coordinates(mesh)


def field_coordinates(mesh, coordinates, field):
    """q that interpolates `field(x, y) -> r, r_x, r_y` (each (n, 3)) at the vertices."""
    q = np.zeros((coordinates.count, 3))
    r, _, _ = field(*mesh.vertices.T)
    used = coordinates.positions >= 0
    q[coordinates.positions[used]] = r[used]
    _, r_x, r_y = field(*mesh.vertices[coordinates.sector_vertices].T)
    q[coordinates.sector_gradients], q[coordinates.sector_gradients + 1] = r_x, r_y
    return q


def linear_field(gradient, shift=(0.0, 0.0, 0.0)):
    """Field r = gradient (3, 2) times (x, y) + shift."""
    gradient = np.asarray(gradient, dtype=float)

    def field(x, y):
        r = np.stack([x, y], axis=1) @ gradient.T + np.asarray(shift)
        return r, np.tile(gradient[:, 0], (len(x), 1)), np.tile(gradient[:, 1], (len(x), 1))

    return field


def rotation(axis, angle):
    """Rotation matrix (Rodrigues)."""
    k = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
