"""Values read out of a finished run by their paths: history.COLUMN, probes.NAME.COLUMN, frequencies.N, ..."""

from collections.abc import Iterable

import numpy as np

from warp_origami.api import Run
from warp_origami.errors import InputError
from warp_origami.model.submesh import Submesh
from warp_origami.scene import Scene
from warp_origami.scene.expression import parse
from warp_origami.solve.records import HISTORY_COLUMNS, PROBE_COLUMNS, REACTION_COLUMNS, SPIN_COLUMNS


def paths(of: str) -> tuple[str, ...]:
    """Results that an expression names; see scene.expression."""
    return parse(of).paths


def check_path(path: str, scene: Scene, key: str) -> None:
    """Refuses a path that no run of the scene has.

    Raises:
        InputError: naming `key` and what there is.
    """
    table, *rest = path.split(".")
    if table == "surface":
        return
    if table == "frequencies":
        count = scene.analysis.count if scene.analysis.kind == "modal" else 0
        if int(rest[0]) >= count:
            known = (
                f"frequencies.0 to frequencies.{count - 1}" if count else 'frequencies only if analysis.kind = "modal"'
            )
            raise InputError(key, f'"{path}"', known)
        return
    if table == "spin":
        if not scene.turns or path.removeprefix("spin.") not in SPIN_COLUMNS:
            raise InputError(key, f'"{path}"', "of a scene with a hub or an initial spin " + ", ".join(SPIN_COLUMNS))
        return
    names = {
        "probes": [probe.name for probe in scene.probe],
        "reactions": [mover.name for mover in (*scene.support, *scene.driver) if mover.name is not None],
    }
    columns = {"history": HISTORY_COLUMNS, "probes": PROBE_COLUMNS, "reactions": REACTION_COLUMNS}[table]
    if table in names and rest[0] not in names[table]:
        raise InputError(key, f'"{path}"', f"{table} of " + (", ".join(names[table]) or "the scene, which has none"))
    if rest[-1] not in columns:
        raise InputError(key, f'"{path}"', "one of the columns " + ", ".join(columns))


def column(path: str, run: Run) -> np.ndarray:
    """(n,) rows of a path, a frequency (Hz), or the volume under the last frame (m^3).

    NaN for a frequency beyond those of the sheet, and for the volume if no frame was kept.
    """
    table, *rest = path.split(".")
    if table == "surface":
        return volume(run.frames[-1].points, run.surface) if run.frames else np.nan
    if table == "frequencies":
        found = run.summary["frequencies"]
        return found[int(rest[0])] if int(rest[0]) < len(found) else np.nan
    if table == "history":
        return run.history[rest[0]]
    if table == "spin":
        return run.spin[path.removeprefix("spin.")]
    if table == "probes":
        return run.probes[rest[0]][:, PROBE_COLUMNS.index(rest[1])]
    return run.reactions[rest[0]][:, REACTION_COLUMNS.index(rest[1])]


def read_value(of: str, run: Run) -> float:
    """Value of an expression over the results of a run in its last row; see scene.expression."""
    return parse(of).value(lambda path: column(path, run))


def without_value(of: str, run: Run) -> list[str]:
    """A line for each frequency that an expression names and the sheet is too coarse to have."""
    paths = [path for path in dict.fromkeys(parse(of).paths) if path.startswith("frequencies.")]
    known = len(run.summary["frequencies"]) if paths else 0
    return [f"{path}: the sheet has only {known} modes" for path in paths if int(path.split(".")[1]) >= known]


def volume(points: np.ndarray, surface: Submesh) -> float:
    """Volume between the surface and the plane z = 0, m^3, positive where the sheet's upper side faces away from it.

    Plane sub-triangles, k to a side of each element, and those through the corners of the elements alone give it with
    errors c / k^2 and c, which leaves V = (k^2 V_k - V_1) / (k^2 - 1).

    Args:
        points: (np, 3) points of the drawn surface.
        surface: its triangles.
    """
    squared = surface.divisions**2
    fine = _below(points, surface.triangles)
    if squared == 1:
        return fine
    corner = surface.areas.max(axis=1) == 1.0
    of_elements = surface.triangles.reshape(-1, 3 * squared)
    corners = of_elements[corner[of_elements]].reshape(-1, 3)
    x, y = (surface.flat[corners, axis] for axis in (0, 1))
    turned = np.sum(x * (np.roll(y, -1, axis=1) - np.roll(y, 1, axis=1)), axis=1) < 0.0
    corners[turned] = corners[turned, ::-1]
    return (squared * fine - _below(points, corners)) / (squared - 1)


def _below(points: np.ndarray, triangles: np.ndarray) -> float:
    """Volume between plane triangles (n, 3) and z = 0: of prisms that have the mean height of their corners."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    (x1, y1), (x2, y2) = (b - a)[:, :2].T, (c - a)[:, :2].T
    return float(np.sum((x1 * y2 - x2 * y1) * (a + b + c)[:, 2]) / 6.0)


def check_values(expressions: Iterable[tuple[str, str]], scene: Scene) -> None:
    """Refuses expressions (key in the scene, expression) that no run of the scene can give a value to.

    Raises:
        InputError: naming the key and what there is.
    """
    for key, of in expressions:
        for path in parse(of).paths:
            check_path(path, scene, key)
