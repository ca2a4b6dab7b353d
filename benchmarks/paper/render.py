"""Pictures of the sheet with hidden surfaces removed, coloured by a field: parallel projection with a depth buffer."""

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps

from warp_origami.model.submesh import Submesh

OVERSAMPLING = 2
COLOUR_MAP = colormaps["turbo"].resampled(20)
LIGHT = np.array([0.25, -0.35, 0.9]) / np.linalg.norm([0.25, -0.35, 0.9])
BIAS = 2e-3
"""m: lines this far behind a surface are still drawn on it."""


@dataclass(frozen=True)
class View:
    """A window in a parallel projection.

    Attributes:
        azimuth, elevation: of the eye, degrees.
        centre: (3,) point in the middle of the picture, m.
        width: of the picture, m.
        pixels: columns and rows.
    """

    azimuth: float
    elevation: float
    centre: np.ndarray
    width: float
    pixels: tuple[int, int]

    def project(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) columns and rows from the lower left, and depth towards the eye in m, of points (n, 3)."""
        a, e = np.radians([self.azimuth, self.elevation])
        back = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        seen = (points - self.centre) @ np.array([right, np.cross(back, right), back]).T
        size = OVERSAMPLING * np.array(self.pixels)
        seen[:, :2] = seen[:, :2] * size[0] / self.width + 0.5 * size
        return seen


def picture(
    submesh: Submesh, points: np.ndarray, values: np.ndarray, span: tuple[float, float], view: View, crossed=()
) -> np.ndarray:
    """(rows, columns, 3) picture of the sub-mesh.

    Args:
        submesh, points: (np, 3) positions of its points, m.
        values: (np,) field on its points; colours run over `span` from blue to red.
        view: where from.
        crossed: sub-triangles to be drawn in magenta.
    """
    columns, rows = OVERSAMPLING * np.array(view.pixels)
    image, depth = np.ones((rows, columns, 3)), np.full((rows, columns), -np.inf)
    seen = view.project(points)
    shares = np.clip((values - span[0]) / (span[1] - span[0]), 0.0, 1.0)
    corners = points[submesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    shades = 0.6 + 0.4 * np.abs(normals @ LIGHT)
    marked = np.isin(np.arange(len(corners)), crossed)
    for triangle, shade, mark in zip(submesh.triangles, shades, marked, strict=True):
        _fill(image, depth, seen[triangle], shares[triangle], shade, mark)
    for a, b in submesh.triangles[:, [[0, 1], [1, 2], [2, 0]]][submesh.outer_edges]:
        _stroke(image, depth, seen[a], seen[b])
    fine = image.reshape(view.pixels[1], OVERSAMPLING, view.pixels[0], OVERSAMPLING, 3)
    return fine.mean(axis=(1, 3))[::-1]


def _fill(image, depth, triangle, shares, shade, mark) -> None:
    low = np.maximum(np.floor(triangle[:, :2].min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(triangle[:, :2].max(axis=0)).astype(int) + 1, [image.shape[1], image.shape[0]])
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangle
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if abs(area) < 1e-12 or np.any(high <= low):
        return
    x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
    u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
    v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
    w = 1.0 - u - v
    z = u * az + v * bz + w * cz
    window = slice(low[1], high[1]), slice(low[0], high[0])
    nearer = (u >= 0) & (v >= 0) & (w >= 0) & (z > depth[window])
    depth[window][nearer] = z[nearer]
    share = u * shares[0] + v * shares[1] + w * shares[2]
    colours = np.array([0.85, 0.0, 0.75]) if mark else COLOUR_MAP(share[nearer])[:, :3]
    image[window][nearer] = shade * colours


def _stroke(image, depth, a, b) -> None:
    steps = np.linspace(0.0, 1.0, 2 * int(np.linalg.norm(b[:2] - a[:2])) + 2)[:, None]
    line = a + steps * (b - a)
    columns, rows = np.floor(line[:, :2]).astype(int).T
    inside = (columns >= 0) & (columns < image.shape[1]) & (rows >= 0) & (rows < image.shape[0])
    columns, rows, z = columns[inside], rows[inside], line[inside, 2]
    visible = z > depth[rows, columns] - BIAS
    image[rows[visible], columns[visible]] = 0.1
