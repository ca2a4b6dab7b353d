"""Spin: angular momentum and moment of inertia of everything, and the rate at which the hub turns.

With the constant mass matrix M of sheet, added masses and hub, and x = sum_i S_i q_i,

    L = int rho (x - x_0) x x' = sum_ij M_ij q_i x v_j - (terms of x_0),   I = int rho |a x (x - x_0)|^2

about the axis a through x_0: the hub's centre where its axis is held, else the centre of mass.
"""

import numpy as np

from warp_origami.system import System

from .records import SPIN_COLUMNS

LEAST_SPIN = 1e-6
"""Angular momentum at the start over that at the end, below which it is round-off."""


class Spin:
    """Reads spin off the state of a system that has a hub or starts with a spin; empty for any other."""

    def __init__(self, system: System):
        self.system = system
        spins = [load for load in system.scene.load if load.kind == "initial_spin"]
        self.axis = None
        if system.hub is not None:
            self.axis = system.hub.frame[2]
        elif spins:
            self.axis = np.asarray(spins[0].axis, dtype=float) / np.linalg.norm(spins[0].axis)
        self.held = system.hub is not None and system.scene.hub.mount != "free"
        self.unit = system.translation
        self.moved = system.mass @ self.unit

    def __call__(self, q: np.ndarray, v: np.ndarray) -> dict[str, float]:
        """SPIN_COLUMNS -> values at q, v (n, 3)."""
        if self.axis is None:
            return {}
        total = float(self.unit @ self.moved)
        centre = self.system.hub.centre if self.held else self.moved @ q / total
        drift = np.zeros(3) if self.held else self.moved @ v / total
        x, w = q - np.outer(self.unit, centre), v - np.outer(self.unit, drift)
        momentum = np.cross(x, self.system.mass @ w).sum(axis=0)
        arm = np.cross(self.axis, x)
        inertia = float(np.sum(arm * (self.system.mass @ arm)))
        if self.system.rigid_hub is None:
            rate = float(momentum @ self.axis) / inertia
        else:
            rate = float(self.system.rigid_hub.rate(q, v) @ self.axis)
        return dict(zip(SPIN_COLUMNS, [rate, inertia, *momentum.tolist()], strict=True))

    def summary(self, q: np.ndarray, v: np.ndarray) -> dict[str, object]:
        """What the summary says at the end; `angular_momentum_change` is relative, about the axis, and there only if
        the motion starts with a spin that nothing drives."""
        if self.axis is None:
            return {}
        first, last = (self._momentum(*state) for state in ((self.system.q0, self.system.v0), (q, v)))
        found = {"angular_momentum_initial": first.tolist(), "angular_momentum": last.tolist()}
        size = float(np.linalg.norm(first))
        driven = self.system.hub is not None and self.system.scene.hub.mount == "driven"
        if not driven and size > LEAST_SPIN * float(np.linalg.norm(last)):
            found["angular_momentum_change"] = float((last - first) @ self.axis) / size
        return found

    def _momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.array(list(self(q, v).values())[2:])
