"""How far points and layers have moved since the accepted state: what rules out most pairs of them.

    |d(x) - d(x_0)| <= |dx - c| + max |dy - c|      dx: of the point, dy: of the nodes of the layer, c: any shift

Sub-triangles are plane, so that no point of them moves farther than their nodes. c is the middle of the box around all
motions dy of the layer.
"""

import numpy as np

from warp_origami.kernels.point_gap import Motion
from warp_origami.kernels.precision import real, vec3
from warp_origami.model.submesh import Submesh

from ..buffers import Buffer

ROUND_OFF = 1e-12
"""Over the size of the sheet: by which spreads are enlarged."""


class LayerMotion:
    """Motion of n points and of the layers, whose nodes are the first of them, for launches.

    Args:
        submesh: its faces are the layers.
        node_count, slave_count: numbers of nodes and of slave points; positions hold nodes first.

    Attributes:
        motion: for launches.
    """

    def __init__(self, submesh: Submesh, node_count: int, slave_count: int, device: str) -> None:
        layers = int(submesh.triangle_faces.max()) + 1
        pairs = np.unique(np.repeat(submesh.triangle_faces, 3) * node_count + submesh.triangles.ravel())
        self._nodes = pairs % node_count
        self._present, self._starts = np.unique(pairs // node_count, return_index=True)
        self._sizes = np.diff(np.append(self._starts, len(pairs)))
        self._node_count = node_count
        self._slaves = Buffer(slave_count, vec3, device)
        self._shifts, self._spreads = Buffer(layers, vec3, device), Buffer(layers, real, device)
        self._error = Buffer(1, real, device)
        self._shift, self._spread = np.zeros((layers, 3)), np.full(layers, np.inf)
        self._positions: np.ndarray | None = None
        self.motion = Motion()
        self.motion.slaves, self.motion.shifts = self._slaves.array, self._shifts.array
        self.motion.spreads, self.motion.error = self._spreads.array, self._error.array

    def accept(self, positions: np.ndarray) -> None:
        """Takes positions (n, 3), m, as those of the accepted state."""
        self._positions = positions
        self._slaves.write(positions[self._node_count :])

    def follow(self, positions: np.ndarray, error: float) -> None:
        """Brings the motion to `positions` (n, 3), m; `error`: how far surfaces lie from sub-triangles at most, m."""
        moved = (positions[: self._node_count] - self._positions[: self._node_count])[self._nodes]
        low, high = (np.atleast_2d(bound.reduceat(moved, self._starts, axis=0)) for bound in (np.minimum, np.maximum))
        middle = 0.5 * (low + high)
        away = moved - np.repeat(middle, self._sizes, axis=0)
        farthest = np.maximum.reduceat(np.einsum("ij,ij->i", away, away), self._starts)
        self._shift[self._present] = middle
        self._spread[self._present] = np.sqrt(farthest) + ROUND_OFF * np.abs(positions).max()
        self._shifts.write(self._shift)
        self._spreads.write(self._spread)
        self._error.write(np.array([error]))

    def forget(self) -> None:
        """Nothing is known of the motion: every pair is looked at."""
        self._spreads.write(np.full_like(self._spread, np.inf))
        self._error.write(np.array([np.inf]))
