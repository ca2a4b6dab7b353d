"""Speed against error: which settings a scene is run with, and what each is held against.

A motion is compared over a window [0, T] that the data choose: the two finest runs on the scene's own mesh are made
first, and T is the time up to which they agree. Finer meshes come next, as far as they can be afforded: the finest of
them whose own two finest runs agree over WINDOW_SHARE of that window or more gives the reference, for the time up to
which those agree. All other settings on the scene's own mesh run to T, where they are held against the finest run on
that mesh too, and then, as far as the budget allows, through the whole scene, for the statistics of energy and contact.
Wall time and memory are recorded at every frame: all runs are measured over the same window, however far they went.

What has known values, and what is not a motion (static, modal), is compared at its end.
"""

from collections.abc import Callable, Sequence

import numpy as np

from .errors import agreement, length_scale
from .findings import Findings, findings_at_end, findings_of_motion
from .measured_study import MESH_SHARE, MeasuredStudy, Request
from .settings import AGAIN, OWN, Setting, on_meshes, other_settings, stepping_ladder

WINDOW_SHARE = 0.2
PAIR_SHARE = 0.15
"""Of the budget, that each of the two finest runs on the scene's own mesh may take."""

OWN_SHARE = 0.4
"""Of the budget, that the scene's own settings may take."""

LATER_MESHES = 0.3
"""Of the time that is left, that a pair of runs on a further mesh may take."""

SPARE = 1.5
"""How many times a run's expected seconds must be left for it to go through the whole scene."""


class MotionStudy(MeasuredStudy):
    """Compares motions over a window.

    Attributes:
        reference: the finest run.
        window: number of frames up to which it is known; 0 until then.
        own_window: the same for the finest run on the scene's own mesh.
    """

    def __init__(self, request: Request):
        super().__init__(request)
        self.reference, self.window, self.own_window = OWN, 0, 0

    def run(self) -> None:
        """Makes all runs."""
        self.warm_up()
        ladder = stepping_ladder(self.scene)
        budget = self.request.budget
        shares = {OWN: OWN_SHARE}
        first = [*reversed(ladder[-2:]), OWN]
        self.measure(first, self._whole, self.end, lambda one: shares.get(one, PAIR_SHARE) * budget)
        self.reference, self.own_window = self._agreeing([OWN, *ladder])
        self.window, until = self.own_window, self._time(self.reference, self.own_window)
        others = self.other_meshes()
        used = self._finer_meshes([mesh for mesh in others if self.weight(mesh) > 1.0], until, MESH_SHARE * budget)
        coarser = [mesh for mesh in others if self.weight(mesh) < 1.0]
        rest = [*reversed(ladder[:-2]), *coarser, *other_settings(self.scene), AGAIN]
        least = self._time(self.reference, self.window)
        self.measure(rest, lambda *those: self._end(until, *those), until, self._patience)
        combined = [one for mesh in used for one in on_meshes(self.scene, mesh) if one not in self.runs]
        self.measure(combined, lambda *_: least, least, self._patience)
        self._complete([*other_settings(self.scene), *reversed(ladder)])

    def findings(self) -> Findings:
        """Costs and errors of the runs so far."""
        return findings_of_motion(self, self.reference, self.window, self.own_window)

    def _time(self, setting: Setting, window: int) -> float:
        """End of a window, s; that of the scene where it is not known."""
        return float(self.runs[setting].times[window - 1]) if window else self.end

    def _finer_meshes(self, finer: Sequence[Setting], until: float, limit: float) -> list[Setting]:
        """Runs pairs on finer meshes, in their order; returns the meshes whose runs could serve as reference."""
        used = []
        for mesh in finer:
            if not self._affordable(mesh, used, WINDOW_SHARE * self._seconds(self.own_window), limit):
                break
            pair = [on_meshes(self.scene, mesh)[-1], mesh]
            self.measure(pair, lambda *_: until, until, lambda _: limit)
            reference, agreeing = self._agreeing(pair)
            if agreeing < WINDOW_SHARE * self.own_window:
                reached = min(len(self.runs[one].times) for one in pair)
                self.request.told(
                    f"{mesh.label}: no reference, its two finest runs agree over {agreeing} of {self.own_window} frames"
                    f" (both reached {reached})"
                )
                break
            self.reference, self.window = reference, agreeing
            used.append(mesh)
        return used

    def _affordable(self, mesh: Setting, used: Sequence[Setting], own: float, limit: float) -> bool:
        """Whether a pair of runs can get through enough of the window, and leaves most of the time to other settings;
        `own` is what the scene's own settings take for that."""
        if not used:
            return self.weight(mesh) * own < limit
        last = float(self.runs[self.reference].seconds[-1]) * self.weight(mesh) / self.weight(used[-1])
        return last < limit and 2.0 * last < LATER_MESHES * self.remaining * self.request.jobs

    def _agreeing(self, settings: Sequence[Setting]) -> tuple[Setting, int]:
        """The finest of the runs, and the number of frames up to which the two finest agree."""
        sound = [one for one in settings if one in self.runs and self.runs[one].status in ("done", "timed out")]
        pair = sorted((one for one in sound if len(self.runs[one].times)), key=lambda one: one.fineness)[-2:]
        if len(pair) < 2:
            return OWN, 0
        second, finest = (self.runs[one] for one in pair)
        return pair[-1], agreement(second, finest, length_scale(finest, self.mesh.size))

    def _seconds(self, frames: int) -> float:
        """Of the scene's own settings up to a frame; 0 where it has not been reached."""
        seconds = self.runs[OWN].seconds if OWN in self.runs else ()
        return float(seconds[frames - 1]) if 0 < frames <= len(seconds) else 0.0

    def _whole(self, setting: Setting, following: Sequence[Setting]) -> float:
        return self.end

    def _end(self, until: float, setting: Setting, following: Sequence[Setting]) -> float:
        """The end of the scene if those that follow can still be run to `until`, else that."""
        needed = sum(self.weight(one) for one in following) * self._seconds(self.own_window)
        return self.end if self._whole_cost(setting) + needed < self.remaining * self.request.jobs else until

    def _patience(self, setting: Setting) -> float:
        return self.patience(setting, self._seconds(self.own_window))

    def _whole_cost(self, setting: Setting) -> float:
        """Seconds to be left for a run through the whole scene."""
        own = self.runs[OWN]
        return SPARE * self.weight(setting) * float(own.seconds[-1]) if own.status == "done" else np.inf

    def _complete(self, settings: Sequence[Setting]) -> None:
        """Runs through the whole scene what has only been run through the window, as far as time is left."""
        left, chosen = self.remaining * self.request.jobs, []
        for setting in settings:
            run, cost = self.runs[setting], self._whole_cost(setting)
            if cost < left and run.status == "done" and run.times[-1] < self.end * (1.0 - 1e-6):
                left -= cost
                chosen.append(setting)
        self.measure(chosen, self._whole, self.end)


class EndStudy(MeasuredStudy):
    """Compares what runs give at their end: known values, frequencies, the equilibrium."""

    def run(self) -> None:
        """Makes all runs."""
        self.warm_up()
        self._measure_all([OWN])
        used = []
        for mesh in self.other_meshes():
            if self.weight(mesh) * self._seconds() > MESH_SHARE * self.request.budget:
                break
            self._measure_all([mesh])
            used.append(mesh)
        rest = stepping_ladder(self.scene) if self.scene.analysis.kind == "dynamic" else []
        rest = [*rest, *other_settings(self.scene), AGAIN]
        for mesh in used:
            rest += on_meshes(self.scene, mesh)
        self._measure_all(rest, self._patience)

    def findings(self) -> Findings:
        """Costs and errors of the runs so far."""
        return findings_at_end(self)

    def _measure_all(self, settings: Sequence[Setting], limit: Callable[[Setting], float] = lambda _: np.inf) -> None:
        self.measure(settings, lambda *_: self.end, self.end, limit)

    def _patience(self, setting: Setting) -> float:
        return self.patience(setting, self._seconds())

    def _seconds(self) -> float:
        return self.runs[OWN].summary.get("wall_seconds", 0.0)


def study(request: Request) -> MeasuredStudy:
    """The study of a scene that suits it, to be run.

    Raises:
        InputError: there is no such scene.
    """
    found = EndStudy(request)
    at_end = found.scene.analysis.kind != "dynamic" or (
        found.scene.verification is not None and found.end == found.scene.analysis.end
    )
    return found if at_end else MotionStudy(request)
