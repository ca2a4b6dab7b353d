"""The energy balance of a run: what went in, what is stored, what was dissipated, what the method created or lost.

    energy_error = kinetic + strain + contact + dissipated - external work - (kinetic + strain + contact at the start)

Work and dissipation are integrated over each step with the mean of the forces at its two ends.
"""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Forces:
    """Generalized forces at one time that do work beside the stored energies.

    Attributes:
        external: (3n,) loads.
        damping: (3n,) damping alpha M v + beta K v, and the resistance of friction.
        prescribed: (m,) forces of the constraint equations on the sheet, conjugate to d(t).
        values: (m,) d(t).
    """

    external: np.ndarray
    damping: np.ndarray
    prescribed: np.ndarray
    values: np.ndarray


@dataclass(frozen=True)
class EnergyBalance:
    """Energies at one time and the extremes of their error so far, all in J."""

    kinetic: float
    strain: float
    contact: float
    dissipated: float = 0.0
    external_work: float = 0.0
    initial: float = 0.0
    largest: float = 0.0
    lowest_error: float = 0.0
    largest_rise: float = 0.0

    @property
    def stored(self) -> float:
        """Kinetic + strain + contact."""
        return self.kinetic + self.strain + self.contact

    @property
    def error(self) -> float:
        """Positive: energy created; negative: lost to algorithmic damping."""
        return self.stored + self.dissipated - self.external_work - self.initial

    @property
    def rise(self) -> float:
        """Present rise of the error above its earlier minimum, J."""
        return self.error - self.lowest_error

    @property
    def gain(self) -> float:
        """Largest rise of the error above its earlier minimum, relative to the largest stored energy."""
        return self.largest_rise / self.largest if self.largest > 0.0 else 0.0

    @property
    def loss(self) -> float:
        """Largest fall of the error below zero, relative to the largest stored energy."""
        return -self.lowest_error / self.largest if self.largest > 0.0 else 0.0

    @classmethod
    def start(cls, kinetic: float, strain: float, contact: float) -> "EnergyBalance":
        """The balance of the initial state."""
        stored = kinetic + strain + contact
        return cls(kinetic, strain, contact, initial=stored, largest=stored)

    def with_impulse(self, kinetic: float) -> "EnergyBalance":
        """The balance after an impulse of the constraints that left this kinetic energy: the gain is external work."""
        work = self.external_work + kinetic - self.kinetic
        new = replace(self, kinetic=kinetic, external_work=work)
        return replace(new, largest=max(self.largest, new.stored))

    def advance(
        self, kinetic: float, strain: float, contact: float, moved: np.ndarray, before: Forces, after: Forces
    ) -> "EnergyBalance":
        """The balance after a step that moved q by `moved` (3n,)."""
        work = 0.5 * float((before.external + after.external) @ moved)
        work += 0.5 * float((before.prescribed + after.prescribed) @ (after.values - before.values))
        dissipated = 0.5 * float((before.damping + after.damping) @ moved)
        new = replace(
            self,
            kinetic=kinetic,
            strain=strain,
            contact=contact,
            dissipated=self.dissipated + dissipated,
            external_work=self.external_work + work,
        )
        return replace(
            new,
            largest=max(self.largest, new.stored),
            lowest_error=min(self.lowest_error, new.error),
            largest_rise=max(self.largest_rise, new.error - self.lowest_error),
        )
