"""The loop over time steps: it owns all state of a run, and everything else is told what it needs."""

from contextlib import suppress
from dataclasses import dataclass, fields, replace

import numpy as np

from warp_origami.scene import Scene
from warp_origami.system import System

from .energy import EnergyBalance, Forces
from .generalized_alpha import GeneralizedAlpha, Kinematics
from .packing import pack, pack_memory, restore_memory, unpack
from .passage import passage
from .recording import Recorder
from .records import Observer, StepRecord
from .result import Failure
from .sampling import Surface
from .step import StepOutcome, Stepper
from .step_size import AdaptiveStep, FixedStep, Patience, StepSizeController
from .summary import Counters, summarize

FIRST_STEP_SHARE = 1e-4
SMALLEST_STEP_SHARE = 1e-10
LARGEST_STEP_SHARE = 0.02

RESOLVED_STRAIN = 0.01
"""Strain, over the tolerance, whose energy is the least that the energy balance is held against."""

CREATED_SHARE = 2e-3
"""A step that creates energy is a bad step where the energy error has risen by this share of the run's largest energy
above its earlier minimum, and the step adds to it faster than by the same share over the whole run."""

EXPLODED_SHARE = 0.99
"""A run is ended when this share of its largest energy has been created: what follows has no meaning."""

CRAWLING_SHARE = 1e-8
"""A run whose step is adapted crawls while it is shorter than this share of the duration."""

LONGEST_CRAWL = 200
"""A run that has crawled for so many steps is ended: it would not come to its end."""

NEGLIGIBLE_SHARE, SMALL_SHARE = 1e-5, 5e-5
"""A step may create this share of the run's largest energy; and the larger one if halving it has not made it better."""

LESS_CREATED = 0.8
"""Halving a step twice makes it better if the energy that it creates over its length falls below this share. It need
not fall before steps are shorter than a contact."""

FORGETTING = 0.7
"""Part of a rate that halving has not made better which is borne in the next step too: ringing after changes of the
step creates and loses at rates that do not depend on it."""


@dataclass(frozen=True)
class RunState:
    """All that changes during a run.

    Attributes:
        kinematics: q, v and accelerations.
        next_step: s, to try next.
        forces, balance: for the energy balance.
        counters: numbers for the summary.
        frames: number of frames written.
        crawled: accepted steps since the last one of usual length.
        borne: W, rate at which steps may create energy because shorter ones do no better.
        patience: with growing steps after some that created energy.
    """

    kinematics: Kinematics
    next_step: float
    forces: Forces
    balance: EnergyBalance
    counters: Counters
    frames: int
    crawled: int
    borne: float
    patience: Patience

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything as arrays, for a checkpoint."""
        return pack(vars(self))

    @classmethod
    def from_arrays(cls, arrays: dict[str, np.ndarray]) -> "RunState":
        """The state that `arrays` gave.

        Raises:
            InputError: they are not those of this version of the program.
        """
        return cls(**unpack(arrays, {field.name: field.type for field in fields(cls)}))


class DynamicRun:
    """What stays the same during a run, and the loop."""

    def __init__(self, system: System, observer: Observer, until: float):
        self.system, self.observer, self.until = system, observer, until
        scene, self.clock = system.scene, system.clock
        with self.clock.phase("setup"):
            self.method = GeneralizedAlpha(scene.integrator.spectral_radius)
            self.record, self.surface = Recorder(system), Surface(system)
            self.stepper = Stepper(system, self.method)
        self.controller = _controller(scene)
        self.stops = [*self._kinks(), until]
        strain = RESOLVED_STRAIN * scene.integrator.tolerance
        volume = scene.material.thickness * float(system.mesh.areas.sum())
        self.resolved_energy = 0.5 * scene.material.youngs_modulus * volume * strain**2
        self.fps = None if scene.output.fps == "steps" else float(scene.output.fps)

    def _kinks(self) -> list[float]:
        """Times of kinks in the profiles of drivers: steps end there."""
        motions = [prescriber.motion for prescriber in self.system.constraints.prescribers if prescriber.motion]
        return sorted({t for motion in motions for t in motion.profile.kinks if 0.0 < t < self.until})

    def start(self) -> RunState:
        """The initial state, with its first row and frame written."""
        self.observer.start(self.system.scene, self.surface.submesh, None)
        self.system.accept(self.system.q0)
        kinematics, forces, balance = self.stepper.start(self.controller.first)
        first, none = self.controller.first, Counters()
        state = RunState(kinematics, first, forces, balance, none, frames=0, crawled=0, borne=0.0, patience=Patience())
        with self.clock.phase("output"):
            self.observer.step(self._record(state, 0.0, 0))
            self.observer.frame(self.surface.frame(0.0, kinematics.q))
        return replace(state, frames=1)

    def resume(self, arrays: dict[str, np.ndarray]) -> RunState:
        """The state of a checkpoint."""
        state = RunState.from_arrays(arrays)
        restore_memory("contact", self.system.contact, arrays)
        restore_memory("creases", self.system.creases, arrays)
        restore_memory("padding", self.stepper.constraint_form.padding, arrays)
        self.observer.start(self.system.scene, self.surface.submesh, state.kinematics.time)
        return state

    def at_end(self, state: RunState) -> bool:
        """Whether the end is reached."""
        return state.kinematics.time >= self.until * (1.0 - 1e-12)

    def advance(self, state: RunState) -> tuple[RunState, Failure | None]:
        """The state after the next accepted step, which is retried with smaller ones as often as needed."""
        step, counters, creations, refused = state.next_step, state.counters, [], None
        stop = next(t for t in self.stops if t > state.kinematics.time)
        while True:
            taken = _fit(step, stop - state.kinematics.time)
            outcome = self.stepper.try_step(state.kinematics, state.forces, state.balance, taken)
            counters = counters.tried(outcome)
            smaller = self.controller.after_failure(taken)
            if outcome.failure is not None:
                counters, refused = counters.rejected(), outcome.failure
                creations.clear()
                if smaller is None:
                    return replace(state, counters=counters), outcome.failure
                step = smaller
                continue
            accepted, proposed = self.controller.judge(taken, outcome.error)
            if not accepted:
                counters, step = counters.rejected(), proposed
                creations.clear()
                if smaller is None:
                    return replace(state, counters=counters), Failure(
                        "the smallest step is not accurate enough", "a larger integrator.tolerance"
                    )
                continue
            if smaller is not None and self._creates_energy(outcome, taken, creations, state.borne):
                counters, step = counters.rejected(), smaller
                creations.append(outcome.created)
                continue
            passed = passage(self.system, state.kinematics.q, outcome.kinematics.q)
            if passed is None:
                break
            counters, step, refused = counters.rejected(), smaller, passed
            if smaller is None:
                return replace(state, counters=counters), passed
        if self._has_exploded(outcome):
            advice = 'integrator.step = "auto", a smaller step or tolerance, or a lower spectral_radius'
            return replace(state, counters=counters), Failure("the method creates energy without bound", advice)
        crawling = smaller is not None and taken < CRAWLING_SHARE * self.system.scene.analysis.end
        crawled = state.crawled + 1 if crawling else 0
        if crawled > LONGEST_CRAWL:
            return replace(state, counters=counters), _crawling(refused)
        grown = taken > state.kinematics.auxiliary_step
        patience = state.patience.after_refusal() if creations else state.patience.after_step(grown)
        if patience.left > 0:
            proposed = min(proposed, taken)
        if taken < step:  # cut to land on a stop
            proposed = max(proposed, step)
        if taken == stop - state.kinematics.time:
            outcome = replace(outcome, kinematics=replace(outcome.kinematics, time=stop))
        borne = FORGETTING * state.borne
        if _in_vain(outcome, creations) and outcome.created * taken <= SMALL_SHARE * self._scale(outcome):
            borne = max(outcome.created, borne)
        state = replace(state, crawled=crawled, borne=borne, patience=patience)
        return self._write(state, outcome, counters, proposed), None

    def _creates_energy(self, outcome: StepOutcome, taken: float, creations: list[float], borne: float) -> bool:
        """Whether a step is bad because it creates energy, and shorter ones (`creations` so far, W) may be better."""
        scale = self._scale(outcome)
        rate = CREATED_SHARE * scale / self.system.scene.analysis.end
        if outcome.balance.rise <= CREATED_SHARE * scale or outcome.created <= max(rate, borne):
            return False
        created = outcome.created * taken
        if created <= NEGLIGIBLE_SHARE * scale:
            return False
        return created > SMALL_SHARE * scale or not _in_vain(outcome, creations)

    def _scale(self, outcome: StepOutcome) -> float:
        """The energy that the energy balance is held against, J."""
        return max(outcome.balance.largest, self.resolved_energy)

    def _has_exploded(self, outcome: StepOutcome) -> bool:
        """Whether nearly all energy there is was created by the method."""
        largest = outcome.balance.largest
        return largest > self.resolved_energy and outcome.balance.rise > EXPLODED_SHARE * largest

    def _write(self, before: RunState, outcome: StepOutcome, counters: Counters, proposed: float) -> RunState:
        with self.clock.phase("output"):  # frames within the step see contact as the step has seen it
            frames = self._frames(before.kinematics, outcome.kinematics, before.frames)
        self.system.accept(outcome.kinematics.q)
        counters = counters.accepted(self.record.contacts().max_penetration)
        state = RunState(
            outcome.kinematics,
            proposed,
            outcome.forces,
            outcome.balance,
            counters,
            frames,
            before.crawled,
            before.borne,
            before.patience,
        )
        with self.clock.phase("output"):
            self.observer.step(self._record(state, outcome.kinematics.auxiliary_step, outcome.iterations))
        if state.kinematics.time in self.stops[:-1]:
            state = self._pass_kink(state)
        with self.clock.phase("output"):
            self.observer.checkpoint(self._checkpoint(state))
        return state

    def _pass_kink(self, state: RunState) -> RunState:
        step = self.controller.first
        kinematics, forces, balance = self.stepper.restart(state.kinematics, state.balance, step)
        return replace(state, kinematics=kinematics, forces=forces, balance=balance, next_step=step)

    def _frames(self, before: Kinematics, after: Kinematics, written: int) -> int:
        if self.fps is None:
            self.observer.frame(self.surface.frame(after.time, after.q))
            return written + 1
        while written / self.fps <= after.time * (1.0 + 1e-12):
            due = written / self.fps
            self.observer.frame(self.surface.frame(due, self._between(before, after, due)))
            written += 1
        return written

    def _between(self, before: Kinematics, after: Kinematics, time: float) -> np.ndarray:
        """q at a time within a step; on the straight way, which is known to be free, where the smooth one is not."""
        q = _hermite(before, after, time)
        if self.system.contact is None or self.system.contact.is_free_way(before.q, q):
            return q
        return before.q + (time - before.time) / (after.time - before.time) * (after.q - before.q)

    def _record(self, state: RunState, step: float, iterations: int) -> StepRecord:
        k = state.kinematics
        return self.record(k.time, step, k.q, k.v, state.balance, state.forces.prescribed, iterations)

    def _checkpoint(self, state: RunState) -> dict[str, np.ndarray]:
        padding = pack_memory("padding", self.stepper.constraint_form.padding)
        memory = pack_memory("contact", self.system.contact) | pack_memory("creases", self.system.creases)
        return state.arrays() | memory | padding

    def finish(self, state: RunState, status: str, failure: Failure | None) -> dict:
        """Hands out what there is and returns the summary."""
        with self.clock.phase("output"):
            self.observer.checkpoint(self._checkpoint(state))
            self.observer.save()
            summary = self._summary(state, status, failure)
        self.observer.finish(summary)
        return summary

    def give_up(self, state: RunState, failure: Failure) -> dict:
        """Returns the summary of a run whose results cannot be written; it goes on from its last checkpoint."""
        summary = self._summary(state, "failed", failure) | {"resumable": True}
        with suppress(OSError):
            self.observer.finish(summary)
        return summary

    def _summary(self, state: RunState, status: str, failure: Failure | None) -> dict:
        summary = summarize(self.system, self.stepper.constraint_form, state.balance, state.counters, status)
        summary |= self.record.spin.summary(state.kinematics.q, state.kinematics.v)
        if failure is not None:
            reached = f"stopped at {state.kinematics.time:.6g} s: {failure.reason}"
            summary |= {"message": reached, "advice": failure.advice}
        return summary


def _in_vain(outcome: StepOutcome, creations: list[float]) -> bool:
    """Whether the last two of the shorter steps (`creations` of those before, W) have not created less energy."""
    return len(creations) >= 2 and outcome.created > LESS_CREATED * creations[-2]


def _crawling(refused: Failure | None) -> Failure:
    """The end of a run that goes on in ever so small steps; `refused`: why the last longer one was not taken."""
    reason = "the local error of longer ones is too large" if refused is None else refused.reason
    advice = "a larger integrator.tolerance" if refused is None else refused.advice
    return Failure(f"the last {LONGEST_CRAWL} steps have led nowhere: {reason}", advice)


def _controller(scene: Scene) -> StepSizeController:
    step, duration = scene.integrator.step, scene.analysis.end
    if step != "auto":
        return FixedStep(float(step))
    return AdaptiveStep(FIRST_STEP_SHARE * duration, SMALLEST_STEP_SHARE * duration, LARGEST_STEP_SHARE * duration)


def _fit(step: float, left: float) -> float:
    """The step, cut to land on the end, or to half of what is left where that avoids a tiny last step."""
    if step >= left * (1.0 - 1e-9):
        return left
    return step if 1.5 * step <= left else 0.5 * left


def _hermite(before: Kinematics, after: Kinematics, time: float) -> np.ndarray:
    """q between two accepted states from q and v at both, fourth order in the step."""
    h = after.time - before.time
    s = (time - before.time) / h
    return (
        before.q * (1.0 + 2.0 * s) * (1.0 - s) ** 2
        + h * before.v * s * (1.0 - s) ** 2
        + after.q * s**2 * (3.0 - 2.0 * s)
        - h * after.v * s**2 * (1.0 - s)
    )
