"""Draws frames of an animation as one PNG, hidden surfaces removed: a way to look at a run without a USD viewer.

    python docs/render.py runs/leaf_in/animation.usdc docs/leaf_in.png 0 1.4 1.9 2.2 2.6 4.0

The two sides of the sheet are yellow and blue, creases are dark..
"""

import sys
from itertools import pairwise

import matplotlib.image
import numpy as np
from pxr import Usd, UsdGeom

WIDTH, HEIGHT = 420, 300
COLUMNS = 3
SIDES = np.array([[0.30, 0.55, 0.90], [0.96, 0.76, 0.30]])
LIGHT = np.array([0.25, -0.35, 0.9]) / np.linalg.norm([0.25, -0.35, 0.9])


def camera(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Orthographic view from above and the side that holds all `points` (n, 3): axes as rows, centre, scale."""
    azimuth, elevation = np.radians(-62.0), np.radians(32.0)
    back = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    axes = np.array([right, np.cross(back, right), back])
    seen = points @ axes.T
    centre = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    return axes, centre, 0.94 * (np.array([WIDTH, HEIGHT]) / np.ptp(seen[:, :2], axis=0)).min()


def draw(points, triangles, creases, view) -> np.ndarray:
    """(HEIGHT, WIDTH, 3) picture with a depth buffer."""
    axes, centre, scale = view
    seen = points @ axes.T
    pixels = np.column_stack([scale * (seen[:, :2] - centre[:2]) + 0.5 * np.array([WIDTH, HEIGHT]), seen[:, 2]])
    picture, depth = np.ones((HEIGHT, WIDTH, 3)), np.full((HEIGHT, WIDTH), -np.inf)
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-300
    for triangle, normal in zip(pixels[triangles], normals, strict=True):
        front = normal @ axes[2] > 0.0
        shade = 0.45 + 0.55 * abs(normal @ LIGHT)
        fill(picture, depth, triangle, shade * SIDES[int(front)])
    for line in creases:
        for a, b in pairwise(line):
            stroke(picture, depth, pixels[a], pixels[b])
    return picture[::-1]


def fill(picture, depth, triangle, colour) -> None:
    """One triangle of pixels with depth."""
    low = np.maximum(np.floor(triangle[:, :2].min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(triangle[:, :2].max(axis=0)).astype(int) + 1, [WIDTH, HEIGHT])
    x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangle
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if abs(area) < 1e-12 or x.size == 0:
        return
    u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
    v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
    z = u * az + v * bz + (1.0 - u - v) * cz
    rows, columns = slice(low[1], high[1]), slice(low[0], high[0])
    nearer = (u >= 0) & (v >= 0) & (u + v <= 1) & (z > depth[rows, columns])
    depth[rows, columns][nearer] = z[nearer]
    picture[rows, columns][nearer] = colour


def stroke(picture, depth, a, b) -> None:
    """A dark line where it is not hidden."""
    steps = np.linspace(0.0, 1.0, int(np.linalg.norm(b[:2] - a[:2])) + 2)[:, None]
    line = a + steps * (b - a)
    columns, rows = line[:, :2].astype(int).T
    inside = (columns >= 0) & (columns < WIDTH) & (rows >= 0) & (rows < HEIGHT)
    rows, columns, z = rows[inside], columns[inside], line[inside, 2]
    visible = z > depth[rows, columns] - 4e-3
    picture[rows[visible], columns[visible]] *= 0.45


def main() -> None:
    """Reads the animation and writes the picture."""
    source, target, *times = sys.argv[1:]
    stage = Usd.Stage.Open(source)
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.GetName() == "sheet")
    lines = [UsdGeom.BasisCurves(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves)]
    triangles = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    samples = mesh.GetPointsAttr().GetTimeSamples()
    everything = np.concatenate([np.array(mesh.GetPointsAttr().Get(code)) for code in samples])
    view = camera(everything)
    pictures = []
    for time in times:
        code = min(samples, key=lambda s: abs(s - float(time) * stage.GetTimeCodesPerSecond()))
        points = np.array(mesh.GetPointsAttr().Get(code), dtype=float)
        creases = []
        for curves in lines:
            curve_points = np.array(curves.GetPointsAttr().Get(code), dtype=float)
            counts = np.array(curves.GetCurveVertexCountsAttr().Get())
            creases += np.split(np.arange(len(curve_points)) + len(points), np.cumsum(counts)[:-1])
            points = np.concatenate([points, curve_points])
        pictures.append(draw(points, triangles, creases, view))
    pictures += [np.ones((HEIGHT, WIDTH, 3))] * (-len(pictures) % COLUMNS)
    rows = [np.concatenate(pictures[k : k + COLUMNS], axis=1) for k in range(0, len(pictures), COLUMNS)]
    matplotlib.image.imsave(target, np.clip(np.concatenate(rows), 0.0, 1.0))


if __name__ == "__main__":
    main()
