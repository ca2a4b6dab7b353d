"""Every accepted step of a run looked at with the same eyes, whatever contact the run itself had.

Crossing is looked for on a sub-mesh finer than the one that carries the forces. Penetration is that of the mixed
method: how far below the thickness that counts there the deepest slave point or edge is, its side kept from the start.
"""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from warp_origami.clock import PhaseClock
from warp_origami.system import System

from .crossing import Crossing, CrossingOracle
from .runs import Result, scene_of


@dataclass(frozen=True)
class Touch:
    """Contact forces of one state: (k, 2, 2) flat positions of both points of each pair (m), (k,) forces (N)."""

    flat: np.ndarray
    forces: np.ndarray


class Watched:
    """What was seen of a run.

    Attributes:
        times: (n,) s.
        penetration: (n,) m.
        crossings: (n,) list of Crossing of each state, the deepest first; empty where nothing crosses.
        touches: (n,) Touch of each state under the run's own contact; none without contact.
    """

    def __init__(self, result: Result, folder: Path, divisions: int):
        self.times = result.times
        path = folder / result.case.name / f"crossings_{divisions}.json"
        if not path.exists():
            path.write_text(json.dumps([[_plain(c) for c in found] for found in _crossings(result, divisions)]))
        self.crossings = [
            [Crossing(**{**c, "flat": np.array(c["flat"])}) for c in found] for found in json.loads(path.read_text())
        ]
        path = folder / result.case.name / "contacts.npz"
        if not path.exists():
            _save_contacts(result, path)
        with np.load(path) as saved:
            self.penetration = saved["penetration"]
            where = np.cumsum(saved["counts"])[:-1]
            self.touches = [
                Touch(*pair)
                for pair in zip(np.split(saved["flat"], where), np.split(saved["forces"], where), strict=True)
            ]

    @property
    def crosses(self) -> np.ndarray:
        """(n,) bool."""
        return np.array([len(found) > 0 for found in self.crossings])

    @property
    def depths(self) -> np.ndarray:
        """(n,) of the deepest crossing, m; 0 where nothing crosses."""
        return np.array([found[0].depth if found else 0.0 for found in self.crossings])

    @property
    def touching(self) -> np.ndarray:
        """(n,) bool: contact forces act."""
        return np.array([len(touch.forces) > 0 for touch in self.touches])


def crossing_states(result: Result, folder: Path, divisions: int) -> np.ndarray:
    """(n,) bool: the sheet passes through itself on the given sub-mesh; where and how deep is not looked at."""
    path = folder / result.case.name / f"crosses_{divisions}.json"
    if not path.exists():
        submesh, interpolation = result.submesh(divisions)
        oracle = CrossingOracle(submesh, interpolation @ result.q[0])
        path.write_text(json.dumps([oracle.crosses(interpolation @ q) for q in result.q]))
    return np.array(json.loads(path.read_text()))


def _crossings(result: Result, divisions: int) -> list[list[Crossing]]:
    submesh, interpolation = result.submesh(divisions)
    oracle = CrossingOracle(submesh, interpolation @ result.q[0])
    points = (interpolation @ q for q in result.q)
    return [oracle.find(x) if oracle.crosses(x) else [] for x in points]


def _plain(crossing: Crossing) -> dict:
    return {**asdict(crossing), "flat": crossing.flat.tolist()}


def _save_contacts(result: Result, path: Path) -> None:
    """Evaluates mixed contact, and the run's own, at every accepted state in their order."""
    eyes = System(scene_of(replace(result.case, method="mixed")), "cpu", PhaseClock()).contact
    own = result.contact
    penetration, touches = [], []
    for q in result.q:
        eyes.gradient(q)
        penetration.append(eyes.statistics().max_penetration)
        eyes.accept(q)
        if own is None:
            touches.append(Touch(np.zeros((0, 2, 2)), np.zeros(0)))
            continue
        own.gradient(q)
        touches.append(Touch(own.flat_points().reshape(-1, 2, 2), own.active_pairs().forces))
        own.accept(q)
    np.savez(
        path,
        penetration=penetration,
        counts=[len(touch.forces) for touch in touches],
        flat=np.concatenate([touch.flat for touch in touches]),
        forces=np.concatenate([touch.forces for touch in touches]),
    )
