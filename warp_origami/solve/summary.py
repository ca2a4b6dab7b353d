"""The numbers of a run: counters on the way, summary at the end."""

import sys
from dataclasses import dataclass, replace

import psutil

from warp_origami.system import System

from .energy import EnergyBalance

if sys.platform != "win32":
    import resource


@dataclass(frozen=True)
class Counters:
    """What a run has done so far; `max_penetration` in m."""

    steps_accepted: int = 0
    steps_rejected: int = 0
    newton_iterations: int = 0
    linear_solves: int = 0
    max_penetration: float = 0.0

    def tried(self, outcome) -> "Counters":
        """After a tried step of the integrator."""
        return replace(
            self,
            newton_iterations=self.newton_iterations + outcome.iterations,
            linear_solves=self.linear_solves + outcome.solves,
        )

    def iterated(self, iterations: int) -> "Counters":
        """After iterations of Newton, one solve each."""
        return replace(
            self,
            newton_iterations=self.newton_iterations + iterations,
            linear_solves=self.linear_solves + iterations,
        )

    def rejected(self) -> "Counters":
        """After a rejected step."""
        return replace(self, steps_rejected=self.steps_rejected + 1)

    def accepted(self, penetration: float) -> "Counters":
        """After an accepted step with this largest penetration (m)."""
        return replace(
            self,
            steps_accepted=self.steps_accepted + 1,
            max_penetration=max(self.max_penetration, penetration),
        )


def summarize(system: System, constraint_form, balance: EnergyBalance, counters: Counters, status: str) -> dict:
    """Content of summary.json."""
    constraints = system.constraints
    return {
        "status": status,
        "scene": system.scene.name,
        "device": system.device,
        "precision": "float64",
        "elements": len(system.mesh.triangles),
        "dofs": constraints.null_space.shape[1],
        "constraints": len(constraints.sources),
        "mass": system.total_mass,
        "constraint_form": constraint_form.name,
        "linear_solver": constraint_form.solver.name,
        "terms": system.terms,
        "kernel_modules": [*system.kernel_modules, *constraint_form.solver.kernel_modules],
        "steps_accepted": counters.steps_accepted,
        "steps_rejected": counters.steps_rejected,
        "newton_iterations": counters.newton_iterations,
        "linear_solves": counters.linear_solves,
        "wall_seconds": system.clock.total(),
        "phases": dict(system.clock.seconds),
        "peak_memory_bytes": peak_memory(),
        "max_penetration": counters.max_penetration,
        **_contact_numbers(system),
        "energy_gain": balance.gain,
        "energy_loss": balance.loss,
    }


def _contact_numbers(system: System) -> dict[str, float]:
    """The penalties in use and, where one stood as "auto", the speed it is for; nothing without contact."""
    settings = system.contact_settings
    if settings is None:
        return {}
    given = system.scene.contact
    keys = ["sts_stiffness", "nts_stiffness"]
    if "auto" in (given.sts_stiffness, given.nts_stiffness):
        keys.append("expected_speed")
    return {key: getattr(settings, key) for key in keys}


def peak_memory() -> int:
    """Largest resident memory of this process so far, bytes."""
    if sys.platform == "win32":
        return psutil.Process().memory_info().peak_wset
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
