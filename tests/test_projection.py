"""Closest point projection on the cubic surface, and how sub-triangles approximate it."""

import numpy as np
import pytest

from contact_meshes import mesh_of
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.contact.projection import project
from warp_origami.terms.shapes import tabulate


def bent():
    """One bent triangle and points around it."""
    mesh = mesh_of([[0.0, 0.0], [0.11, 0.01], [0.03, 0.09]], [[0, 1, 2]])
    coordinates = number_coordinates(mesh)
    q = affine_coordinates(mesh, coordinates, np.pad(mesh.vertices, ((0, 0), (0, 1))))
    rng = np.random.default_rng(3)
    q += 0.15 * rng.normal(size=q.shape) * (~np.isin(np.arange(coordinates.count), coordinates.positions))[:, None]
    points = np.column_stack([rng.uniform(-0.01, 0.1, (60, 2)), rng.uniform(-0.01, 0.01, 60)])
    return mesh, coordinates, q, points


def surface(mesh, coordinates, q, areas):
    """Positions and derivatives at area coordinates of element 0."""
    table = tabulate(mesh, np.zeros(len(areas), dtype=int), areas)
    local = q[coordinates.elements[0]]
    return table.values @ local, np.einsum("pik,ic->pkc", table.gradients, local)


def test_orthogonality_inside_and_one_sided_conditions_on_the_boundary():
    """(29) inside; on a side the residual points outwards: no admissible direction shortens the distance."""
    mesh, coordinates, q, points = bent()
    found = project(mesh, coordinates, q, points, np.zeros(len(points), dtype=int))
    r, tangents = surface(mesh, coordinates, q, found.areas)
    np.testing.assert_allclose(r, found.positions, atol=1e-15)
    slope = np.einsum("pkc,pc->pk", tangents, points - r)
    inside = found.areas.min(axis=1) > 1e-9
    assert 10 < inside.sum() < 50
    assert np.abs(slope[inside]).max() < 1e-11
    for corner in mesh.vertices[mesh.triangles[0]]:
        towards = corner - found.areas @ mesh.vertices[mesh.triangles[0]]
        assert np.einsum("pk,pk->p", slope, towards).max() < 1e-11


def test_nothing_on_the_element_is_closer():
    mesh, coordinates, q, points = bent()
    found = project(mesh, coordinates, q, points, np.zeros(len(points), dtype=int))
    fine = build_submesh(mesh, 60)
    samples = tabulate(mesh, fine.elements, fine.areas).interpolation(coordinates) @ q
    nearest = np.linalg.norm(points[:, None] - samples[None], axis=2).min(axis=1)
    assert np.all(found.distances <= nearest + 1e-12)
    assert np.all(found.distances >= nearest - 2e-3)


def closest_of_triangles(points, corners):
    """Distance of points (n, 3) from the nearest of triangles (t, 3, 3), by projection on planes, sides and corners."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    offset = np.einsum("ptc,tc->pt", points[:, None] - a, normal)
    foot = points[:, None] - offset[..., None] * normal
    inside = np.ones(offset.shape, dtype=bool)
    distance = np.full(offset.shape, np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ptc,tc->pt", foot - u, np.cross(normal, v - u)) >= 0
        s = np.clip(np.einsum("ptc,tc->pt", points[:, None] - u, v - u) / np.sum((v - u) ** 2, axis=1), 0, 1)
        side = np.linalg.norm(points[:, None] - u - s[..., None] * (v - u), axis=2)
        distance = np.minimum(distance, side)
    return np.where(inside, np.abs(offset), distance).min(axis=1)


def test_sub_triangles_converge_with_the_square_of_the_subdivision():
    mesh, coordinates, q, points = bent()
    exact = project(mesh, coordinates, q, points, np.zeros(len(points), dtype=int)).distances
    errors = []
    for k in (2, 4, 8, 16, 32):
        sub = build_submesh(mesh, k)
        nodes = tabulate(mesh, sub.elements, sub.areas).interpolation(coordinates) @ q
        errors.append(np.abs(closest_of_triangles(points, nodes[sub.triangles]) - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders[-2:] == pytest.approx([2.0, 2.0], abs=0.3), (errors, orders)
