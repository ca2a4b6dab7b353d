"""Lowest eigenpairs of K x = lambda M x by shift-invert block Lanczos, complete with their multiplicities.

    A = (K - s M)^-1 M,   A x = theta x,   lambda = s + 1 / theta,   s below the lowest eigenvalue

in the inner product of M, with every vector orthogonalized against all others. A block finds as many vectors of an
eigenspace as it is wide. Whether any is missing is told by the number of negative pivots of K - b M, with b just below
the highest wanted eigenvalue (Sylvester); then the search goes on with fresh random blocks, twice as wide each time.
R. G. Grimes, J. G. Lewis and H. D. Simon, SIAM J. Matrix Anal. Appl. 15 (1994) 228.
"""

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_matrix

from .linear import Factor, negative_pivots

WIDTH, WIDEST = 6, 96
"""Vectors in a block: narrow ones need the fewest solves, wide ones find spaces of many dimensions."""

SPAN = 20
"""Narrow blocks in the basis, besides twice the wanted pairs, before it is compressed to the best approximations."""

TOLERANCE = 1e-8
"""Residual of A over theta at which a pair is found; the error of lambda is of its square."""

DEPENDENT = 1e-13
"""Share of a vector that must be new to the basis."""

STEPS = 1000
"""Blocks after which to give up."""

SEARCHES = 50
"""Fresh blocks after which to give up."""

BORDERS = (1e-6, 3e-6, 1e-5)
"""How far below the highest wanted eigenvalue, relative to it, eigenvalues are counted."""


class BlockLanczos:
    """A basis that grows until the lowest pairs lie in it.

    Args:
        mass: M, (n, n).
        factor: of K - shift M, positive definite.
        count: wanted pairs, fewer than n.
    """

    def __init__(self, mass: csc_matrix, factor: Factor, count: int):
        self.mass, self.factor, self.count = mass.tocsr(), factor, count
        self.size = mass.shape[0]
        self.width = WIDTH
        self.random = np.random.default_rng(0)
        self.capacity = min(2 * count + SPAN * WIDTH + 2 * WIDEST, self.size)
        self.basis = np.empty((self.capacity, self.size))
        self.projected = np.zeros((self.capacity, self.capacity))
        self.used = self.done = 0  # vectors in the basis, and those of them that A was applied to
        self._add_random()

    def run(self) -> np.ndarray | None:
        """(n, count) approximations; None if they did not settle."""
        for _ in range(STEPS):
            self._advance()
            found = self._converged()
            if found is not None:
                return found
            if self.used == self.done:
                self._add_random()
        return None

    def widen(self) -> None:
        """Goes on with a fresh block, twice as wide as the last."""
        self.width = min(2 * self.width, WIDEST)
        self._add_random()

    def _advance(self) -> None:
        """Applies A to the newest vectors; what is new in the results joins the basis."""
        if self.used + (self.used - self.done) > self.capacity < self.size:
            self._compress()
        first, last = self.done, self.used
        images = self.factor.solve(self.mass @ self.basis[first:last].T)
        coefficients = self._extend(np.ascontiguousarray(images.T))
        self.projected[: self.used, first:last] = coefficients
        self.done = last

    def _extend(self, vectors: np.ndarray) -> np.ndarray:
        """Adds what is new in the rows of `vectors` to the basis; returns their coefficients (used, k) there."""
        share, triangle, fresh = self._split(vectors, DEPENDENT)
        again, correction, fresh = self._split(fresh, 0.0)  # round-off of the first time is visible in short remainders
        count = min(len(fresh), self.capacity - self.used)
        self.basis[self.used : self.used + count] = fresh[:count]
        self.used += count
        return np.vstack([share + again @ triangle, (correction @ triangle)[:count]])

    def _split(self, vectors: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Vectors = share^T basis + triangle^T fresh, but for what is shorter than the share `least` of a vector."""
        old, images = self.basis[: self.used], (self.mass @ vectors.T).T
        shortest = least * np.sqrt(np.einsum("kn,kn->k", vectors, images))
        share = old @ images.T
        vectors = vectors - share.T @ old
        images = np.ascontiguousarray((self.mass @ vectors.T).T)
        fresh, fresh_images = np.empty_like(vectors), np.empty_like(images)
        triangle, rows = np.zeros((len(vectors), len(vectors))), 0
        for k, (vector, image) in enumerate(zip(vectors, images, strict=True)):
            for _ in range(2):
                part = fresh[:rows] @ image
                vector, image = vector - part @ fresh[:rows], image - part @ fresh_images[:rows]
                triangle[:rows, k] += part
            norm = np.sqrt(max(float(vector @ image), 0.0))
            if norm > shortest[k]:
                fresh[rows], fresh_images[rows], triangle[rows, k] = vector / norm, image / norm, norm
                rows += 1
        return share, triangle[:rows], fresh[:rows]

    def _add_random(self) -> None:
        if self.used + 2 * self.width > self.capacity < self.size:
            self._compress()
        self._extend(self.random.standard_normal((self.width, self.size)))

    def _ritz(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """The largest theta, falling, and their coefficients in the basis."""
        inner = self.projected[: self.done, : self.done]
        theta, vectors = eigh(0.5 * (inner + inner.T))
        return theta[::-1][:count], vectors[:, ::-1][:, :count]

    def _converged(self) -> np.ndarray | None:
        if self.done < self.count:
            return None
        theta, vectors = self._ritz(self.count)
        residuals = np.linalg.norm(self.projected[self.done : self.used, : self.done] @ vectors, axis=0)
        if np.any(residuals > TOLERANCE * theta):
            return None
        # A once more, which takes the high frequencies out and costs nothing
        images = self.projected[: self.used, : self.done] @ vectors
        return self.basis[: self.used].T @ (images / theta)

    def _compress(self) -> None:
        """Keeps the best approximations and the vectors that A was not applied to."""
        new = self.used - self.done
        kept = min(self.done, self.count + SPAN * WIDTH // 2)
        theta, vectors = self._ritz(kept)
        coupling = self.projected[self.done : self.used, : self.done] @ vectors
        fresh = self.basis[self.done : self.used].copy()
        self.basis[:kept] = vectors.T @ self.basis[: self.done]
        self.basis[kept : kept + new] = fresh
        self.projected[:] = 0.0
        self.projected[:kept, :kept] = np.diag(theta)
        self.projected[kept : kept + new, :kept] = coupling
        self.used, self.done = kept + new, kept


def lowest_pairs(
    stiffness: csc_matrix, mass: csc_matrix, factor: Factor, count: int, resolution: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """The lowest eigenvalues (count,), increasing, and vectors (n, count), orthonormal in M; None if not found.

    Args:
        stiffness: K, (n, n) symmetric.
        mass: M, (n, n) symmetric positive definite.
        factor: of K - shift M, which is positive definite.
        count: of pairs, fewer than n.
        resolution: size of eigenvalues that round-off hides, 1/s^2.
    """
    search = BlockLanczos(mass, factor, count)
    for _ in range(SEARCHES):
        found = search.run()
        if found is None:
            return None
        values, vectors = eigh(found.T @ (stiffness @ found), found.T @ (mass @ found))
        if _complete(stiffness, mass, values, resolution):
            return values, found @ vectors
        search.widen()
    return None


def _complete(stiffness: csc_matrix, mass: csc_matrix, values: np.ndarray, resolution: float) -> bool:
    """Whether all eigenvalues below the highest of `values` are among them."""
    for share in BORDERS:  # several, for a pivot may vanish by chance
        border = values[-1] - max(share * abs(values[-1]), share / BORDERS[0] * resolution)
        if negative_pivots((stiffness - border * mass).tocsc()) == np.sum(values < border):
            return True
    return False
