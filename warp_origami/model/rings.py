"""Points on concentric circles whose radial distances are graded, and what refinement puts between them.

A point has a level s, from 0 on the inner rim (or at the pole) to 1 on the outer one, and an angle. Its radius is

    r(s) = a + (b - a) (e^(c s) - 1) / (e^c - 1),   c = m/(m - 1) ln(grading),

so that the widths of m rings of equal steps of s are a geometric sequence, the last one `grading` times the first.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix, diags


@dataclass(frozen=True)
class Rings:
    """Polar coordinates of the vertices of a mesh.

    Attributes:
        centre: of all circles, m.
        inner_radius, outer_radius: a and b, m; an inner radius of 0 is a pole.
        growth: c.
        levels: (nv,) s.
        angles: (nv,) rad; of no meaning at a pole.
    """

    centre: tuple[float, float]
    inner_radius: float
    outer_radius: float
    growth: float
    levels: np.ndarray
    angles: np.ndarray

    @property
    def radii(self) -> np.ndarray:
        """(nv,) m."""
        share = self.levels if self.growth == 0.0 else np.expm1(self.growth * self.levels) / np.expm1(self.growth)
        return self.inner_radius * (1.0 - share) + self.outer_radius * share

    @property
    def vertices(self) -> np.ndarray:
        """(nv, 2) flat coordinates, m."""
        directions = np.stack([np.cos(self.angles), np.sin(self.angles)], axis=1)
        return np.asarray(self.centre) + self.radii[:, None] * directions

    def interpolated(self, weights: csr_matrix) -> "Rings":
        """Vertices added on circles: levels are interpolated linearly, angles so with weights times radii.

        Weights times radii divide arcs evenly, hardly change the angles between straight lines, and leave a pole out,
        which lies in all directions.

        Args:
            weights: (more than nv, nv) of each refined vertex, whose first nv rows are the given vertices.
        """
        added = weights[len(self.levels) :].tocsr()
        arms = (added @ diags(self.radii)).tocsr()
        middle = np.arctan2(arms @ np.sin(self.angles), arms @ np.cos(self.angles))
        row = np.repeat(np.arange(len(middle)), np.diff(arms.indptr))
        turn = np.remainder(self.angles[arms.indices] - middle[row] + np.pi, 2.0 * np.pi) - np.pi
        turns, sums = (np.bincount(row, values, len(middle)) for values in (arms.data * turn, arms.data))
        return replace(
            self,
            levels=np.concatenate([self.levels, added @ self.levels]),
            angles=np.concatenate([self.angles, middle + turns / sums]),
        )
