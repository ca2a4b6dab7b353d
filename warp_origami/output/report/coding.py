"""Arrays as text in a page: coded so that they compress well, compressed, base64.

Arrays that change little from one row to the next are stored as differences of the rows (integers, modulo their
range), and all as planes of bytes: first the lowest byte of every number, then the second. zlib makes of the planes
that hardly change next to nothing. The page undoes the three steps with the browser's own DecompressionStream.
"""

import base64
import zlib

import numpy as np


class Blob:
    """Named arrays that are kept together.

    Attributes:
        index: what the page needs to take them apart: name, kind of number, shape, whether rows are differences.
    """

    def __init__(self):
        self.index: list[dict] = []
        self._parts: list[bytes] = []

    def add(self, name: str, values: np.ndarray, differences: bool = False) -> None:
        """Adds an array; `differences` (integers only) where rows resemble the row before them."""
        values = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
        kind = f"{values.dtype.kind}{values.dtype.itemsize}"
        self.index.append({"name": name, "kind": kind, "shape": values.shape, "differences": differences})
        if differences and len(values):
            values = np.concatenate([values[:1], values[1:] - values[:-1]])  # wraps around, as the sums will
        planes = values.reshape(-1).view(np.uint8).reshape(-1, values.dtype.itemsize).T
        self._parts.append(zlib.compress(np.ascontiguousarray(planes).tobytes(), 6))

    @property
    def size(self) -> int:
        """Bytes of the compressed arrays."""
        return sum(map(len, self._parts))

    def text(self) -> list[str]:
        """One text of base64 for each array."""
        return [base64.b64encode(part).decode("ascii") for part in self._parts]
