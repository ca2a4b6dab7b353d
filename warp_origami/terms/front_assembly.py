"""Sums of updates in the fronts of a multifrontal factorization, in compiled code between calls of LAPACK."""

import numpy as np
import warp as wp

from warp_origami.kernels.fronts import assemble_front
from warp_origami.kernels.precision import real

KERNEL_MODULE = assemble_front.module.name
"""The Warp module that is compiled for it."""


class FrontAssembly:
    """Storage of the updates of all fronts, and their sums.

    Args:
        sizes: (f, 2) pivots k and further rows m of each front.
        offsets: (f, 4) where L11 and L21 begin in the panels, U in the updates, and its rows in `places`.
        children: children of all fronts, one front after the other.
        child_starts: (f + 1,) first one of each.
        places: of each further row of each front, its place among all rows of the parent.
        pivots: (f,) how many of its further rows are pivots of the parent.
        length: of all updates.

    Attributes:
        updates: all U, column after column.
    """

    def __init__(
        self,
        sizes: np.ndarray,
        offsets: np.ndarray,
        children: np.ndarray,
        child_starts: np.ndarray,
        places: np.ndarray,
        pivots: np.ndarray,
        length: int,
    ) -> None:
        shapes = np.column_stack([sizes, child_starts[:-1], child_starts[1:], pivots]).astype(np.int32)
        self._updates = wp.zeros(length, dtype=real, device="cpu")
        self.updates = self._updates.numpy()
        self._tables = [
            wp.array(shapes, dtype=wp.int32, device="cpu"),
            wp.array(offsets, dtype=wp.int64, device="cpu"),
            wp.array(children, dtype=wp.int32, device="cpu"),
            wp.array(places, dtype=wp.int32, device="cpu"),
        ]

    def bind(self, panels: np.ndarray) -> wp.Launch:
        """A launch of the assembly of front `front` into panels; set that parameter first."""
        outputs = [wp.array(panels, dtype=real, device="cpu", copy=False), self._updates]
        inputs = [0, *self._tables]
        return wp.launch(assemble_front, dim=1, inputs=inputs, outputs=outputs, device="cpu", record_cmd=True)
