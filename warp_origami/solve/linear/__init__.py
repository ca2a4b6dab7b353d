"""Direct solvers for the Newton systems behind one interface."""

from .choice import choose_solver
from .inertia import negative_pivots
from .interface import Factor, Kind, LinearSolver

__all__ = ["Factor", "Kind", "LinearSolver", "choose_solver", "negative_pivots"]
