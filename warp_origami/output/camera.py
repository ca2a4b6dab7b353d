"""Where the camera stands so that it sees the whole motion.

With x to the right, y up and z back in the camera's directions, a point is in the picture of a camera at p if

    |x - p_x| / t_x <= p_z - z   and   |y - p_y| / t_y <= p_z - z,

t the tangents of half the field of view. Along x and along y this needs the largest values of x / t + z and of
-x / t + z over all points: their mean is the least p_z, their difference gives p_x. No point has to be kept.
"""

import numpy as np


class View:
    """The nearest camera with a fixed direction that sees all points it was shown.

    Attributes:
        field_of_view: vertical, degrees.
        aspect: width over height of the picture.
    """

    direction = (0.8, -1.6, 1.2)  # from the sheet to the camera: in front, above, a little to the right
    field_of_view = 40.0
    aspect = 16.0 / 9.0
    margin = 1.1  # of the picture around what is in it

    def __init__(self):
        back = np.array(self.direction) / np.linalg.norm(self.direction)
        right = np.cross([0.0, 0.0, 1.0], back)
        right /= np.linalg.norm(right)
        self._axes = np.stack([right, np.cross(back, right), back])
        self._tangents = np.tan(np.radians(self.field_of_view / 2)) * np.array([self.aspect, 1.0]) / self.margin
        self._reach = np.full((2, 2), -np.inf)  # largest (x, y) / t + z and -(x, y) / t + z
        self._depth = np.array([np.inf, -np.inf])  # least and largest z

    def include(self, points: np.ndarray) -> None:
        """Takes account of points (n, 3), m."""
        seen = points @ self._axes.T
        sideways, z = seen[:, :2] / self._tangents, seen[:, 2:]
        self._reach = np.maximum(self._reach, [(sideways + z).max(axis=0), (-sideways + z).max(axis=0)])
        self._depth = np.array([min(self._depth[0], z.min()), max(self._depth[1], z.max())])

    def _place(self) -> np.ndarray:
        """Position of the camera in its own directions, m."""
        size = max(float(np.ptp(self._depth)), float(self._reach.sum(axis=0).max()) - 2.0 * self._depth[1], 1e-6)
        back = max(float(self._reach.mean(axis=0).max()), self._depth[1] + 0.05 * size)
        return np.array([*(self._tangents * (self._reach[0] - self._reach[1]) / 2.0), back])

    def transform(self) -> np.ndarray:
        """(4, 4) camera to world for row vectors, translation in the last row."""
        matrix = np.eye(4)
        matrix[:3, :3] = self._axes
        matrix[3, :3] = self._place() @ self._axes
        return matrix

    def distances(self) -> tuple[float, float]:
        """Least and largest distance of a point from the camera along its direction, m."""
        place = self._place()[2]
        return float(place - self._depth[1]), float(place - self._depth[0])
