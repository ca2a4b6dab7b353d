"""Whether layers passed through each other between two states of a static analysis.

Contact pushes a point back to the side of a layer where it was in the last accepted state, as far as it reaches.
Newton's path to an equilibrium may leave that reach, and end on the other side without a force. The straight path from
state to state is therefore walked in steps shorter than the reach, on which no crossing escapes contact.
"""

import numpy as np

from warp_origami.system import System

from .result import Failure

STRIDE = 0.2
"""Displacement in a step over the reach. Two points approach by twice that, and a point that went more than the
thickness through a layer stays in sight for at least 2/3 of the reach; the rest is for slopes, which add up."""


class Passage:
    """Walks from the accepted state of a system with contact to another one."""

    def __init__(self, system: System):
        self.system = system
        self.thickness = system.scene.contact.thickness

    def crossed(self, before: np.ndarray, after: np.ndarray) -> Failure | None:
        """A failure if a point goes through a layer by more than the thickness.

        Args:
            before: (n, 3) the accepted state.
            after: (n, 3) the state that might be accepted; contact has seen it last when there is no failure.
        """
        contact = self.system.contact
        steps = max(int(np.ceil(self._motion(after - before) / (STRIDE * contact.reach))), 1)
        for k in range(1, steps + 1):
            with self.system.clock.phase("contact"):
                contact.gradient(before + k / steps * (after - before) if k < steps else after)
            depth = contact.statistics().max_penetration
            if depth > self.thickness:
                return Failure(
                    f"layers are pressed through each other, by {depth:.3g} m at a thickness of {self.thickness:.3g} m",
                    "a larger contact stiffness, or smaller loads and driven motion",
                )
        return None

    def _motion(self, moved: np.ndarray) -> float:
        """Largest displacement (m), less that of the sheet as a whole, which brings nothing together."""
        positions = self.system.coordinates.positions
        at = moved[positions[positions >= 0]]
        relative = moved.copy()
        relative[positions[positions >= 0]] -= 0.5 * (at.min(axis=0) + at.max(axis=0))
        return self.system.displacement(relative)
