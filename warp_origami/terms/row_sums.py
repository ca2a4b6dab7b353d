"""Sums of what elements (or edges) give to the rows of q they have, in a fixed order."""

import numpy as np
import warp as wp

from warp_origami.kernels.gather import gather_vectors
from warp_origami.kernels.precision import vec3

from .buffers import Buffer
from .launches import Launch

KERNEL_MODULE = gather_vectors.module.name


class RowSums:
    """(count, 3) sums over all places where a row of q occurs; equal parts give bitwise equal sums.

    Args:
        rows: (k, m) rows of q of each element.
        count: n, rows of q.
        parts: (k, m) Warp array of vec3, what each element gives to each of its rows.
        device: of Warp.
        grain: rows of q that are worth a thread.
    """

    def __init__(self, rows: np.ndarray, count: int, parts: wp.array, device: str, grain: int) -> None:
        flat = rows.ravel()
        index = np.argsort(flat, kind="stable")
        indptr = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=count))])
        places = [wp.array(part, dtype=wp.int32, device=device) for part in (indptr, index)]
        self._sums = Buffer(count, vec3, device)
        self._launch = Launch(gather_vectors, count, [*places, parts.flatten()], [self._sums.array], device, grain)

    def __call__(self) -> np.ndarray:
        """(count, 3) sums of the parts as they are now."""
        self._launch.launch()
        return self._sums.read().copy()
