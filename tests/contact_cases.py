"""Two sheets and what is asked of their contact."""

from types import SimpleNamespace

import numpy as np

from contact_meshes import joined, mesh_of
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.terms.contact import Contact

EPS_S, EPS_N, THICKNESS = 1e8, 3e6, 1e-3


def settings(method="sts", thickness=THICKNESS, exact=False):
    """Contact settings of the tests."""
    return SimpleNamespace(method=method, sts_stiffness=EPS_S, nts_stiffness=EPS_N, thickness=thickness, exact=exact)


class TwoSheets:
    """A lower and an upper sheet, drawn apart in the flat plane, the upper one laid over the lower at a height."""

    def __init__(self, lower, upper, *is_crease):
        (v1, t1), (v2, t2) = lower, upper
        self.shift = np.ptp(v1[:, 0]) + np.ptp(v2[:, 0]) + 1.0
        self.mesh = mesh_of(*joined((v1, t1), (v2 + np.array([self.shift, 0.0]), t2)), *is_crease)
        self.coordinates = number_coordinates(self.mesh)
        self.above = np.arange(len(self.mesh.vertices)) >= len(v1)

    def at(self, height, dx=0.0, dy=0.0):
        """q of two plane sheets at a distance of `height`, m."""
        points = np.pad(self.mesh.vertices, ((0, 0), (0, 1)))
        points[self.above] += [dx - self.shift, dy, height]
        return affine_coordinates(self.mesh, self.coordinates, points)

    def contact(self, method="sts", start=0.01, **options):
        """Contact whose start has the sheets `start` apart, m."""
        return Contact(self.mesh, self.coordinates, settings(method), self.at(start), **options)

    def force(self, contact, q):
        """Contact force on the upper sheet, N."""
        return -contact.gradient(q)[1][self.coordinates.positions[self.above]].sum(axis=0)


def wavy(coordinates, q, seed, position=2e-4, slope=5e-3):
    """q with random waves: `position` (m) on vertices, `slope` on gradients."""
    rng = np.random.default_rng(seed)
    size = np.full(coordinates.count, slope)
    size[coordinates.positions[coordinates.positions >= 0]] = position
    return q + size[:, None] * rng.normal(size=q.shape)
