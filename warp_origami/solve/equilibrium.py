"""Equilibrium of the sheet at one load factor, by Newton on the potential energy.

    grad U(q) + grad U_contact(q) - f(q) = 0   over   C q = d

An unstressed sheet has no stiffness across its plane, and slack parts hardly any. The tangent is therefore made
definite by a vanishing prestress and elastic foundation on the increment,

    (K + c G) dq = -grad,   G = E h int (grad S_i . grad S_j + S_i S_j / L^2) dA,

whose multiple c falls after every good iteration and grows where the tangent is not positive definite. The residual is
that of the sheet alone: where the iteration ends does not depend on G. Steps have the length of the line search of
`newton`.

Where that is slow, ladders of `continuation` lead down from easier problems. Measured (iterations of the first load
step): clamped square 6-9 from 1 Pa to 1e5 Pa, 13 at 1e-8 Pa; square airbag, 8 x 8 cells, 22 at 5 kPa, 48 at 100 Pa, 205
at 1 Pa, where it is all but inextensible; circular pillow 17; a sheet that falls from horizontal into hanging 60; a
sheet bent in its plane, s = 1e-6, 43, and 3 to 15 in later load steps, which begin at the extrapolated state. In
hundreds of iterations or not at all: a force on a single corner of a slack sheet, and stress-free mechanisms whose
slack faces flutter.
"""

from dataclasses import dataclass, replace

import numpy as np

from warp_origami.system import Linearization, System
from warp_origami.terms.external import ExternalForce
from warp_origami.terms.prestress import prestress_stiffness

from .constraint_form import NewtonFactor, make_constraint_form
from .continuation import Rung, load_ladder, ratio_ladder, scaled, together
from .newton import line_search
from .result import Failure

MAXIMUM_ITERATIONS = 150
PATIENCE = 20
"""Iterations after which the energy decrease that the next step promises must lie below 10^(-k / 4) of the energy at
iteration k; where it does not, the stiffness ratios are let fall in decades."""
RUNG_ITERATIONS = 10
RUNG_MULTIPLE = 1e-6
RUNG_TOLERANCE = 1e-6
"""Relative energy decrease at which a decade is solved."""
FIRST_MULTIPLE = 1e-2
SMALLEST_MULTIPLE = 1e-14
"""Below it c is zero: round-off of the tangent of a taut sheet."""
LARGEST_MULTIPLE = 10.0
GOOD_LENGTH = 0.5
"""Shortest step after which c falls."""
POOR_LENGTH = 0.3
"""Longest step after which c grows: the tangent promised what is not there."""
POOR_MULTIPLE = 1e-6

STEP_TOLERANCE = 1e-12
"""Newton step over the size of the sheet that ends the iteration."""
ENERGY_TOLERANCE = 1e-13
"""Decrease of the energy that the next step promises, over the energy, that ends the iteration: where the wrinkling law
switches over a whole region, the energy is flat and steps alone do not tell."""
NO_STRAIN, NO_CHANGE = 1e-7, 1e-10
"""Strain all over the sheet whose energy counts as none, and the one whose energy then ends the iteration where nothing
loads the sheet: stress-free motion has no energy to compare with."""
ROUND_OFF = 1e-15
"""Strain all over the sheet whose energy ends the iteration under any load: the round-off of strains."""
DIFFERENCE = 1e-8
"""Displacement, over the size of the sheet, by which the tangent along prescribed motion is found."""
BALANCED = 1e-9
"""Sum of forces over the sum of their magnitudes that counts as none."""
FARTHEST = 100.0
"""Distance from the start, over the size of the sheet, at which it is taken to fly off."""
OWN_SHARE = 0.5
"""Least share of the sheet's own stiffness in the tangent along a step for its size to be believed."""


@dataclass(frozen=True)
class Equilibrium:
    """Where the iteration ended.

    Attributes:
        q: (n, 3).
        iterations: number of linearizations.
        multiple: c at the end.
        missing: (3n,) what the constraints prescribe, less what `q` has there: zero after the first iteration.
        failure: None if it is an equilibrium.
        hopeless: smaller load steps fail as well.
    """

    q: np.ndarray
    iterations: int
    multiple: float
    missing: np.ndarray
    failure: Failure | None = None
    hopeless: bool = False


@dataclass(frozen=True)
class Start:
    """Where Newton begins.

    Attributes:
        q: (n, 3).
        held: (3n,) what the constraints prescribe now, less what `q` has there: P (d - C q).
    """

    q: np.ndarray
    held: np.ndarray


class EquilibriumSolver:
    """Newton's method for the equilibria of one system.

    Attributes:
        constraint_form: how constraints are held, and the linear solver in use.
    """

    def __init__(self, system: System):
        self.system = system
        material, size = system.scene.material, system.mesh.size
        areal_mass = material.density * material.thickness
        foundation = prestress_stiffness(system.mesh, system.coordinates) + system.mass / (areal_mass * size**2)
        self.metric = (material.youngs_modulus * material.thickness * foundation).tocsr()
        self.constraint_form = make_constraint_form(system, self.metric, least_multiple=1.0)
        self.tolerance = STEP_TOLERANCE * size
        translation = system.translation[:, None]
        along = [system.constraints.equations @ (translation * np.eye(3)[c]).ravel() for c in range(3)]
        self.free_directions = [c for c in range(3) if not np.any(np.abs(along[c]) > BALANCED)]
        area = float(system.mesh.areas.sum())
        stiffness = material.youngs_modulus * material.thickness * area
        self.no_energy, self.no_change, self.round_off = (
            strain**2 * stiffness for strain in (NO_STRAIN, NO_CHANGE, ROUND_OFF)
        )

    def solve(self, start: Start, external: ExternalForce, multiple: float, guess: Start | None = None) -> Equilibrium:
        """Equilibrium near `start`.

        Args:
            external: force at the new load factor.
            multiple: c to begin with.
            guess: where Newton begins; ladders begin at `start`.
        """
        adrift = self._adrift(start.q, external)
        if adrift is not None:
            return Equilibrium(start.q, 0, multiple, start.held, adrift, hopeless=True)
        ladders = self._ladders(start.q, external)
        found = self._iterate(guess or start, external, multiple, patient=not ladders)
        iterations = found.iterations
        for k, ladder in enumerate(ladders, start=1):
            if found.failure is None:
                break
            last = k == len(ladders)
            found = self._climb_down(ladder, start, external, max(multiple, FIRST_MULTIPLE), last)
            iterations += found.iterations
        return replace(found, iterations=iterations)

    def _adrift(self, q: np.ndarray, external: ExternalForce) -> Failure | None:
        """A failure where loads push the whole sheet along a direction in which nothing holds it."""
        forces = self.system.external_force(q, external)[self.system.translation > 0.0]
        total, size = forces.sum(axis=0), np.abs(forces).sum()
        for c in self.free_directions:
            if abs(total[c]) > BALANCED * size:
                reason = f"loads push the sheet along {'xyz'[c]} with {total[c]:.6g} N, and nothing holds it there"
                return Failure(reason, f"a support that fixes {'xyz'[c]} somewhere, or loads in balance")
        return None

    def _climb_down(
        self, ladder: list[Rung], start: Start, external: ExternalForce, multiple: float, patient: bool
    ) -> Equilibrium:
        """Each rung is loosely solved from the last, and then the problem itself."""
        iterations = 0
        try:
            for rung in ladder:
                self.system.membrane.set_stiffness_ratios(rung.s1, rung.s2)
                loads, least = scaled(external, rung.load), max(multiple, RUNG_MULTIPLE)
                found = self._iterate(start, loads, least, True, RUNG_ITERATIONS, RUNG_TOLERANCE)
                start, multiple = Start(found.q, found.missing), found.multiple
                iterations += found.iterations
        finally:
            material = self.system.scene.material
            self.system.membrane.set_stiffness_ratios(material.s1, material.s2)
        last = self._iterate(start, external, multiple, patient)
        return replace(last, iterations=iterations + last.iterations)

    def _ladders(self, start: np.ndarray, external: ExternalForce) -> list[list[Rung]]:
        """Ladders to try one after the other; contact, whose stiffness does not grow with the loads, bears no larger
        ones."""
        material = self.system.scene.material
        forces = self.system.external_force(start, external)[self.system.translation > 0.0]
        stiffness = material.youngs_modulus * material.thickness * self.system.mesh.size
        share = float(np.linalg.norm(forces, axis=1).sum()) / stiffness
        loads = load_ladder(material, share) if self.system.contact is None else []
        ratios = ratio_ladder(material)
        return [ladder for ladder in (loads, together(loads, ratios) if loads else ratios) if ladder]

    def _iterate(
        self,
        start: Start,
        external: ExternalForce,
        multiple: float,
        patient: bool,
        maximum: int = MAXIMUM_ITERATIONS,
        energy_tolerance: float = ENERGY_TOLERANCE,
    ) -> Equilibrium:
        potential = _Potential(self.system, external)
        q, held = start.q.ravel(), start.held
        loaded = bool(np.any(self.system.external_force(start.q, external)))
        for iteration in range(1, maximum + 1):
            linearization = self.system.linearize(q.reshape(-1, 3), external)
            gradient = potential.balance(q, linearization.gradient)
            factor, multiple = self._factorize(linearization, multiple)
            if factor is None:
                return self._failed(q, iteration, multiple, held, "the tangent is not positive definite")
            if np.any(held):  # the first step takes the constraints along
                pull = potential.stiffness_times(q, held) + multiple * self._metric_times(held)
                q = q + held + factor.direction(gradient + pull)
                held = np.zeros_like(held)
                continue
            step = factor.direction(gradient)
            slope = float(gradient @ step)
            if not np.isfinite(slope):
                return self._failed(q, iteration, multiple, held, "the Newton step is not a number")
            energy, decrease = potential.scale(q, linearization.energy), abs(slope)
            least_decrease = max(energy_tolerance * energy, self.round_off)
            if not loaded and energy < self.no_energy:
                least_decrease = self.no_change
            own = 1.0 - multiple * float(step @ self._metric_times(step)) / max(decrease, np.finfo(float).tiny)
            if own >= OWN_SHARE or multiple == 0.0:
                if self.system.displacement(step) < self.tolerance or decrease < least_decrease:
                    return Equilibrium((q + step).reshape(-1, 3), iteration, multiple, held)
            if not patient and iteration > PATIENCE and decrease > 10.0 ** (-iteration / 4) * energy:
                break
            length = line_search(potential, q, step, slope)
            q = q + length * step
            if self.system.displacement(q - start.q.ravel()) > FARTHEST * self.system.mesh.size:
                return self._failed(q, iteration, multiple, held, "the sheet flies off")
            if length >= GOOD_LENGTH:
                multiple = 0.1 * multiple if multiple > 10.0 * SMALLEST_MULTIPLE else 0.0
            elif length < POOR_LENGTH:
                multiple = min(max(10.0 * multiple, POOR_MULTIPLE), FIRST_MULTIPLE)
        return self._failed(q, iteration, multiple, held, f"Newton did not converge in {iteration} iterations")

    def _factorize(self, linearization: Linearization, multiple: float) -> tuple[NewtonFactor | None, float]:
        """Factor of K + c G with the least c from `multiple` on, in decades, for which there is one; and that c."""
        while multiple <= LARGEST_MULTIPLE:
            factor = self.constraint_form.factorize(linearization, multiple, 0.0)
            if factor is not None:
                return factor, multiple
            multiple = max(10.0 * multiple, SMALLEST_MULTIPLE)
        return None, multiple

    def _metric_times(self, step: np.ndarray) -> np.ndarray:
        return (self.metric @ step.reshape(-1, 3)).ravel()

    def _failed(self, q: np.ndarray, iterations: int, multiple: float, missing: np.ndarray, reason: str) -> Equilibrium:
        advice = "more analysis.load_steps, larger material.s1 and s2, or supports that hold what is free to move"
        return Equilibrium(q.reshape(-1, 3), iterations, multiple, missing, Failure(reason, advice))


class _Potential:
    """The potential energy as the line search wants it; q is (3n,)."""

    def __init__(self, system: System, external: ExternalForce):
        self.system, self.external = system, external

    def gradient(self, q: np.ndarray) -> np.ndarray:
        return self.balance(q, self.system.evaluate(q.reshape(-1, 3)).gradient)

    def balance(self, q: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        """(3n,) gradient of the energies less the external force."""
        return (gradient - self.system.external_force(q.reshape(-1, 3), self.external)).ravel()

    def stiffness_times(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """(3n,) tangent times a small part of `step`, as a difference."""
        share = DIFFERENCE * self.system.mesh.size / np.abs(step).max()
        return (self.gradient(q + share * step) - self.gradient(q)) / share

    def scale(self, q: np.ndarray, stored: float) -> float:
        """Energy that changes are compared with, J; `stored` is that of strain and contact at q."""
        moved = q.reshape(-1, 3) - self.system.q0
        work = float(np.sum(np.abs(self.system.external_force(q.reshape(-1, 3), self.external) * moved)))
        return max(stored, work)
