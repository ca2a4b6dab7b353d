"""Arrays that both NumPy and the device see."""

import numpy as np
import warp as wp


class Buffer:
    """A preallocated device array with cheap access from the host.

    On the CPU the host side is a view of the same memory, on CUDA a copy.

    Attributes:
        array: the Warp array, for launches.
    """

    def __init__(self, shape: int | tuple[int, ...], dtype, device: str):
        self.array = wp.zeros(shape, dtype=dtype, device=device)
        self._view = self.array.numpy() if self.array.device.is_cpu else None

    def write(self, values: np.ndarray) -> None:
        """Copies `values`, of the array's NumPy shape, to the device."""
        if self._view is None:
            self.array.assign(values)
        else:
            self._view[...] = values

    def write_first(self, values: np.ndarray) -> None:
        """Copies `values` to the first so many places on the device."""
        if self._view is not None:
            self._view[: len(values)] = values
        elif len(values):
            wp.copy(self.array, wp.array(values, dtype=self.array.dtype, device=self.array.device), count=len(values))

    def write_at(self, begin: int, values: np.ndarray) -> None:
        """Copies `values` to so many places from `begin` on, on the device."""
        if self._view is not None:
            self._view[begin : begin + len(values)] = values
        else:
            source = wp.array(values, dtype=self.array.dtype, device=self.array.device)
            wp.copy(self.array, source, dest_offset=begin, count=len(values))

    def read(self) -> np.ndarray:
        """The values; on the CPU a view that the next launch overwrites."""
        return self.array.numpy() if self._view is None else self._view
