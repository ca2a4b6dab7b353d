"""The way between the stowed and the flat state with the least strain, and how large that strain is.

With l the lengths of the edges and of braces across every smooth edge (between the two corners that do not lie on it),
L those of the flat sheet, b the angles at smooth edges, c by how much creases are folded beyond pi, and g the mean
square distance of the vertices from their centre,

    sum ((l^2 - L^2) / (2 L^2))^2 + sum b^2 + sum c^2 = min
    at   g = g_flat - (1 - s)^2 (g_flat - g_stowed),   s = 0 (stowed) ... 1 (flat)

solved by Newton's method (Gauss-Newton, with the constraint by a multiplier) from one state to the next. Folding
brings no two points farther apart than they are in the flat sheet, so g is largest there, and its loss goes with the
square of the fold angles. Creases that are folded flat are opened first, as their letters want it: there the mean of
the fold angles is given instead of g.

Where a pattern folds rigidly the sum is zero to round-off all the way; where it does not, what is found is a minimum
near the path that was followed: an upper bound of the least strain. A film has next to no bending stiffness: with
`plane` false its panels may bend along the sides of the elements, without braces and b^2 with the weight SOFT^2.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, identity, vstack
from scipy.sparse.linalg import lsqr, splu

from .crossing import find_crossing
from .fold_angles import fold_angles
from .mesh import CREASE, SMOOTH, Mesh

LARGEST = 3000
"""Vertices of the largest pattern whose path is looked for: beyond, it takes minutes."""

ITERATIONS = 60
"""Of Newton's method, for each state."""

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

RIGID = 1e-8
"""Strain that counts as none: what Newton's method leaves of a rigid folding."""

Constraint = Callable[[np.ndarray], tuple[float, np.ndarray]]
"""Points (nv, 3) -> what they miss (a number without unit), and by how much a motion reduces that (3 nv,), 1/m."""


@dataclass(frozen=True)
class FoldingPath:
    """States from stowed to flat.

    Attributes:
        progress: (n,) s, 0 stowed to 1 flat.
        positions: (n, nv, 3) m.
        strain: (n,) largest strain |l - L| / L of edges, and of braces if panels are to stay plane.
        mean_strain: (n,) root mean square of it.
        bending: (n,) largest angle between the two elements at a smooth edge, rad.
        crossing: (n,) whether panels pass through each other.
    """

    progress: np.ndarray
    positions: np.ndarray
    strain: np.ndarray
    mean_strain: np.ndarray
    bending: np.ndarray
    crossing: np.ndarray

    @property
    def rigid(self) -> bool:
        """Whether all states are free of strain and bending."""
        return bool(self.strain.max() < RIGID and self.bending.max() < RIGID)


def folding_path(mesh: Mesh, stowed: np.ndarray, states: int = 21, plane: bool = True) -> FoldingPath | None:
    """Path from the stowed to the flat state.

    None for more than LARGEST vertices, and where the stowed state is flat or spread out as wide as the flat one.

    Args:
        stowed: (nv, 3) m.
        states: number of them, both ends included.
        plane: whether panels are to stay plane.
    """
    flat = np.column_stack([mesh.vertices, np.zeros(len(mesh.vertices))])
    spread = _spread(flat), _spread(stowed)
    if len(flat) > LARGEST or spread[0] - spread[1] < 1e-9 * spread[0]:
        return None
    panels = _Panels(mesh, flat, stowed, plane)
    found = [stowed]
    ajar = panels.ajar(stowed)
    if ajar is not None and _spread(ajar) < spread[0]:
        found.append(ajar)
    begun = 1.0 - np.sqrt((spread[0] - _spread(found[-1])) / (spread[0] - spread[1]))
    progress = np.linspace(max(begun, 0.0), 1.0, states + 1 - len(found))
    for s in progress[1:-1]:
        start = 2.0 * found[-1] - found[-2] if len(found) > 1 else stowed
        found.append(panels.widened(start, spread[0] - (1.0 - s) ** 2 * (spread[0] - spread[1])))
    found.append(flat)
    strains = [np.abs(panels.strains(points)) for points in found]
    bends = [fold_angles(mesh, points)[mesh.edge_kinds == SMOOTH] for points in found]
    return FoldingPath(
        np.concatenate([[0.0], progress]) if len(found) > len(progress) else progress,
        np.array(found),
        np.array([s.max() for s in strains]),
        np.array([np.sqrt(np.mean(s**2)) for s in strains]),
        np.array([np.abs(bend).max(initial=0.0) for bend in bends]),
        np.array([find_crossing(points, mesh.edges, mesh.triangles) is not None for points in found]),
    )


def _spread(points: np.ndarray) -> float:
    """g, m^2."""
    return float(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1)))


class _Panels:
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
            return 1.0 - _spread(points) / target, change / target

        def scaled(points):
            centre = points.mean(axis=0)
            return centre + (points - centre) * np.sqrt(target / _spread(points))

        return self._relaxed(points, missing, scaled)

    def ajar(self, stowed: np.ndarray) -> np.ndarray | None:
        """(nv, 3) least strained positions, m, with the flat-folded creases opened by AJAR on average, as their letters
        want it; None where none are folded flat."""
        if not len(self.shut):
            return None
        bend = self.bending * sum(self._turns(self.smooth, stowed, 1.0))
        rows = vstack([STIFF * self._stretching(stowed), STIFF * bend, sum(self._turns(self.shut, stowed, -1.0))])
        wanted = np.zeros(rows.shape[0])
        wanted[-len(self.shut) :] = -AJAR * self.sense
        step = lsqr(rows.tocsr(), wanted, damp=1e-6 / self.size, atol=1e-12, btol=1e-12, iter_lim=20000)[0]
        closed = np.isin(self.creases, self.shut)

        def missing(points):
            angles = self.sense * self._unwrapped(points)[closed]
            turns = sum(self._turns(self.shut, points, None))
            return np.pi - AJAR - angles.mean(), np.asarray(turns.T @ self.sense).ravel() / len(self.shut)

        return self._relaxed(stowed + step.reshape(-1, 3), missing)

    def _unwrapped(self, points: np.ndarray) -> np.ndarray:
        """Fold angles of the creases, rad, nearest to those of the last state: beyond pi sides have passed."""
        return (
            self.angles + np.remainder(fold_angles(self.mesh, points)[self.creases] - self.angles + np.pi, TURN) - np.pi
        )

    def _residual(self, points: np.ndarray) -> tuple[np.ndarray, csc_matrix]:
        """What is to vanish, and its slope."""
        i, j = self.ends.T
        stretch = 0.5 * (np.sum((points[j] - points[i]) ** 2, axis=1) / self.square - 1.0)
        bend = fold_angles(self.mesh, points)[self.smooth]
        angles = self._unwrapped(points)
        beyond = np.flatnonzero(np.abs(angles) > np.pi)
        passed = angles[beyond] - np.pi * np.sign(angles[beyond])
        slopes = [self._stretching(points), self.bending * sum(self._turns(self.smooth, points, None))]
        slopes += [sum(self._turns(self.creases[beyond], points, None))] if len(beyond) else []
        return np.concatenate([stretch, self.bending * bend, passed]), vstack(slopes).tocsc()

    def _stretching(self, points: np.ndarray) -> csc_matrix:
        i, j = self.ends.T
        along = (points[j] - points[i]) / self.square[:, None]
        rows = np.repeat(np.arange(len(i)), 6)
        columns = (3 * self.ends[:, :, None] + np.arange(3)).reshape(len(i), 6).ravel()
        values = np.concatenate([-along, along], axis=1).ravel()
        return csc_matrix((values, (rows, columns)), shape=(len(i), points.size))

    def _turns(self, edges: np.ndarray, points: np.ndarray, alike: float | None) -> list[csc_matrix]:
        """Rotation (k, 3 nv), rad, of the elements left and right of edges, each towards its own normal: their sum is
        the change of the fold angle. With `alike` the normal of the right one is that of the left one times it."""
        mesh, count = self.mesh, len(edges)
        ends = mesh.edges[edges].astype(int)
        a, b = points[ends[:, 0]], points[ends[:, 1]]
        found, normal = [], None
        for k in (0, 1):
            element = mesh.triangles[mesh.edge_triangles[edges, k]].astype(int)
            if normal is None or alike is None:
                normal = np.cross(
                    points[element[:, 1]] - points[element[:, 0]], points[element[:, 2]] - points[element[:, 0]]
                )
                normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            else:
                normal = alike * normal
            apex = element.sum(axis=1) - ends.sum(axis=1)
            share = np.sum((points[apex] - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1)
            height = np.linalg.norm(points[apex] - a - share[:, None] * (b - a), axis=1)
            weights = np.stack([np.ones(count), share - 1.0, -share], axis=1) / height[:, None]
            columns = 3 * np.stack([apex, ends[:, 0], ends[:, 1]], axis=1)[:, :, None] + np.arange(3)
            values = weights[:, :, None] * normal[:, None, :]
            rows = np.repeat(np.arange(count), 9)
            found.append(csc_matrix((values.ravel(), (rows, columns.ravel())), shape=(count, points.size)))
        return found

    def _relaxed(self, points: np.ndarray, constraint: Constraint, restored=lambda points: points) -> np.ndarray:
        """(nv, 3) least strained positions near `points` that meet the constraint, m; `restored` brings points onto it
        where that is easy."""
        least = LEAST_DAMPING / self.size**2
        damping = 1e7 * least
        points = restored(points)
        (residual, slope), (missing, normal) = self._residual(points), constraint(points)
        merit = residual @ residual + missing**2
        for _ in range(ITERATIONS):
            factors = splu((slope.T @ slope + damping * identity(points.size)).tocsc())
            free, push = factors.solve(-(slope.T @ residual)), factors.solve(normal)
            step = (free + (missing - normal @ free) / (normal @ push) * push).reshape(-1, 3)
            trial = restored(points + step)
            found, constrained = self._residual(trial), constraint(trial)
            trial_merit = found[0] @ found[0] + constrained[0] ** 2
            small = np.abs(step).max() < 1e-13 * self.size
            if trial_merit < merit:
                gain = 1.0 - trial_merit / merit
                points, merit, damping = trial, trial_merit, max(0.1 * damping, least)
                (residual, slope), (missing, normal) = found, constrained
                if merit < 1e-28 or (small and gain < 1e-9):
                    break
            else:
                damping *= 10.0
                if small or damping > 1e17 * least:
                    break
        self.angles = self._unwrapped(points)
        return points
