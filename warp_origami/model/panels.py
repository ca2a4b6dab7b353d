"""A folded sheet as panels that are hardly strained, hardly bent and do not pass at their creases.

See folding_path for what is minimized. Newton's method (Gauss-Newton, damped) on

    stretch of edges and braces, bending at smooth edges, fold angles beyond pi = 0

with one constraint, which a Lagrange multiplier holds.
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_matrix, diags, identity, vstack
from scipy.sparse.linalg import lsqr, splu

from .fold_angles import fold_angles
from .mesh import CREASE, SMOOTH, Mesh

ITERATIONS = 60
"""Of Newton's method, for each state."""

GAIN = 1e-4
"""Of the sum of squares: twice less, and it is as small as it gets."""

SOFT = 1e-2
"""Weight of bending where panels may bend, 1/rad."""

LEAST_DAMPING = 1e-11
"""Of Newton's method, over the size squared: rigid motions and mechanisms have no stiffness of their own."""

TURN = 2.0 * np.pi

SHUT = 1e-6
"""Fold angles (rad) so close to pi are folded flat."""

AJAR = 0.1
"""By how much flat-folded creases are opened first, rad, on average."""

STIFF = 30.0
"""Weight of strain and bending against the opening of creases, to first order."""

Constraint = Callable[[np.ndarray], tuple[float, np.ndarray]]
"""Points (nv, 3) -> what they miss (a number without unit), and by how much a motion reduces that (3 nv,), 1/m."""


def spread(points: np.ndarray) -> float:
    """Mean square distance of points (n, 3) from their centre, m^2."""
    return float(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1)))


class Panels:
    """Edges and braces of the panels, and the states that strain them least.

    Args:
        flat, stowed: (nv, 3) m.
        plane: whether panels are to stay plane.
    """

    def __init__(self, mesh: Mesh, flat: np.ndarray, stowed: np.ndarray, plane: bool):
        self.mesh, self.size, self.bending = mesh, mesh.size, 1.0 if plane else SOFT
        self.smooth = np.flatnonzero(mesh.edge_kinds == SMOOTH)
        self.creases = np.flatnonzero(mesh.edge_kinds == CREASE)
        self.ends = mesh.edges.astype(int)
        if plane:
            both = mesh.triangles[mesh.edge_triangles[self.smooth]].astype(int)
            apexes = both.sum(axis=2) - mesh.edges[self.smooth].sum(axis=1)[:, None]
            self.ends = np.concatenate([self.ends, apexes])
        self.square = np.sum((flat[self.ends[:, 1]] - flat[self.ends[:, 0]]) ** 2, axis=1)
        angles = fold_angles(mesh, stowed)[self.creases]
        shut = np.abs(angles) > np.pi - SHUT
        self.shut = self.creases[shut]
        self.sense = np.where(mesh.edge_assignments[self.creases] == "M", -1.0, 1.0)
        self.angles = np.where(shut, np.pi * self.sense, angles)
        self.sense = self.sense[shut]

    def strains(self, points: np.ndarray) -> np.ndarray:
        """(k,) (l - L) / L."""
        i, j = self.ends.T
        return np.linalg.norm(points[j] - points[i], axis=1) / np.sqrt(self.square) - 1.0

    def widened(self, points: np.ndarray, target: float) -> np.ndarray:
        """(nv, 3) least strained positions near `points` (nv, 3) with g = target (m^2), m."""

        def missing(points):
            change = 2.0 * (points - points.mean(axis=0)).ravel() / len(points)
            return 1.0 - spread(points) / target, change / target

        def scaled(points):
            centre = points.mean(axis=0)
            return centre + (points - centre) * np.sqrt(target / spread(points))

        return self._relaxed(points, missing, scaled)

    def ajar(self, stowed: np.ndarray) -> np.ndarray | None:
        """(nv, 3) least strained positions, m, with the flat-folded creases opened by AJAR on average, as their letters
        want it; None where none are folded flat."""
        if not len(self.shut):
            return None
        bend = self.bending * self._turns(self.smooth, stowed, 1.0)
        rows = vstack([STIFF * self._stretching(stowed), STIFF * bend, self._turns(self.shut, stowed, -1.0)])
        wanted = np.zeros(rows.shape[0])
        wanted[-len(self.shut) :] = -AJAR * self.sense
        step = lsqr(rows.tocsr(), wanted, damp=1e-6 / self.size, atol=1e-12, btol=1e-12, iter_lim=20000)[0]
        closed = np.isin(self.creases, self.shut)

        def missing(points):
            angles = self.sense * self._unwrapped(points)[closed]
            turns = self._turns(self.shut, points, None)
            return np.pi - AJAR - angles.mean(), np.asarray(turns.T @ self.sense).ravel() / len(self.shut)

        return self._relaxed(stowed + step.reshape(-1, 3), missing)

    def _unwrapped(self, points: np.ndarray) -> np.ndarray:
        """Fold angles of the creases, rad, nearest to those of the last state: beyond pi sides have passed."""
        return (
            self.angles + np.remainder(fold_angles(self.mesh, points)[self.creases] - self.angles + np.pi, TURN) - np.pi
        )

    def _residual(self, points: np.ndarray) -> np.ndarray:
        """What is to vanish: stretch of edges and braces, bending, passing of creases."""
        i, j = self.ends.T
        stretch = 0.5 * (np.sum((points[j] - points[i]) ** 2, axis=1) / self.square - 1.0)
        angles = self._unwrapped(points)
        passed = angles - np.clip(angles, -np.pi, np.pi)
        return np.concatenate([stretch, self.bending * fold_angles(self.mesh, points)[self.smooth], passed])

    def _slope(self, points: np.ndarray) -> csc_matrix:
        """Of _residual."""
        passed = (np.abs(self._unwrapped(points)) > np.pi).astype(float)
        bend, turns = (self._turns(edges, points, None) for edges in (self.smooth, self.creases))
        return vstack([self._stretching(points), self.bending * bend, diags(passed) @ turns]).tocsc()

    def _stretching(self, points: np.ndarray) -> csc_matrix:
        i, j = self.ends.T
        along = (points[j] - points[i]) / self.square[:, None]
        rows = np.repeat(np.arange(len(i)), 6)
        columns = (3 * self.ends[:, :, None] + np.arange(3)).reshape(len(i), 6).ravel()
        values = np.concatenate([-along, along], axis=1).ravel()
        return csc_matrix((values, (rows, columns)), shape=(len(i), points.size))

    def _turns(self, edges: np.ndarray, points: np.ndarray, alike: float | None) -> csc_matrix:
        """(k, 3 nv) change of the fold angles of edges, rad: of the elements left and right of them, each towards its
        own normal. With `alike` the normal of the right one is that of the left one times it."""
        mesh, count = self.mesh, len(edges)
        ends = mesh.edges[edges].astype(int)
        a, b = points[ends[:, 0]], points[ends[:, 1]]
        columns, values, normal = [], [], None
        for k in (0, 1):
            element = mesh.triangles[mesh.edge_triangles[edges, k]].astype(int)
            if normal is None or alike is None:
                u, v = (points[element[:, c]] - points[element[:, 0]] for c in (1, 2))
                normal = np.cross(u, v)
                normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            else:
                normal = alike * normal
            apex = element.sum(axis=1) - ends.sum(axis=1)
            share = np.sum((points[apex] - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1)
            height = np.linalg.norm(points[apex] - a - share[:, None] * (b - a), axis=1)
            weights = np.stack([np.ones(count), share - 1.0, -share], axis=1) / height[:, None]
            columns.append(3 * np.stack([apex, ends[:, 0], ends[:, 1]], axis=1)[:, :, None] + np.arange(3))
            values.append(weights[:, :, None] * normal[:, None, :])
        rows = np.repeat(np.arange(count), 18)
        columns, values = (np.stack(part, axis=1).ravel() for part in (columns, values))
        return csc_matrix((values, (rows, columns)), shape=(count, points.size))

    def _relaxed(self, points: np.ndarray, constraint: Constraint, restored=lambda points: points) -> np.ndarray:
        """(nv, 3) least strained positions near `points` that meet the constraint, m; `restored` brings points onto it
        where that is easy."""
        least = LEAST_DAMPING / self.size**2
        damping = 1e7 * least
        points = restored(points)
        residual, (missing, normal) = self._residual(points), constraint(points)
        merit, slope, idle = residual @ residual + missing**2, self._slope(points), 0
        for _ in range(ITERATIONS):
            try:
                factors = splu((slope.T @ slope + damping * identity(points.size)).tocsc())
            except RuntimeError:  # singular
                damping *= 10.0
                continue
            free, push = factors.solve(-(slope.T @ residual)), factors.solve(normal)
            step = (free + (missing - normal @ free) / (normal @ push) * push).reshape(-1, 3)
            trial = restored(points + step)
            found, constrained = self._residual(trial), constraint(trial)
            trial_merit = found @ found + constrained[0] ** 2
            small = np.abs(step).max() < 1e-13 * self.size
            if trial_merit < merit:
                idle = idle + 1 if trial_merit > (1.0 - GAIN) * merit else 0
                points, merit, damping = trial, trial_merit, max(0.1 * damping, least)
                if merit < 1e-28 or small or idle == 2:
                    break
                residual, slope, (missing, normal) = found, self._slope(points), constrained
            else:
                damping *= 10.0
                if small or damping > 1e17 * least:
                    break
        self.angles = self._unwrapped(points)
        return points
