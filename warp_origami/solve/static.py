"""Static analysis: load steps from the initial state to the load factor 1, each ended by an equilibrium.

The increment of the load factor is at most 1 / load_steps, is halved where no equilibrium is found or layers passed
through each other on the way to it, and doubled again after steps that succeed.
"""

from contextlib import suppress
from dataclasses import dataclass, fields, replace

import numpy as np

from warp_origami.system import System

from .energy import EnergyBalance, Forces
from .equilibrium import FIRST_MULTIPLE, PATIENCE, Equilibrium, EquilibriumSolver, Start
from .modal import Modes, ModeShapes
from .packing import pack, pack_memory, restore_memory, unpack
from .passage import passage
from .recording import Recorder
from .records import Observer
from .result import Failure
from .sampling import Surface
from .stability import remarks
from .summary import Counters, summarize

SMALLEST_SHARE = 1e-2
"""Smallest increment over the first."""
DRIVEN_SHARE = 0.1
"""Driven motion in the smallest increment, where there is contact, over the reach of contact."""
SAMPLES = 200
"""Load factors at which the speed of driven motion is looked for."""
UNHELD = 1e-9
"""Largest error of the constraints at an equilibrium, over the size of the sheet."""

KEPT_MULTIPLE = 1e-6
"""Least multiple of the regularization at the start of a load step: the next one finds it if it needs more."""


@dataclass(frozen=True)
class StaticState:
    """All that changes during a run.

    Attributes:
        factor: load factor.
        q: (n, 3) equilibrium; at load factor 0 the initial state, in equilibrium or not.
        earlier, earlier_factor: the state before it.
        easy: whether Newton alone finds the equilibria, beginning at the last one.
        increment: of the load factor, to try next.
        multiple: of the regularization, to begin with.
        forces, balance: for the energy balance.
        counters: numbers for the summary.
    """

    factor: float
    q: np.ndarray
    earlier: np.ndarray
    earlier_factor: float
    easy: bool
    increment: float
    multiple: float
    forces: Forces
    balance: EnergyBalance
    counters: Counters


class StaticRun:
    """What stays the same during a run, and the loop over load steps.

    With `modes`, frames show the mode shapes about the last equilibrium, else the equilibria.
    """

    def __init__(self, system: System, observer: Observer, until: float, modes: Modes | None = None):
        self.system, self.observer, self.until, self.modes = system, observer, until, modes
        self.clock = system.clock
        with self.clock.phase("setup"):
            self.record, self.surface = Recorder(system), Surface(system)
            self.solver = EquilibriumSolver(system)
        self.largest = 1.0 / system.scene.analysis.load_steps
        self.smallest = SMALLEST_SHARE * self.largest
        if system.contact is not None:
            speed = self._driven_speed()
            self.smallest = min(self.smallest, DRIVEN_SHARE * system.contact.reach / speed if speed else np.inf)

    def start(self) -> StaticState:
        """The initial state, with its first row and frame written."""
        system = self.system
        self.observer.start(system.scene, self.surface.submesh, None)
        system.accept(system.q0)
        stored = system.evaluate(system.q0)
        balance = EnergyBalance.start(0.0, stored.strain_energy, stored.contact_energy)
        forces = self._forces(0.0, system.q0, stored.gradient)
        state = StaticState(
            factor=0.0,
            q=system.q0,
            earlier=system.q0,
            earlier_factor=0.0,
            easy=True,
            increment=self.largest,
            multiple=FIRST_MULTIPLE,
            forces=forces,
            balance=balance,
            counters=Counters(),
        )
        self._write(state, 0.0, 0)
        return state

    def resume(self, arrays: dict[str, np.ndarray]) -> StaticState:
        """The state of a checkpoint.

        Raises:
            InputError: it is not one of this version.
        """
        state = StaticState(**unpack(arrays, {field.name: field.type for field in fields(StaticState)}))
        restore_memory("contact", self.system.contact, arrays)
        restore_memory("creases", self.system.creases, arrays)
        restore_memory("padding", self.solver.constraint_form.padding, arrays)
        self.observer.start(self.system.scene, self.surface.submesh, state.factor)
        return state

    def at_end(self, state: StaticState) -> bool:
        """Whether the end is reached."""
        return state.factor >= self.until

    def advance(self, state: StaticState) -> tuple[StaticState, Failure | None]:
        """The state after the next load step, which is retried with smaller ones as often as needed."""
        increment, counters = state.increment, state.counters
        while True:
            factor = state.factor + increment
            if factor > self.until - 1e-3 * increment:
                factor = self.until
            found = self._solve(state, factor)
            counters = counters.iterated(found.iterations)
            failure = found.failure or self._refused(state.q, found.q, factor)
            if failure is None:
                break
            counters = counters.rejected()
            increment *= 0.5
            if found.hopeless or increment < self.smallest:
                return replace(state, counters=counters), failure
        self.system.accept(found.q)
        state = replace(state, counters=counters.accepted(self.record.contacts().max_penetration))
        after = self._after(state, found, factor, min(2.0 * increment, self.largest))
        self._write(after, factor - state.factor, found.iterations)
        return after, None

    def _refused(self, before: np.ndarray, after: np.ndarray, factor: float) -> Failure | None:
        """Why an equilibrium found from the last one is not taken."""
        constraints = self.system.constraints
        error = np.abs(constraints.equations @ after.ravel() - constraints.values(factor)).max(initial=0.0)
        if error > UNHELD * self.system.mesh.size:
            return Failure(f"the constraints are violated by {error:.3g} m", "more analysis.load_steps")
        return passage(self.system, before, after)

    def _driven_speed(self) -> float:
        """Largest displacement that constraints prescribe per load factor, m."""
        values = np.array([self.system.constraints.values(factor) for factor in np.linspace(0.0, 1.0, SAMPLES + 1)])
        return SAMPLES * float(np.abs(np.diff(values, axis=0)).max(initial=0.0))

    def _solve(self, state: StaticState, factor: float) -> Equilibrium:
        guess = None
        if not state.easy and state.earlier_factor > 0.0:
            ratio = (factor - state.factor) / (state.factor - state.earlier_factor)
            guess = self._begin(state.q + ratio * (state.q - state.earlier), factor)
        start, external = self._begin(state.q, factor), self.system.external.at(factor)
        return self.solver.solve(start, external, state.multiple, guess)

    def _begin(self, q: np.ndarray, factor: float) -> Start:
        """Newton's start at q, (n, 3)."""
        c = self.system.constraints
        missing = c.values(factor) - c.equations @ q.ravel()
        missing[np.abs(missing) < np.finfo(float).eps * self.system.mesh.size] = 0.0
        return Start(q, c.right_inverse @ missing)

    def _after(self, before: StaticState, found: Equilibrium, factor: float, increment: float) -> StaticState:
        """The state at a new equilibrium."""
        stored = self.system.evaluate(found.q)
        forces = self._forces(factor, found.q, stored.gradient)
        moved = (found.q - before.q).ravel()
        return replace(
            before,
            factor=factor,
            q=found.q,
            earlier=before.q,
            earlier_factor=before.factor,
            easy=found.iterations <= PATIENCE and (before.easy or before.earlier_factor == 0.0),
            increment=increment,
            multiple=max(found.multiple, KEPT_MULTIPLE),
            forces=forces,
            balance=before.balance.advance(
                0.0, stored.strain_energy, stored.contact_energy, moved, before.forces, forces
            ),
        )

    def _forces(self, factor: float, q: np.ndarray, gradient: np.ndarray) -> Forces:
        external = self.system.external_force(q, self.system.external.at(factor))
        constraints = self.system.constraints
        prescribed = constraints.right_inverse.T @ (gradient - external).ravel()
        return Forces(external.ravel(), np.zeros(external.size), prescribed, constraints.values(factor))

    def _write(self, state: StaticState, step: float, iterations: int) -> None:
        with self.clock.phase("output"):
            still = np.zeros_like(state.q)
            prescribed = state.forces.prescribed
            self.observer.step(self.record(state.factor, step, state.q, still, state.balance, prescribed, iterations))
            if self.modes is None:
                self.observer.frame(self.surface.frame(state.factor, state.q))
            self.observer.checkpoint(self._checkpoint(state))

    def _checkpoint(self, state: StaticState) -> dict[str, np.ndarray]:
        padding = pack_memory("padding", self.solver.constraint_form.padding)
        memory = pack_memory("contact", self.system.contact) | pack_memory("creases", self.system.creases)
        return pack(vars(state)) | memory | padding

    def finish(self, state: StaticState, status: str, failure: Failure | None) -> dict:
        """Hands out what there is and returns the summary."""
        results = {}
        if status == "done":
            results = self._modes(state) if self.modes is not None else self._remarks(state)
            if isinstance(results, Failure):
                status, failure, results = "failed", results, {}
        with self.clock.phase("output"):
            self.observer.checkpoint(self._checkpoint(state))
            self.observer.save()
            summary = self._summary(state, status, failure) | results
        self.observer.finish(summary)
        return summary

    def give_up(self, state: StaticState, failure: Failure) -> dict:
        """Returns the summary of a run whose results cannot be written; it goes on from its last checkpoint."""
        summary = self._summary(state, "failed", failure) | {"resumable": True}
        with suppress(OSError):
            self.observer.finish(summary)
        return summary

    def _summary(self, state: StaticState, status: str, failure: Failure | None) -> dict:
        form = self.solver.constraint_form
        balance = replace(state.balance, largest=max(state.balance.largest, self.solver.no_energy))
        summary = summarize(self.system, form, balance, state.counters, status)
        if failure is not None:
            reached = f"stopped at load factor {state.factor:.6g}: {failure.reason}"
            summary |= {"message": reached, "advice": failure.advice}
        return summary

    def _modes(self, state: StaticState) -> dict | Failure:
        """What modes add to the summary."""
        if self.until < self.system.scene.analysis.end:
            return {"message": f"no modes before load factor {self.system.scene.analysis.end:g}"}
        found = self.modes.find(state.q, self.system.external.at(state.factor))
        if isinstance(found, Failure):
            return found
        self._draw(found, state.q)
        return {"frequencies": found.frequencies.tolist()} | ({"message": found.remark} if found.remark else {})

    def _remarks(self, state: StaticState) -> dict:
        """What the user should know of the equilibrium."""
        found = remarks(self.system, state.q, self.system.external.at(state.factor))
        return {"message": "; ".join(found)} if found else {}

    def _draw(self, modes: ModeShapes, q: np.ndarray) -> None:
        with self.clock.phase("output"):
            for time, state in modes.motion(q, self.system):
                self.observer.frame(self.surface.frame(time, state))
