"""Time integration and its parts: Newton, linear solvers, step size control, the loop that owns the state."""
