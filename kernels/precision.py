"""The one place of the scalar type.

Warp does not mix precisions: a Python literal in a kernel is float32, and ``real(1.0 / 3.0)`` rounds to float32 before
it is converted. Constants that are not exact in binary are therefore made here, outside kernels.
"""

import warp as wp

real = wp.float64

vec2 = wp.types.vector(length=2, dtype=real)
vec3 = wp.types.vector(length=3, dtype=real)
vec4 = wp.types.vector(length=4, dtype=real)
vec9 = wp.types.vector(length=9, dtype=real)
mat22 = wp.types.matrix(shape=(2, 2), dtype=real)
mat33 = wp.types.matrix(shape=(3, 3), dtype=real)
