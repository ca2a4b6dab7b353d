"""The mass matrix is exact: total mass, moments, and every product of shape functions."""

import numpy as np
import pytest

from membrane_cases import distorted_sheet, field_coordinates, linear_field
from warp_origami.model.coordinates import number_coordinates
from warp_origami.model.mesh import build_mesh
from warp_origami.terms.inertia import mass_matrix
from warp_origami.terms.shapes import tabulate

DENSITY, THICKNESS, SIDE = 1420.0, 5e-4, 0.6


@pytest.fixture(scope="module")
def sheet():
    mesh, coordinates = distorted_sheet(crease=1)
    return mesh, coordinates, mass_matrix(mesh, coordinates, DENSITY, THICKNESS)


def test_total_mass_first_and_second_moments(sheet):
    """Exact for a square: m, m l/2, m l^2/3 and m l^2/4, with sectors of a crease in between."""
    mesh, coordinates, mass = sheet
    total = DENSITY * THICKNESS * SIDE**2
    one = field_coordinates(mesh, coordinates, linear_field(np.zeros((3, 2)), (1.0, 0.0, 0.0)))[:, 0]
    flat = field_coordinates(mesh, coordinates, linear_field([[1, 0], [0, 1], [0, 0]]))
    x, y = flat[:, 0], flat[:, 1]
    np.testing.assert_allclose(one @ mass @ one, total, rtol=1e-14)
    np.testing.assert_allclose(one @ mass @ x, total * SIDE / 2, rtol=1e-13)
    np.testing.assert_allclose(x @ mass @ x, total * SIDE**2 / 3, rtol=1e-13)
    np.testing.assert_allclose(x @ mass @ y, total * SIDE**2 / 4, rtol=1e-13)


def test_kinetic_energy_of_a_quadratic_velocity(sheet):
    """Velocity x^2 - 2 x y on a square: the integral of its square is l^6 (1/5 - 4/8 + 4/9)."""
    mesh, coordinates, mass = sheet

    def velocity(x, y):
        zero = np.zeros_like(x)
        values = (x * x - 2 * x * y, 2 * x - 2 * y, -2 * x)
        return tuple(np.stack([v, zero, zero], axis=1) for v in values)

    v = field_coordinates(mesh, coordinates, velocity)[:, 0]
    exact = DENSITY * THICKNESS * SIDE**6 * (1 / 5 - 4 / 8 + 4 / 9)
    np.testing.assert_allclose(v @ mass @ v, exact, rtol=1e-13)


def test_element_block_is_integrated_exactly():
    """Against Gauss-Legendre on the collapsed square, exact to degree 18."""
    mesh = build_mesh(np.array([[0.0, 0.0], [0.31, 0.02], [0.11, 0.24]]), np.array([[0, 1, 2]]))
    coordinates = number_coordinates(mesh)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    u, v = (a.ravel() for a in np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2))
    w = np.outer(weights, weights).ravel() / 4 * (1 - u) * 2  # sums to 1 over the triangle
    table = tabulate(mesh, np.zeros(len(u), dtype=int), np.stack([u, (1 - u) * v, (1 - u) * (1 - v)], axis=1))
    exact = DENSITY * THICKNESS * mesh.areas[0] * np.einsum("p,pi,pj->ij", w, table.values, table.values)
    block = mass_matrix(mesh, coordinates, DENSITY, THICKNESS)[coordinates.elements[0]][:, coordinates.elements[0]]
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert np.abs((block.toarray() - exact) / scale).max() < 1e-13


def test_symmetric_and_positive_definite(sheet):
    _, _, mass = sheet
    dense = mass.toarray()
    scale = np.sqrt(np.diag(dense))
    scaled = dense / np.outer(scale, scale)
    assert np.abs(scaled - scaled.T).max() < 1e-15
    assert np.linalg.eigvalsh(scaled).min() > 1e-3
