"""The terms of the equations of motion: the only launches of kernels."""
