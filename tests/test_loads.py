"""Dead loads do the exact work on fields that the element holds, and a force is spread over what is selected."""

import numpy as np
import pytest

from membrane_cases import field_coordinates, linear_field, rotation, square_mesh
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.selectors import select
from warp_origami.terms.loads import force_weights, normal_weights, surface_weights
from warp_origami.terms.pressure import FollowerPressure

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)
NODES, WEIGHTS = 0.5 * (NODES + 1), 0.5 * WEIGHTS
MODES = np.random.default_rng(1).normal(size=(10, 3))


def cubic(x, y, modes=MODES):
    """A field r, r_x, r_y of degree 3; with six modes of degree 2."""
    o, z = np.ones_like(x), np.zeros_like(x)
    r = [o, x, y, x * x, x * y, y * y, x**3, x * x * y, x * y * y, y**3]
    r_x = [z, o, z, 2 * x, y, z, 3 * x * x, 2 * x * y, y * y, z]
    r_y = [z, z, o, z, x, 2 * y, z, x * x, 2 * x * y, 3 * y * y]
    return tuple(np.stack(terms[: len(modes)], axis=1) @ modes for terms in (r, r_x, r_y))


def quadratic(x, y):
    return cubic(x, y, MODES[:6])


def triangle_means(mesh, elements, field):
    """(k, 3) means of a field over triangles, exact to degree 10."""
    u, v = (a.ravel() for a in np.meshgrid(NODES, NODES, indexing="ij"))
    weights = 2 * np.outer(WEIGHTS * (1 - NODES), WEIGHTS).ravel()
    areas = np.stack([u, v * (1 - u), (1 - u) * (1 - v)], axis=1)
    points = np.einsum("pk,ekd->epd", areas, mesh.vertices[mesh.triangles[elements]])
    r = field(*points.reshape(-1, 2).T)[0].reshape(len(elements), len(weights), 3)
    return np.einsum("p,epc->ec", weights, r)


def line_means(ends, field):
    """(k, 3) means of a field over segments with ends (k, 2, 2)."""
    points = ends[:, None, 0] + NODES[:, None] * (ends[:, None, 1] - ends[:, None, 0])
    r = field(*points.reshape(-1, 2).T)[0].reshape(len(ends), len(NODES), 3)
    return np.einsum("p,epc->ec", WEIGHTS, r)


@pytest.fixture(scope="module", params=[None, 1], ids=["plain", "creased"])
def sheet(request):
    mesh = square_mesh(3, distortion=0.25, crease=request.param)
    return mesh, number_coordinates(mesh)


def positions(coordinates, weights):
    return weights[coordinates.positions]


@pytest.mark.parametrize("elements", [np.arange(18), np.array([2, 5, 7, 13])], ids=["whole", "part"])
def test_traction_on_a_surface_does_the_exact_work(sheet, elements):
    mesh, coordinates = sheet
    weights = surface_weights(mesh, coordinates, elements)
    areas = mesh.areas[elements]
    assert positions(coordinates, weights).sum() == pytest.approx(areas.sum(), rel=1e-14)
    work = weights @ field_coordinates(mesh, coordinates, quadratic)
    np.testing.assert_allclose(work, areas @ triangle_means(mesh, elements, quadratic), rtol=1e-13)


SELECTIONS = {
    "one side": ({"box": [[0, 0], [0, 0.6]]}, [[(0, 0), (0, 0.6)]]),
    "two sides": ({"vertices": [0, 1, 2, 3, 7, 11, 15]}, [[(0, 0), (0.6, 0)], [(0.6, 0), (0.6, 0.6)]]),
    "one boundary edge": ({"vertices": [1, 2]}, [[(0.2, 0), (0.4, 0)]]),
    "rim": (
        {"boundary": True},
        [[(0, 0), (0.6, 0)], [(0.6, 0), (0.6, 0.6)], [(0.6, 0.6), (0, 0.6)], [(0, 0.6), (0, 0)]],
    ),
}


@pytest.mark.parametrize("name", SELECTIONS)
def test_force_on_the_boundary_is_even_along_its_edges(sheet, name):
    """Exact for cubics too: the trace of an edge is one."""
    mesh, coordinates = sheet
    at, lines = SELECTIONS[name]
    weights = force_weights(mesh, coordinates, select(at, mesh))
    assert positions(coordinates, weights).sum() == pytest.approx(1.0, abs=1e-15)
    ends = np.array(lines, dtype=float)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    expected = lengths @ line_means(ends, cubic) / lengths.sum()
    np.testing.assert_allclose(weights @ field_coordinates(mesh, coordinates, cubic), expected, atol=1e-14)


@pytest.mark.parametrize(
    ("at", "elements"),
    [
        ({"all": True}, range(18)),
        ({"box": [[-1, -1], [0.42, 0.6]]}, [0, 1, 3, 4, 6, 7, 9, 10, 12, 13, 15, 16]),
        ({"vertices": [5, 6, 10]}, [4]),
        ({"vertices": [5, 6, 9, 10]}, [4, 13]),
    ],
    ids=["all", "two columns", "one element", "one cell"],
)
def test_force_on_a_surface_is_even_over_its_area(at, elements):
    mesh = square_mesh(3, crease=1)
    coordinates = number_coordinates(mesh)
    weights = force_weights(mesh, coordinates, select(at, mesh))
    assert positions(coordinates, weights).sum() == pytest.approx(1.0, abs=1e-15)
    expected = triangle_means(mesh, np.array(elements), quadratic).mean(axis=0)  # they have equal areas
    np.testing.assert_allclose(weights @ field_coordinates(mesh, coordinates, quadratic), expected, atol=1e-14)


@pytest.mark.parametrize("vertices", [[5, 6], [1, 5, 9, 13], [4, 5, 6]], ids=["edge", "crease", "straight line"])
def test_force_on_a_line_through_the_sheet_is_even_along_it(sheet, vertices):
    mesh, coordinates = sheet
    weights = force_weights(mesh, coordinates, select({"vertices": vertices}, mesh))
    ends = mesh.vertices[np.stack([vertices[:-1], vertices[1:]], axis=1)]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    expected = lengths @ line_means(ends, cubic) / lengths.sum()
    np.testing.assert_allclose(weights @ field_coordinates(mesh, coordinates, cubic), expected, atol=1e-14)


@pytest.mark.parametrize(
    "vertices", [[7], [5, 15], [0, 4, 10]], ids=["one", "two apart", "an edge and a vertex away from it"]
)
def test_force_on_single_vertices_is_shared_equally(sheet, vertices):
    mesh, coordinates = sheet
    weights = force_weights(mesh, coordinates, select({"vertices": vertices}, mesh))
    expected = np.zeros(coordinates.count)
    expected[coordinates.positions[vertices]] = 1 / len(vertices)
    assert np.array_equal(weights, expected)


def roof():
    """Two plane panels that meet at a crease, isometric to the flat sheet, turned in space."""
    mesh = square_mesh(4, crease=2)
    coordinates = number_coordinates(mesh)
    x, y = mesh.vertices.T
    points = np.stack([0.8 * x, y, 0.6 * np.minimum(x, 0.6 - x)], axis=1) @ rotation([1, 2, 3], 0.7).T
    return mesh, coordinates, affine_coordinates(mesh, coordinates, points)


def test_dead_pressure_has_the_normals_of_its_state():
    mesh, coordinates, q = roof()
    left = np.flatnonzero(mesh.vertices[mesh.triangles].mean(axis=1)[:, 0] < 0.3)
    weights = normal_weights(mesh, coordinates, left, q)
    normal = rotation([1, 2, 3], 0.7) @ [-0.6, 0.0, 0.8]
    np.testing.assert_allclose(weights, np.outer(surface_weights(mesh, coordinates, left), normal), atol=1e-16)


def test_dead_and_follower_pressure_agree_in_an_unstrained_state():
    mesh, coordinates, q = roof()
    every = np.arange(len(mesh.triangles))
    follower = FollowerPressure(mesh, coordinates, every).force(q)
    np.testing.assert_allclose(normal_weights(mesh, coordinates, every, q), follower, atol=1e-16)


def test_dead_pressure_acts_on_the_flat_area():
    """A stretch of the initial state changes the area but not this force."""
    mesh, coordinates, _ = roof()
    every = np.arange(len(mesh.triangles))
    stretched = field_coordinates(mesh, coordinates, linear_field([[1.3, 0.2], [0, 0.9], [0, 0]]))
    expected = np.outer(surface_weights(mesh, coordinates, every), [0, 0, 1])
    np.testing.assert_allclose(normal_weights(mesh, coordinates, every, stretched), expected, atol=1e-16)


def test_dead_pressure_on_a_curved_state():
    """A parabolic cylinder: the resultant is the integral of the normal over the flat square."""
    mesh = square_mesh(3, distortion=0.25)
    coordinates = number_coordinates(mesh)

    def cylinder(x, y):
        o, z = np.ones_like(x), np.zeros_like(x)
        return tuple(np.stack(part, axis=1) for part in ((x, y, x * x / 2), (o, z, x), (z, o, z)))

    q = field_coordinates(mesh, coordinates, cylinder)
    total = normal_weights(mesh, coordinates, np.arange(18), q)[coordinates.positions].sum(axis=0)
    expected = [-0.6 * (np.sqrt(1.36) - 1), 0.0, 0.6 * np.arcsinh(0.6)]
    np.testing.assert_allclose(total, expected, atol=1e-9)
