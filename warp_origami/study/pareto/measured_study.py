"""The runs of one scene over its settings: measured side by side, within a budget of wall time, kept in a folder."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from warp_origami.errors import InputError
from warp_origami.model.generators import build_pattern
from warp_origami.model.mesh import Mesh
from warp_origami.scene import Scene, load_scene

from ..measured.measurement import Measurement
from ..measured.side_by_side import Job, SideBySide
from .settings import OWN, Setting, contact_methods, meshes

FRAMES = 400
"""At which a motion is recorded, over the whole run."""

COST_EXPONENT = 1.65
"""Seconds grow like this power of the number of elements (measured: 10 times for 4 times the elements)."""

MESH_SHARE = 0.2
"""Of the budget, that a run on a finer mesh may take."""

PATIENCE = 4.0
"""Over the expected seconds of a run: how long it may take."""

SHORT = 10.0
"""Seconds that a run may be expected to take at the least."""

WARM_UP = "warm-up: "


@dataclass(frozen=True)
class Request:
    """What the user asks for.

    Attributes:
        name: of a bundled scene, or path.
        overrides: changes to the scene, as of load_scene.
        folder: of the results.
        budget: s of wall time.
        until: end every run there, s; None: at the scene's end.
        jobs: runs at a time.
        told: is called with a line about every run that has ended.
    """

    name: str
    overrides: tuple[str, ...]
    folder: Path
    budget: float
    until: float | None
    jobs: int
    told: Callable[[str], None]


class MeasuredStudy:
    """Makes the runs that a plan asks for.

    Attributes:
        scene: with its own settings.
        end: of every run, s or load factor.
        mesh: of the scene; motions are compared at its vertices.
        runs: what each setting gave, in the order of their ends.
    """

    def __init__(self, request: Request):
        """Raises InputError where there is no such scene, or `until` leaves it without modes."""
        self.request = request
        self.deadline = time.monotonic() + request.budget
        self.scene = load_scene(request.name, request.overrides)
        self.end = self.scene.analysis.end
        if request.until is not None:
            if self.scene.analysis.kind == "modal" and request.until < self.end:
                raise InputError("--until", request.until, "nothing before load factor 1, where modes are found")
            self.end = min(self.end, request.until)
        self.mesh = _mesh(self.scene)
        self.runs: dict[Setting, Measurement] = {}
        self._elements = {(): len(self.mesh.triangles)}

    @cached_property
    def pool(self) -> SideBySide:
        """Runs the processes."""
        return SideBySide(self.request.folder / "runs", self.request.jobs)

    @property
    def remaining(self) -> float:
        """Seconds of the budget that are left."""
        return self.deadline - time.monotonic()

    def warm_up(self) -> None:
        """Compiles the kernels, so that no measurement contains that: runs without time end with their first row.

        Raises:
            InputError: the scene cannot be modelled.
        """
        scenes = [OWN, *contact_methods(self.scene)]
        nothing = np.zeros(0, dtype=int)
        jobs = (Job(WARM_UP + one.label, self._load(one), nothing, self.end, np.inf, 1e-3) for one in scenes)
        for job, gave, _ in self.pool.run(jobs):
            if job.label == WARM_UP + OWN.label and gave.status == "refused":
                key, _, rest = gave.message.partition(": got ")
                raise InputError(key, *rest.split(", wants ", 1))

    def measure(
        self,
        settings: Sequence[Setting],
        until: Callable[[Setting, Sequence[Setting]], float],
        least: float,
        limit: Callable[[Setting], float] = lambda _: np.inf,
    ) -> None:
        """Makes runs; what a setting gave before is replaced.

        Args:
            settings: in their order, each once.
            until: end of the run of a setting, decided when it begins and the given settings follow.
            least: a run that got this far, made earlier, will do.
            limit: s of wall time for a setting.
        """
        by_label = {setting.label: setting for setting in settings}
        for job, gave, kept in self.pool.run(self._jobs(settings, until, least, limit)):
            self.runs[by_label[job.label]] = gave
            parts = [job.label, gave.status, f"{gave.seconds[-1]:.1f} s" if len(gave.seconds) else "", gave.message]
            self.request.told(": ".join(part for part in parts if part) + (" (kept from before)" if kept else ""))

    def _jobs(self, settings, until, least: float, limit) -> Iterator[Job]:
        for k, setting in enumerate(settings):
            try:
                scene = self._load(setting)
                vertices = coinciding(self.mesh, _mesh(scene))
            except InputError as error:
                self.runs[setting] = Measurement.without("refused", str(error))
                continue
            end = until(setting, settings[k + 1 :])
            yield Job(setting.label, scene, vertices, end, least, min(limit(setting), self.remaining))

    def _load(self, setting: Setting) -> Scene:
        measured = (f"output.fps={FRAMES / self.end!r}", "output.fields=[]")
        return load_scene(self.request.name, (*self.request.overrides, *setting.mesh, *setting.changes, *measured))

    def other_meshes(self) -> list[Setting]:
        """Meshes to compare with the scene's own, coarse to fine."""
        own = self._load(OWN).pattern
        return [mesh for mesh in meshes(self.scene) if self._load(mesh).pattern != own]

    def weight(self, setting: Setting) -> float:
        """Expected seconds over those of the scene's own settings."""
        ratio = self.elements(setting) / len(self.mesh.triangles)
        return ratio**COST_EXPONENT * max(1.0, setting.fineness)

    def patience(self, setting: Setting, own: float) -> float:
        """Seconds after which a setting is given up, as no choice, where the scene's own settings take `own`."""
        return PATIENCE * self.weight(setting) * max(own, SHORT)

    def elements(self, setting: Setting) -> int:
        """Of its mesh."""
        if setting.mesh not in self._elements:
            self._elements[setting.mesh] = len(_mesh(self._load(setting)).triangles)
        return self._elements[setting.mesh]


def _mesh(scene: Scene) -> Mesh:
    table = scene.pattern
    return build_pattern(table.kind, table.parameters(), scene.directory, table.refine).mesh


def coinciding(mesh: Mesh, other: Mesh) -> np.ndarray:
    """(nv,) for each vertex of a mesh the one of another mesh at the same place of the flat sheet, -1 without one."""
    nearest = np.arange(len(mesh.vertices))
    if len(other.vertices) < len(nearest) or not np.allclose(
        other.vertices[nearest], mesh.vertices, rtol=0.0, atol=1e-9 * mesh.size
    ):
        distance = np.linalg.norm(mesh.vertices[:, None] - other.vertices[None], axis=2)
        nearest = distance.argmin(axis=1)
        nearest = np.where(distance.min(axis=1) < 1e-9 * mesh.size, nearest, -1)
    return nearest
