"""What a user should know of a static solution that was found: whether it is stable, and whether loads were felt.

An equilibrium is stable if the potential energy has a minimum there: the symmetric tangent, reduced by the constraints,
has no negative eigenvalue. Their number is that of the negative pivots of its LDL^T (Sylvester).
"""

import numpy as np

from warp_origami.system import System
from warp_origami.terms.external import ExternalForce

from .linear import negative_pivots
from .modal import RESOLUTION
from .reduced_tangent import ReducedTangent

SHIFTS = (1.0, 3.0, 10.0)
"""Several, for a pivot may vanish by chance."""


def remarks(system: System, q: np.ndarray, external: ExternalForce) -> list[str]:
    """Sentences about the equilibrium q (n, 3); none if there is nothing to say."""
    found = []
    positions = system.coordinates.positions
    forces = system.external_force(q, external)
    free = (system.constraints.null_space.T @ forces.ravel()).any()
    total = float(np.linalg.norm(forces[positions[positions >= 0]], axis=1).sum())
    material = system.scene.material
    smallest = np.finfo(float).eps * material.youngs_modulus * material.thickness * system.mesh.size
    if free and 0.0 < total < smallest:
        found.append(
            f"the loads, {total:.3g} N in all, lie below the round-off of the forces in the sheet, {smallest:.3g} N: "
            "the solution does not resolve them"
        )
    count, symmetric = _negative_eigenvalues(system, q, external)
    if count and symmetric:
        found.append(f"the equilibrium is unstable: its tangent has negative eigenvalues, {count} of them")
    elif count:
        found.append(
            f"the equilibrium may be unstable: the symmetric part of its tangent has negative eigenvalues, {count} of "
            "them (follower pressure or sunlight acts on a free edge, where it has no potential)"
        )
    return found


def _negative_eigenvalues(system: System, q: np.ndarray, external: ExternalForce) -> tuple[int, bool]:
    """How many the symmetric part of the reduced tangent has below its round-off, and whether that part is all.

    Round-off is that of modal analysis: of the largest eigenvalue with respect to the mass. None are reported where the
    tangent has no LDL^T.
    """
    null_space = system.constraints.null_space
    if null_space.shape[1] == 0:
        return 0, True
    linearization = system.linearize(q, external)
    with system.clock.phase("assembly"):
        tangent = ReducedTangent(system, null_space, system.mass)
        stiffness = tangent.symmetric(linearization, 0.0, 0.0).full()
        symmetric = tangent.skew(linearization, np.abs(stiffness.data).max(initial=0.0)) is None
        mass = tangent.sparsity.matrix(tangent.metric_values)
    resolution = RESOLUTION * float(np.max(np.abs(stiffness.diagonal()) / mass.diagonal()))
    with system.clock.phase("factorization"):
        for shift in SHIFTS:
            count = negative_pivots((stiffness + shift * resolution * mass).tocsc())
            if count is not None:
                return count, symmetric
    return 0, symmetric
