"""Follower pressure: exact on every state, turns with the sheet, has the volume as potential where the rim is held."""

import numpy as np
import pytest
import warp as wp
from warp_origami.kernels.precision import mat33

from membrane_cases import Film, distorted_sheet, field_coordinates, linear_field, rotation, square_mesh
from test_membrane import dense_tangent
from warp_origami.model.constraints import build_constraints
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.prescribed import prescribed_rows
from warp_origami.terms.membrane import Membrane
from warp_origami.terms.pressure import FollowerPressure
from warp_origami.terms.shapes import tabulate

PART = np.array([0, 3, 4, 5, 9, 10, 13])
"""The elements around one inner vertex and one more: their rim runs along the edge of the sheet and through it."""


class Case:
    """A distorted sheet of 18 elements, a random state that satisfies the fold conditions, a pressed region."""

    def __init__(self, crease=None, part=None, device="cpu"):
        self.mesh, self.coordinates = distorted_sheet(crease=crease)
        flat = field_coordinates(self.mesh, self.coordinates, linear_field(np.eye(3)[:, :2]))
        rows = prescribed_rows(self.mesh, self.coordinates, [], flat, flat)
        self.constraints = build_constraints(self.mesh, self.coordinates, [], rows)
        self.elements = np.arange(len(self.mesh.triangles)) if part is None else part
        self.pressure = FollowerPressure(self.mesh, self.coordinates, self.elements, device)
        self.lengths = np.ones((self.coordinates.count, 1))
        self.lengths[self.coordinates.positions] = 0.1
        turned = field_coordinates(
            self.mesh, self.coordinates, linear_field(rotation([1, 2, 3], 0.7)[:, :2], [1, 2, 3])
        )
        self.q = turned + self.displacement(seed=1)

    def displacement(self, seed, vertices=None):
        """Random (n, 3), zero but at `vertices`, continuous over creases."""
        d = self.lengths * np.random.default_rng(seed).normal(size=(self.coordinates.count, 3))
        if vertices is not None:
            keep = np.zeros(len(d), dtype=bool)
            keep[self.coordinates.positions[vertices]] = True
            sectors = self.coordinates.sector_gradients[np.isin(self.coordinates.sector_vertices, vertices)]
            keep[sectors] = keep[sectors + 1] = True
            d[~keep] = 0.0
        c = self.constraints
        return (c.null_space @ (c.left_inverse @ d.ravel())).reshape(d.shape)

    def rim_vertices(self):
        """Vertices of the edges that one pressed element has for itself."""
        sides = np.sort(np.stack([self.mesh.triangles, np.roll(self.mesh.triangles, -1, axis=1)], axis=-1), axis=-1)
        edges, count = np.unique(sides[self.elements].reshape(-1, 2), axis=0, return_counts=True)
        return np.unique(edges[count == 1])

    def derivative(self, d):
        """dF/dq d: central differences of a quadratic function are exact."""
        h = 0.1
        return (self.pressure.force(self.q + h * d) - self.pressure.force(self.q - h * d)) / (2 * h)

    def symmetric(self):
        """(3n, 3n) symmetric part of dF/dq."""
        blocks = wp.zeros((len(self.mesh.triangles), 45), dtype=mat33, device="cpu")
        self.pressure.add_stiffness(self.q, -1.0, blocks)
        return dense_tangent(self.coordinates, blocks.numpy())


CASES = {"plain": {}, "creased": {"crease": 1}, "part": {"part": PART}, "creased part": {"crease": 1, "part": PART}}


@pytest.fixture(scope="module", params=CASES)
def case(request):
    return Case(**CASES[request.param])


def resultant(coordinates, force):
    return force[coordinates.positions].sum(axis=0)


def moment(coordinates, q, force):
    """About the origin: gradients have their share."""
    return np.cross(q, force).sum(axis=0)


def quadrature_force(case):
    """The force by its definition, with 8 x 8 Gauss points an element (degree 14)."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    u, v = (a.ravel() for a in np.meshgrid(0.5 * (nodes + 1), 0.5 * (nodes + 1), indexing="ij"))
    areas = np.stack([u, v * (1 - u), (1 - u) * (1 - v)], axis=1)
    shares = 0.5 * np.outer(weights, weights).ravel() * (1 - u)
    force = np.zeros_like(case.q)
    for e in case.elements:
        rows = case.coordinates.elements[e]
        table = tabulate(case.mesh, np.full(len(areas), e), areas)
        r_x, r_y = np.einsum("pid,ic->dpc", table.gradients, case.q[rows])
        np.add.at(force, rows, table.values.T @ (case.mesh.areas[e] * shares[:, None] * np.cross(r_x, r_y)))
    return force


def test_force_is_the_integral_of_the_normal(case):
    force = case.pressure.force(case.q)
    assert np.abs(force - quadrature_force(case)).max() < 1e-14 * np.abs(force).max()


def test_affine_sheets_feel_pressure_times_area_along_the_normal():
    mesh, coordinates = distorted_sheet(crease=1)
    gradient = rotation([1, 2, 3], 0.7) @ np.diag([1.3, 0.8, 1.0])[:, :2]
    q = field_coordinates(mesh, coordinates, linear_field(gradient, (0.1, -0.2, 0.3)))
    force = FollowerPressure(mesh, coordinates, np.arange(len(mesh.triangles))).force(q)
    expected = 0.36 * np.cross(*gradient.T)
    np.testing.assert_allclose(resultant(coordinates, force), expected, rtol=1e-13)
    middle = gradient @ [0.3, 0.3] + [0.1, -0.2, 0.3]
    np.testing.assert_allclose(moment(coordinates, q, force), np.cross(middle, expected), rtol=1e-13)


@pytest.mark.parametrize("name", ["plain", "creased"])
def test_resultant_over_a_plane_rim_is_that_of_the_plane(name):
    """However the inside bulges: 0.36 m^2 along z through the middle, for a closed surface feels no resultant."""
    case = Case(**CASES[name])
    flat = field_coordinates(case.mesh, case.coordinates, linear_field(np.eye(3)[:, :2]))
    inside = np.setdiff1d(np.arange(len(case.mesh.vertices)), case.rim_vertices())
    q = flat + case.displacement(5, inside)
    force = case.pressure.force(q)
    assert np.abs(force - case.pressure.force(flat)).max() > 0.01
    np.testing.assert_allclose(resultant(case.coordinates, force), [0, 0, 0.36], atol=1e-15)
    np.testing.assert_allclose(moment(case.coordinates, q, force), [0.3 * 0.36, -0.3 * 0.36, 0], atol=1e-15)


def test_force_turns_with_the_sheet(case):
    turn = rotation([3, -1, 2], 2.1)
    force = case.pressure.force(case.q)
    np.testing.assert_allclose(case.pressure.force(case.q @ turn.T), force @ turn.T, atol=1e-14 * np.abs(force).max())


def test_force_does_not_see_a_translation(case):
    """Not even in the last bit, on positions of 2^-30 m that a shift by 1024 m leaves exact."""
    q = np.round(case.q * 2.0**30) / 2.0**30
    shifted = q.copy()
    shifted[case.coordinates.positions] += [1024.0, -1024.0, 512.0]
    assert np.array_equal(case.pressure.force(shifted), case.pressure.force(q))


def test_the_volume_is_the_potential_while_the_rim_is_held(case):
    """Central differences of a cubic function, whose own third derivative is taken off."""
    inside = np.setdiff1d(case.mesh.triangles[case.elements], case.rim_vertices())
    assert len(inside) > 0
    d = case.displacement(2, inside)
    volume = case.pressure.volume
    difference = 0.5 * (volume(case.q + d) - volume(case.q - d)) - volume(d)
    work = np.sum(case.pressure.force(case.q) * d)
    assert abs(work) > 1e-4
    assert abs(difference - work) < 1e-14 * abs(volume(case.q))


def test_volume_of_a_roof():
    """1/3 of the flux of r: the volume under the roof less that of the pyramid from the origin to the far gable."""
    mesh = square_mesh(2, crease=1)
    coordinates = number_coordinates(mesh)
    x, y = mesh.vertices.T
    ridge = np.isclose(x, 0.3)
    q = affine_coordinates(mesh, coordinates, np.stack([x, y, np.where(ridge, 0.4, 0.0)], axis=1))
    gable = 0.5 * 0.6 * 0.4
    found = FollowerPressure(mesh, coordinates, np.arange(len(mesh.triangles))).volume(q)
    assert found == pytest.approx(0.6 * gable - 0.6 * gable / 3, rel=1e-14)


def test_tangent_is_the_derivative_of_the_force(case):
    """Symmetric element blocks and rim part together, between motions that satisfy the fold conditions."""
    tangent = case.symmetric() + case.pressure.skew(case.q).toarray()
    free = case.constraints.null_space
    for seed in range(3, 7):
        d = case.displacement(seed)
        exact = free.T @ case.derivative(d).ravel()
        assert np.abs(free.T @ (tangent @ d.ravel()) - exact).max() < 1e-13 * np.abs(exact).max()


def test_tangent_has_the_two_symmetries(case):
    symmetric, skew = case.symmetric(), case.pressure.skew(case.q).toarray()
    assert np.abs(symmetric - symmetric.T).max() < 1e-15 * np.abs(symmetric).max()
    assert np.abs(skew + skew.T).max() < 1e-15 * np.abs(skew).max()


def test_only_the_rim_makes_the_tangent_unsymmetric(case):
    """The stored structure holds the vertices of the rim and no others, so a held rim leaves nothing."""
    skew = case.pressure.skew(case.q)
    rim = case.rim_vertices()
    vertex = np.zeros(case.coordinates.count, dtype=int)
    vertex[case.coordinates.positions] = np.arange(len(case.mesh.vertices))
    vertex[case.coordinates.sector_gradients] = case.coordinates.sector_vertices
    vertex[case.coordinates.sector_gradients + 1] = case.coordinates.sector_vertices
    stored = vertex[np.unique(skew.indices) // 3]
    assert set(stored) == set(rim)
    assert np.array_equal(skew.indices, case.pressure.skew(2 * case.q).indices)


def test_parts_add_up_to_the_whole():
    """Along the rim that two regions share their antisymmetric parts cancel."""
    whole, part = Case(), Case(part=PART)
    rest = Case(part=np.setdiff1d(whole.elements, PART))
    q = whole.q
    total = part.pressure.force(q) + rest.pressure.force(q)
    assert np.abs(total - whole.pressure.force(q)).max() < 1e-15
    skew = part.pressure.skew(q) + rest.pressure.skew(q)
    assert abs(skew - whole.pressure.skew(q)).max() < 1e-15 < 1e-3 * abs(part.pressure.skew(q)).max()


def test_stiffness_is_added_to_the_tangents_of_the_pressed_elements():
    case = Case(part=PART)
    membrane = Membrane(case.mesh, case.coordinates, Film())
    blocks = membrane.tangent(case.q)[2].copy()
    unit = wp.zeros((len(case.mesh.triangles), 45), dtype=mat33, device="cpu")
    case.pressure.add_stiffness(case.q, 1.0, unit)
    case.pressure.add_stiffness(case.q, 2e6, membrane.blocks)
    added = membrane.blocks.numpy() - blocks
    assert np.abs(added - 2e6 * unit.numpy()).max() < 1e-12 * np.abs(blocks).max()
    rest = np.setdiff1d(np.arange(len(blocks)), PART)
    assert np.abs(added[PART]).max() > 0 and not added[rest].any()
    case.pressure.add_stiffness(case.q, -1.0, unit)
    assert np.abs(unit.numpy()).max() == 0.0


def test_repeated_runs_agree_bitwise():
    runs = []
    for _ in range(2):
        case = Case(crease=1)
        runs.append([a.tobytes() for a in (case.pressure.force(case.q), case.symmetric())])
        runs[-1].append(case.pressure.skew(case.q).data.tobytes())
    assert runs[0] == runs[1]


@pytest.mark.cuda
def test_cuda_agrees_with_the_cpu():
    if not wp.is_cuda_available():
        pytest.skip("no CUDA device")
    found = []
    for device in ("cpu", "cuda:0"):
        case = Case(crease=1, device=device)
        blocks = wp.zeros((len(case.mesh.triangles), 45), dtype=mat33, device=device)
        case.pressure.add_stiffness(case.q, 1.0, blocks)
        found.append((case.pressure.force(case.q), blocks.numpy()))
    for a, b in zip(*found, strict=True):
        np.testing.assert_allclose(b, a, atol=1e-13 * np.abs(a).max())
