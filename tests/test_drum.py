"""Prestressed square: f_mn = sqrt(S / rho) sqrt(m^2 + n^2) / (2 a), exact at any stretch."""

import numpy as np
import pytest
from scipy.linalg import eigh

from membrane_cases import Film, field_coordinates, linear_field, square_mesh
from warp_origami.model.coordinates import number_coordinates
from warp_origami.terms.inertia import mass_matrix
from warp_origami.terms.membrane import Membrane

SIDE, STRESS, DENSITY = 0.6, 1e6, 1420.0
F11 = np.sqrt(STRESS / DENSITY) * np.sqrt(2) / (2 * SIDE)
PAIRS = np.triu_indices(9)


def transverse_stiffness(coordinates, blocks):
    """The z-z part of the tangent, (n, n)."""
    full = np.zeros((coordinates.count, coordinates.count))
    for rows, own in zip(coordinates.elements, blocks[:, :, 2, 2], strict=True):
        local = np.zeros((9, 9))
        local[PAIRS] = own
        full[np.ix_(rows, rows)] += local + np.triu(local, 1).T
    return full


def free_rows(mesh, coordinates):
    """Rows of q whose z is free: z is held on the rim, and so is the slope along it."""
    on_x = np.isclose(mesh.vertices[:, 0] % SIDE, 0) | np.isclose(mesh.vertices[:, 0], SIDE)  # edges along y
    on_y = np.isclose(mesh.vertices[:, 1] % SIDE, 0) | np.isclose(mesh.vertices[:, 1], SIDE)
    free = np.ones(coordinates.count, dtype=bool)
    free[coordinates.positions[on_x | on_y]] = False
    free[coordinates.sector_gradients[on_y[coordinates.sector_vertices]]] = False
    free[coordinates.sector_gradients[on_x[coordinates.sector_vertices]] + 1] = False
    return np.flatnonzero(free)


def lowest_frequency(n):
    film = Film(model="linear")
    mesh = square_mesh(n, SIDE)
    coordinates = number_coordinates(mesh)
    stretch = np.sqrt(1 + 2 * STRESS * (1 - film.poisson_ratio) / film.youngs_modulus)
    q = field_coordinates(mesh, coordinates, linear_field(stretch * np.eye(3)[:, :2]))
    _, _, blocks = Membrane(mesh, coordinates, film).tangent(q)
    free = free_rows(mesh, coordinates)
    stiffness = transverse_stiffness(coordinates, blocks)[np.ix_(free, free)]
    mass = mass_matrix(mesh, coordinates, DENSITY, film.thickness).toarray()[np.ix_(free, free)]
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True)[0]) / (2 * np.pi)


@pytest.mark.parametrize(("n", "expected"), [(2, 5.4e-3), (4, 2.3e-4), (8, 1.3e-5)])
def test_first_frequency_has_the_known_error_of_order_four(n, expected):
    error = lowest_frequency(n) / F11 - 1
    assert abs(error) == pytest.approx(expected, rel=0.05)
