"""A sparse pattern with room for what touches now and has touched a while ago.

Contact adds entries that come and go from one iteration to the next. Entries stay in the pattern for a while after
their last use, so that hardly any iteration needs a new analysis. When one does, those not used for long are dropped.
"""

import numpy as np
import warp as wp
from scipy.sparse import coo_matrix, csr_matrix, tril

from warp_origami.kernels.precision import real
from warp_origami.kernels.weighted_rows import add_weighted_rows

from .symmetric import SymmetricMatrix, SymmetricPattern

MEMORY = 30
"""Matrices with contact for which an entry is kept after its last use."""

KERNEL_MODULE = add_weighted_rows.module.name
"""The Warp module that is compiled where something touches."""


class PaddedPattern:
    """A fixed pattern with the entries that weighted rows add.

    Args:
        base: entries that are always there.

    Attributes:
        growths: how often the pattern was made anew.
    """

    def __init__(self, base: SymmetricPattern) -> None:
        self._base, self.growths, self._stamp = base, 0, 0
        self._missing = np.zeros(1, dtype=np.int32)
        self._take(base, np.zeros(len(base.indices), dtype=np.int32))

    def add(self, values: np.ndarray, rows: csr_matrix, weights: np.ndarray) -> SymmetricMatrix:
        """The matrix with `values` in the base pattern plus rows^T diag(weights) rows.

        Its values are overwritten by the next call.

        Args:
            rows: (k, m) with increasing columns in each row.
            weights: (k,).
        """
        self._stamp += 1
        if not self._added(values, rows, weights):
            self._grow(rows)
            self._added(values, rows, weights)
        return SymmetricMatrix(self.pattern, self._values)

    def _added(self, values: np.ndarray, rows: csr_matrix, weights: np.ndarray) -> bool:
        """Whether the pattern has room for all."""
        self._values.fill(0.0)
        self._values[self._places] = values
        self._missing[0] = 0
        self._launch = self._launch or self._record()
        arrays = (rows.indptr, rows.indices, rows.data, weights)
        for number, (array, dtype) in enumerate(zip(arrays, (wp.int32, wp.int32, real, real), strict=True)):
            self._launch.set_param_at_index(number, wp.array(array, dtype=dtype, device="cpu", copy=False))
        self._launch.set_param_at_index(6, self._stamp)
        self._launch.launch()
        return self._missing[0] == 0

    def state(self) -> dict[str, np.ndarray]:
        """What it remembers, for a checkpoint; after `restore` all results continue bitwise."""
        padding = np.ones(len(self.pattern.indices), dtype=bool)
        padding[self._places] = False
        rows, columns = self.pattern.indices[padding], self.pattern.columns[padding]
        return {"row": rows, "column": columns, "used": self._used[padding], "stamp": np.array(self._stamp)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Takes what it remembers from `state`."""
        self._stamp = int(state["stamp"])
        self._pad(state["row"], state["column"], state["used"])

    def _grow(self, rows: csr_matrix) -> None:
        """Makes room for rows, and forgets what was not used for long."""
        self.growths += 1
        kept = np.flatnonzero(self._used > self._stamp - MEMORY)
        ones = csr_matrix((np.ones(rows.nnz), rows.indices, rows.indptr), shape=rows.shape)
        new = tril(ones.T @ ones, format="coo")
        row, column = self.pattern.indices[kept], self.pattern.columns[kept]
        never = np.zeros(new.nnz, dtype=np.int32)
        self._pad(
            np.concatenate([row, new.row]),
            np.concatenate([column, new.col]),
            np.concatenate([self._used[kept], never]),
        )

    def _pad(self, row: np.ndarray, column: np.ndarray, used: np.ndarray) -> None:
        """The base pattern and further entries with their last uses."""
        size = self._base.size
        rows, columns = np.concatenate([self._base.indices, row]), np.concatenate([self._base.columns, column])
        union = coo_matrix((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(size, size)).tocsc()
        union.sort_indices()
        pattern = SymmetricPattern(union.indptr, union.indices)
        stamps = np.zeros(len(pattern.indices), dtype=np.int32)
        np.maximum.at(stamps, pattern.places_of(row, column), used)
        self._take(pattern, stamps)

    def _take(self, pattern: SymmetricPattern, stamps: np.ndarray) -> None:
        self.pattern, self._used = pattern, stamps
        self._places = pattern.places_of(self._base.indices, self._base.columns)
        self._values = np.zeros(len(pattern.indices))
        self._launch: wp.Launch | None = None  # without contact nothing is compiled

    def _record(self) -> wp.Launch:
        """The launch that adds rows, whose arrays are still to be given."""
        nothing = [wp.zeros(0, dtype=dtype, device="cpu") for dtype in (wp.int32, wp.int32, real, real)]
        given = [(self.pattern.indptr, wp.int32), (self.pattern.indices, wp.int32)]
        changed = [(self._values, real), (self._used, wp.int32), (self._missing, wp.int32)]
        structure, outputs = (
            [wp.array(array, dtype=dtype, device="cpu", copy=False) for array, dtype in pairs]
            for pairs in (given, changed)
        )
        inputs = [*nothing, *structure, 0]
        return wp.launch(add_weighted_rows, dim=1, inputs=inputs, outputs=outputs, device="cpu", record_cmd=True)
