"""Rows of the tables of results."""

import numpy as np

from warp_origami.system import System
from warp_origami.terms.contact import ContactStatistics

from .energy import EnergyBalance
from .records import StepRecord
from .sampling import Probes, Reactions
from .spin import Spin


class Recorder:
    """Makes the record of an accepted state."""

    def __init__(self, system: System):
        self.system = system
        self.probes, self.reactions, self.spin = Probes(system), Reactions(system), Spin(system)

    def __call__(
        self,
        time: float,
        step: float,
        q: np.ndarray,
        v: np.ndarray,
        balance: EnergyBalance,
        prescribed: np.ndarray,
        iterations: int,
    ) -> StepRecord:
        """The record of a state.

        Args:
            time, step: s, or load factor and its increment.
            q, v: (n, 3).
            balance: energies.
            prescribed: (m,) forces of the constraint equations on the sheet.
            iterations: of Newton, for the step that ended here.
        """
        taut, wrinkled, slack = self.system.membrane.state_fractions(q)
        contacts = self.contacts()
        history = {
            "time": time,
            "step": step,
            "kinetic_energy": balance.kinetic,
            "strain_energy": balance.strain,
            "contact_energy": balance.contact,
            "dissipated": balance.dissipated,
            "external_work": balance.external_work,
            "energy_error": balance.error,
            "newton_iterations": iterations,
            "contacts_sts": contacts.contacts_sts,
            "contacts_nts": contacts.contacts_nts,
            "contacts_edge": contacts.contacts_edge,
            "max_penetration": contacts.max_penetration,
            "taut": taut,
            "wrinkled": wrinkled,
            "slack": slack,
        }
        return StepRecord(history, self.probes(q, v), self.reactions(prescribed, q), self.spin(q, v))

    def contacts(self) -> ContactStatistics:
        """Touching pairs of the last evaluated state."""
        contact = self.system.contact
        return ContactStatistics() if contact is None else contact.statistics()
