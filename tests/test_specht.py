"""The shape functions are nodal, complete for quadratics, continuous, and their gradients are their derivatives."""

import numpy as np
import pytest

from membrane_cases import distorted_sheet, field_coordinates
from warp_origami.terms.shapes import tabulate


def random_areas(count, seed=0):
    return np.random.default_rng(seed).dirichlet([1.0, 1.0, 1.0], count)


def flat_points(mesh, table):
    return np.einsum("pk,pkd->pd", table.areas, mesh.vertices[mesh.triangles[table.elements]])


@pytest.fixture(scope="module")
def sheet():
    return distorted_sheet()


@pytest.fixture(scope="module")
def table(sheet):
    mesh, _ = sheet
    elements = np.repeat(np.arange(len(mesh.triangles)), 5)
    return tabulate(mesh, elements, random_areas(len(elements)))


def test_nodal_values_and_gradients_are_the_coordinates(sheet):
    mesh, _ = sheet
    elements = np.repeat(np.arange(len(mesh.triangles)), 3)
    nodes = tabulate(mesh, elements, np.tile(np.eye(3), (len(mesh.triangles), 1)))
    at = np.tile(np.arange(3), len(mesh.triangles))
    values, gradients = np.zeros((len(at), 9)), np.zeros((len(at), 9, 2))
    rows = np.arange(len(at))
    values[rows, 3 * at] = 1.0
    gradients[rows, 3 * at + 1, 0] = 1.0
    gradients[rows, 3 * at + 2, 1] = 1.0
    np.testing.assert_allclose(nodes.values, values, atol=1e-15)
    np.testing.assert_allclose(nodes.gradients, gradients, atol=1e-12)


def test_every_quadratic_is_reproduced(sheet, table):
    mesh, coordinates = sheet
    a = np.random.default_rng(1).normal(size=(6, 3))

    def quadratic(x, y):
        one, zero = np.ones_like(x), np.zeros_like(x)
        r = np.stack([one, x, y, x * x, x * y, y * y], axis=1) @ a
        r_x = np.stack([zero, one, zero, 2 * x, y, zero], axis=1) @ a
        r_y = np.stack([zero, zero, one, zero, x, 2 * y], axis=1) @ a
        return r, r_x, r_y

    local = field_coordinates(mesh, coordinates, quadratic)[coordinates.elements[table.elements]]
    r, r_x, r_y = quadratic(*flat_points(mesh, table).T)
    np.testing.assert_allclose(np.einsum("pi,pic->pc", table.values, local), r, atol=1e-13)
    np.testing.assert_allclose(np.einsum("pi,pic->pc", table.gradients[:, :, 0], local), r_x, atol=1e-12)
    np.testing.assert_allclose(np.einsum("pi,pic->pc", table.gradients[:, :, 1], local), r_y, atol=1e-12)


def test_cubics_are_not(sheet, table):
    """The claim is quadratic completeness: a cubic must show an error, or this file tests another element."""
    mesh, coordinates = sheet

    def cubic(x, y):
        zero = np.zeros_like(x)
        r = np.stack([x**2 * y, zero, zero], axis=1)
        return r, np.stack([2 * x * y, zero, zero], axis=1), np.stack([x**2, zero, zero], axis=1)

    local = field_coordinates(mesh, coordinates, cubic)[coordinates.elements[table.elements]]
    r, _, _ = cubic(*flat_points(mesh, table).T)
    assert np.abs(np.einsum("pi,pic->pc", table.values, local) - r).max() > 1e-5


def test_gradients_are_the_derivatives_of_the_values(sheet, table):
    mesh, _ = sheet
    corners = mesh.vertices[mesh.triangles[table.elements]]
    sides = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    slope = np.linalg.inv(sides)  # rows: d(L2, L3) / d(x, y)
    step = 1e-6
    for axis in range(2):
        change = step * np.concatenate([-slope[:, :, axis].sum(axis=1, keepdims=True), slope[:, :, axis]], axis=1)
        plus = tabulate(mesh, table.elements, table.areas + change).values
        minus = tabulate(mesh, table.elements, table.areas - change).values
        np.testing.assert_allclose((plus - minus) / (2 * step), table.gradients[:, :, axis], atol=1e-7)


def test_the_trace_on_an_edge_depends_on_its_two_nodes_only(sheet):
    """Cubic Hermite interpolation along the edge, so that the surface is continuous over creases and smooth edges."""
    mesh, coordinates = sheet
    q = np.random.default_rng(2).normal(size=(coordinates.count, 3))
    t = np.linspace(0.0, 1.0, 7)
    for k in range(3):
        elements = np.repeat(np.arange(len(mesh.triangles)), len(t))
        areas = np.zeros((len(t), 3))
        areas[:, k], areas[:, (k + 1) % 3] = 1.0 - t, t
        edge = tabulate(mesh, elements, np.tile(areas, (len(mesh.triangles), 1)))
        local = q[coordinates.elements]
        found = np.einsum("pi,pic->pc", edge.values, local[elements]).reshape(-1, len(t), 3)

        a, b = 3 * k, 3 * ((k + 1) % 3)
        along = mesh.vertices[mesh.triangles[:, (k + 1) % 3]] - mesh.vertices[mesh.triangles[:, k]]
        slope_a = np.einsum("ed,edc->ec", along, local[:, a + 1 : a + 3])
        slope_b = np.einsum("ed,edc->ec", along, local[:, b + 1 : b + 3])
        hermite = [(1 - t) ** 2 * (1 + 2 * t), t * (1 - t) ** 2, t**2 * (3 - 2 * t), t**2 * (t - 1)]
        nodes = [local[:, a], slope_a, local[:, b], slope_b]
        exact = sum(h[None, :, None] * node[:, None, :] for h, node in zip(hermite, nodes, strict=True))
        np.testing.assert_allclose(found, exact, atol=1e-13)


def test_interpolation_matrix_gives_positions(sheet, table):
    _, coordinates = sheet
    q = np.random.default_rng(4).normal(size=(coordinates.count, 3))
    direct = np.einsum("pi,pic->pc", table.values, q[coordinates.elements[table.elements]])
    np.testing.assert_allclose(table.interpolation(coordinates) @ q, direct, atol=1e-14)
