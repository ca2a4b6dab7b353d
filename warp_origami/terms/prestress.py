"""Geometric stiffness of a uniform prestress, alike in all directions: int grad S_i . grad S_j dA."""

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import Mesh

from .quadrature import rule
from .shapes import tabulate

EXACT_DEGREE = 6
"""Degree of a product of two gradients of shape functions."""


def prestress_stiffness(mesh: Mesh, coordinates: Coordinates) -> csr_matrix:
    """(n, n) stiffness against x, y and z alike of a stress resultant of 1 N/m; rows of positions in N/m."""
    areas, weights = rule(EXACT_DEGREE)
    count = len(mesh.triangles)
    table = tabulate(mesh, np.repeat(np.arange(count), len(areas)), np.tile(areas, (count, 1)))
    gradients = table.gradients.reshape(count, len(areas), 9, 2)
    blocks = np.einsum("e,p,epic,epjc->eij", mesh.areas, weights, gradients, gradients, optimize=True)
    return coordinates.assemble(blocks)
