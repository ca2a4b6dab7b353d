"""The broad phase finds exactly the points and sub-triangles that are near each other."""

import numpy as np
import pytest
import warp as wp
from warp_origami.kernels.precision import vec3

from contact_cases import TwoSheets, settings
from contact_meshes import grid, mesh_of
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.contact import Contact
from warp_origami.terms.contact.points import build_points
from warp_origami.terms.contact.search import Search


def graded(seed):
    """A crumpled sheet of two faces whose elements grow from 1 mm to 0.3 m."""
    vertices, triangles = grid(12, 3)
    x = vertices[:, 0] + 0.5
    vertices[:, 0] = 0.003 * (300.0**x - 1.0) / 1.0
    mesh = mesh_of(vertices, triangles, lambda m: np.abs(m[:, 1] - 1 / 6) < 1e-9)
    coordinates = number_coordinates(mesh)
    submesh = build_submesh(mesh, 2)
    points = build_points(mesh, coordinates, submesh, "mixed", 2)
    rng = np.random.default_rng(seed)
    q = affine_coordinates(mesh, coordinates, rng.normal(size=(len(vertices), 3)) * [0.3, 0.3, 0.02])
    return submesh, points, points.interpolation @ q


def distances(x, corners):
    """Distance of points (n, 3) from triangles (t, 3, 3), (n, t), by brute force on the edges and the plane."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    offset = np.einsum("ntc,tc->nt", x[:, None] - a, normal)
    foot = x[:, None] - offset[..., None] * normal
    inside = np.ones(offset.shape, dtype=bool)
    result = np.full(offset.shape, np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ntc,tc->nt", foot - u, np.cross(normal, v - u)) >= 0
        s = np.clip(np.einsum("ntc,tc->nt", x[:, None] - u, v - u) / np.sum((v - u) ** 2, axis=1), 0, 1)
        result = np.minimum(result, np.linalg.norm(x[:, None] - u - s[..., None] * (v - u), axis=2))
    return np.where(inside, np.abs(offset), result)


@pytest.mark.parametrize("radius", [1e-3, 0.02, 0.3])
@pytest.mark.parametrize("seed", [0, 1])
def test_equals_brute_force(radius, seed):
    """On a strongly graded mesh."""
    submesh, points, positions = graded(seed)
    apart = 0.05
    nodes, slaves = positions[: points.node_count], positions[points.node_count :]
    search = Search(points, submesh, apart, "cpu")
    found = search.within(wp.array(slaves, dtype=vec3), wp.array(nodes, dtype=vec3), radius)

    near = distances(slaves, nodes[submesh.triangles])
    flat = np.pad(points.flat, ((0, 0), (0, 1)))
    flat_distance = distances(flat[points.node_count :], flat[: points.node_count][submesh.triangles])
    own = np.zeros(near.shape, dtype=bool)
    for i in range(len(slaves)):
        owners = points.owners[points.owner_starts[i] : points.owner_starts[i + 1]]
        own[i] = np.isin(submesh.triangle_faces, owners)
    wanted = (near <= radius) & (~own | (flat_distance >= apart))
    borderline = (np.abs(near - radius) < 1e-12) | (own & (np.abs(flat_distance - apart) < 1e-12))

    got = np.zeros(near.shape, dtype=bool)
    got[np.repeat(found.points, np.diff(found.starts)), found.candidates] = True
    assert wanted.sum() > 10
    assert len(found.candidates) == got.sum()
    assert not np.any((got != wanted) & ~borderline)
    np.testing.assert_array_equal(found.layers, submesh.triangle_faces[found.candidates[found.starts[:-1]]])
    assert np.all(np.diff(found.keys) > 0)
    least = np.minimum.reduceat(
        near[np.repeat(found.points, np.diff(found.starts)), found.candidates], found.starts[:-1]
    )
    np.testing.assert_allclose(found.distances, least, atol=1e-14)


def test_nearest_finds_layers_at_any_distance():
    """For pairs that lie within the radius and for pairs far beyond it: all sub-triangles at the least distance."""
    submesh, points, positions = graded(0)
    nodes, slaves = positions[: points.node_count], positions[points.node_count :]
    search = Search(points, submesh, 0.05, "cpu")
    keys = np.unique(np.random.default_rng(0).integers(0, len(slaves) * search.layer_count, 100))
    found = search.nearest(keys, wp.array(slaves, dtype=vec3), wp.array(nodes, dtype=vec3), 1e-3)
    np.testing.assert_array_equal(found.keys, keys)

    near = distances(slaves, nodes[submesh.triangles])
    flat = np.pad(points.flat, ((0, 0), (0, 1)))
    flat_distance = distances(flat[points.node_count :], flat[: points.node_count][submesh.triangles])
    for i, (point, layer) in enumerate(zip(found.points, found.layers, strict=True)):
        candidates = found.candidates[found.starts[i] : found.starts[i + 1]]
        allowed = submesh.triangle_faces == layer
        if layer in points.owners[points.owner_starts[point] : points.owner_starts[point + 1]]:
            allowed &= flat_distance[point] >= 0.05
        least = near[point, allowed].min()
        assert found.distances[i] == pytest.approx(least, abs=1e-14)
        assert np.isin(np.flatnonzero(allowed & (near[point] <= least + 1e-12)), candidates).all()
        assert allowed[candidates].all()


def test_contact_does_not_miss_what_moves_between_searches():
    """Many small moves without a new search give the same energy as a search at the end."""
    sheets = TwoSheets(grid(3, 3, (0.3, 0.3)), grid(2, 2, (0.2, 0.2), angle=0.4))
    contact = sheets.contact("mixed", start=0.02)
    for step in range(60):
        height, dx = 0.02 - 0.00033 * step, 0.001 * step
        q = sheets.at(height, dx)
        fresh = Contact(sheets.mesh, sheets.coordinates, settings("mixed"), sheets.at(0.02))
        fresh._surfaces._searches.forget()
        a, b = contact.gradient(q), fresh.gradient(q)
        assert a[0] == b[0] and np.array_equal(a[1], b[1])
    assert a[0] > 0
