"""What factorizing one tangent costs with dense, banded, SuperLU, multifrontal and PARDISO solvers.

    python benchmarks/linear_solvers.py [--cells 5 10 22 50 105] [--until 0.75] [--out results/linear_solvers.csv]

Matrices: T^T (c M + K) T of a square sheet held along its rim, and those of the scene leaf_in, the last definite ones
without contact and with it (up to `--until` seconds of motion). CPU seconds of one thread, medians. `first` is with
the analysis of the pattern. Dense and banded ones are left out from 6000 unknowns on.

Writes results/linear_solvers.csv and prints the table.
"""

import argparse
import csv
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scaling import scene
from scipy.linalg import lapack
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

import warp_origami as wo
from warp_origami.clock import PhaseClock
from warp_origami.solve.linear import pardiso
from warp_origami.solve.linear.pardiso import Pardiso
from warp_origami.solve.linear.sparse_cholesky import SparseCholesky, along_fronts, in_band
from warp_origami.solve.reduced_tangent import ReducedTangent
from warp_origami.system import System
from warp_origami.terms.symmetric import SymmetricMatrix, SymmetricPattern

RESULTS = Path(__file__).parent / "results"
LARGEST_DENSE = 6000
INERTIA = 1e6
"""c, 1/s^2: steps of about a millisecond."""


class Dense:
    """LAPACK's potrf."""

    def factorize(self, matrix: SymmetricMatrix):
        size = matrix.pattern.size
        dense = np.zeros((size, size), order="F")
        dense.ravel(order="K")[matrix.pattern.columns.astype(np.int64) * size + matrix.pattern.indices] = matrix.values
        self.factor, info = lapack.dpotrf(dense, lower=1, clean=0, overwrite_a=1)
        return self if info == 0 else None

    def solve(self, right: np.ndarray) -> np.ndarray:
        return lapack.dpotrs(self.factor, right, lower=1)[0]


class SymmetricSuperLU:
    """SuperLU without pivoting, minimum degree; it has no memory of an analysis."""

    def factorize(self, matrix: SymmetricMatrix):
        return splu(matrix.full(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


SOLVERS: dict[str, Callable] = {
    "dense": Dense,
    "banded": lambda: SparseCholesky(in_band),
    "SuperLU": SymmetricSuperLU,
    "multifrontal": lambda: SparseCholesky(along_fronts),
    "PARDISO": lambda: Pardiso("definite"),
}


def sheet(cells: int) -> SymmetricMatrix:
    """Tangent of a flat sheet."""
    system = System(scene(cells, "dynamic", "linear", "scipy"), "cpu", PhaseClock())
    tangent = ReducedTangent(system, system.constraints.null_space, system.mass)
    return tangent.symmetric(system.linearize(system.q0), INERTIA, 0.0)


def leaf_in(until: float) -> dict[str, SymmetricMatrix]:
    """The last definite tangents of the leaf-in without contact and with it, without padding."""
    kept: dict[str, SymmetricMatrix] = {}
    symmetric = ReducedTangent.symmetric

    def keep(self, linearization, *arguments):
        matrix = symmetric(self, linearization, *arguments)
        name = "leaf_in, contact" if matrix.pattern is not self.sparsity.pattern else "leaf_in"
        lower = np.flatnonzero(matrix.values != 0.0)  # what is in the padding and not in use is left out
        indptr = np.searchsorted(lower, matrix.pattern.indptr).astype(np.int32)
        pattern = SymmetricPattern(indptr, matrix.pattern.indices[lower])
        found = SymmetricMatrix(pattern, matrix.values[lower].copy())
        if Dense().factorize(found) is not None:
            kept[name] = found
        return matrix

    ReducedTangent.symmetric = keep
    wo.simulate(wo.load_scene("leaf_in"), until=until, threads=1)
    ReducedTangent.symmetric = symmetric
    return kept


def median(call: Callable, repeats: int) -> float:
    """CPU milliseconds."""
    seconds = []
    for _ in range(repeats):
        begin = time.process_time()
        call()
        seconds.append(time.process_time() - begin)
    return 1e3 * float(np.median(seconds))


def measure(name: str, matrix: SymmetricMatrix) -> list[dict]:
    """A row for each solver."""
    size, rows = matrix.pattern.size, []
    repeats = 200 if size < 1000 else 9 if size < 10_000 else 3
    right = np.random.default_rng(0).normal(size=size)
    for solver_name, make in SOLVERS.items():
        if (solver_name in ("dense", "banded") and size > LARGEST_DENSE) or (
            solver_name == "PARDISO" and not pardiso.is_installed()
        ):
            continue
        make().factorize(matrix)  # loads libraries
        first = median(lambda make=make: make().factorize(matrix), 2)
        solver = make()
        solver.factorize(matrix)
        factorization = median(lambda solver=solver: solver.factorize(matrix), repeats)
        factor = solver.factorize(matrix)
        solution = median(lambda factor=factor: factor.solve(right), repeats)
        rows.append(
            {
                "matrix": name,
                "unknowns": size,
                "entries": 2 * len(matrix.values) - size,
                "solver": solver_name,
                "first_ms": f"{first:.3g}",
                "factorization_ms": f"{factorization:.3g}",
                "solution_ms": f"{solution:.3g}",
            }
        )
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="+", default=(5, 10, 22, 50, 105))
    parser.add_argument("--until", type=float, default=0.75)
    parser.add_argument("--out", type=Path, default=RESULTS / "linear_solvers.csv")
    options = parser.parse_args()
    with threadpool_limits(1):
        matrices = leaf_in(options.until)
        rows = [row for name, matrix in matrices.items() for row in measure(name, matrix)]
        for cells in options.cells:
            rows += measure(f"sheet, {2 * cells**2} elements", sheet(cells))
    with options.out.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
