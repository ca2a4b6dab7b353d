"""Edge-to-edge contact: gradient of an energy that fades at ends and near parallel, on the right side, all found."""

from itertools import pairwise

import numpy as np
import pytest
import warp as wp
from warp_origami.kernels.precision import vec3

from contact_cases import EPS_N, THICKNESS, TwoSheets, wavy
from contact_meshes import cut_square, grid, joined, mesh_of
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.generators.leaf_in import leaf_in
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.contact.edge_curves import build_curves
from warp_origami.terms.contact.edge_search import EdgeSearch
from warp_origami.terms.contact.edges import EdgeContact
from warp_origami.terms.contact.thickness import CREASE_RATIO

LENGTH, WIDTH = 0.4, 0.05


def tangent(contact, q):
    """Energy, gradient, gradients of the gaps and stiffness of the touching pairs."""
    energy, gradient = contact.gradient(q)
    pairs = contact.active_pairs()
    return energy, gradient, pairs.gap_rows(), pairs.stiffness


class Strips(TwoSheets):
    """A strip along x and another one over it, turned by an angle: their long edges cross four times."""

    def __init__(self, angle, cells=1):
        super().__init__(grid(cells, 1, (LENGTH, WIDTH)), grid(cells, 1, (LENGTH, WIDTH), angle=angle))

    def edges(self, start, divisions=2, thickness=THICKNESS):
        """Edge contact that starts in the state `start`."""
        submesh = build_submesh(self.mesh, divisions)
        return EdgeContact(self.mesh, self.coordinates, submesh, thickness, EPS_N, start)


def weights(contact):
    """m of all active crossings."""
    return contact._narrow.weights.read()[contact._active]


def slope_error(contact, q, seed=0, e=1e-8):
    """Relative difference of the gradient in a random direction from the difference of energies."""
    direction = np.random.default_rng(seed + 100).normal(size=q.shape)
    slope = (contact.gradient(q + e * direction)[0] - contact.gradient(q - e * direction)[0]) / (2 * e)
    return abs(np.vdot(contact.gradient(q)[1], direction) / slope - 1.0)


def crossing(seed):
    strips = Strips(0.9, 2)
    contact = strips.edges(strips.at(0.01))
    contact.accept(wavy(strips.coordinates, strips.at(4 * THICKNESS), seed))
    return strips, contact, wavy(strips.coordinates, strips.at(0.4 * THICKNESS), seed)


def at_an_end(seed):
    """Both right edges of the upper strip cross the long edges of the lower within a thickness of their ends."""
    strips = Strips(np.pi / 2)
    dx = 0.5 * LENGTH - 0.5 * WIDTH - 0.4 * THICKNESS
    contact = strips.edges(strips.at(0.004, dx))
    return strips, contact, wavy(strips.coordinates, strips.at(0.4 * THICKNESS, dx), seed, 3e-5, 1e-3)


def near_parallel(seed):
    strips = Strips(0.02)
    contact = strips.edges(strips.at(0.01))
    return strips, contact, wavy(strips.coordinates, strips.at(0.4 * THICKNESS, 0.0, WIDTH), seed, 2e-5, 1e-3)


def bent(seed):
    """Thick and bent so much that closest points are about to disappear."""
    strips = Strips(0.1)
    contact = strips.edges(strips.at(0.03), 4, 5 * THICKNESS)
    return strips, contact, wavy(strips.coordinates, strips.at(0.003), seed, 5e-3, 0.2)


# --- gradient of an energy --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", [crossing, at_an_end, near_parallel, bent])
def test_force_is_the_gradient_of_the_energy(case):
    """Also where the force fades: the change of m counts."""
    faded = []
    for seed in range(6):
        _, contact, q = case(seed)
        energy, _ = contact.gradient(q)
        if energy > 0.0:
            faded.extend((weights(contact) < 0.99).tolist())
            assert slope_error(contact, q, seed) < 1e-6, seed
    assert len(faded) > 6
    assert any(faded) == (case is not crossing)


@pytest.mark.parametrize("case", [crossing, at_an_end, near_parallel, bent])
def test_forces_and_moments_balance(case):
    for seed in range(3):
        strips, contact, q = case(seed)
        _, gradient = contact.gradient(q)
        scale = np.abs(gradient).sum() + 1e-9
        assert np.abs(gradient[strips.coordinates.positions].sum(axis=0)).max() < 1e-12 * scale
        assert np.abs(np.cross(q, gradient).sum(axis=0)).max() < 1e-11 * scale


def work_and_energies(contact, state, s):
    """Work against the contact force along state(s), and the energies."""
    nodes, factors = np.polynomial.legendre.leggauss(3)
    work = 0.0
    for a, b in pairwise(s):
        step = state(b) - state(a)
        for x, w in zip(nodes, factors, strict=True):
            work += 0.5 * w * np.vdot(contact.gradient(state(a) + 0.5 * (1 + x) * step)[1], step)
    return work, np.array([contact.gradient(state(t))[0] for t in s])


@pytest.mark.parametrize("depth", [0.3, 0.9])
def test_sliding_over_the_ends_of_edges_costs_no_jump(depth):
    """Along the other edge, over the vertex between two edges and off the end: work equals energy, down to none."""
    strips = Strips(np.pi / 2, 2)
    contact = strips.edges(strips.at(0.004))
    free = 0.5 * (LENGTH - WIDTH)  # dx at which the right edges reach the end of the lower strip
    for middle in (-0.5 * WIDTH, free):  # over the middle vertex, off the end
        s = np.linspace(middle - 1.5 * THICKNESS, middle + 1.5 * THICKNESS, 121)
        work, energies = work_and_energies(
            contact, lambda dx: wavy(strips.coordinates, strips.at((1 - depth) * THICKNESS, dx), 1, 1e-5, 1e-3), s
        )
        assert energies.max() > 1.4 * energies.min()
        assert np.abs(np.diff(energies)).max() < 0.1 * energies.max()
        assert work == pytest.approx(energies[-1] - energies[0], abs=1e-6 * energies.max())


def test_turning_past_parallel_costs_no_jump():
    """The force fades, and beyond parallel it pushes to the same side although the triple product has changed sign."""
    strips = Strips(0.1)
    contact = strips.edges(strips.at(0.01, 0.0, WIDTH))
    base = wavy(strips.coordinates, strips.at(0.5 * THICKNESS), 4, 2e-5, 5e-4)
    rows = np.unique(strips.coordinates.elements[strips.above[strips.mesh.triangles[:, 0]]])
    positions = strips.coordinates.positions[strips.above]

    def state(s):
        """The upper strip, beside the lower but for one long edge each, turned from an angle of 0.1 to -0.1."""
        q = base.copy()
        c, d = np.cos(0.2 * s), np.sin(0.2 * s)
        q[rows] = q[rows] @ np.array([[c, -d, 0.0], [d, c, 0.0], [0.0, 0.0, 1.0]])
        q[positions, 1] += WIDTH
        return q

    s = np.linspace(0.0, 1.0, 801)
    work, energies = work_and_energies(contact, state, s)
    assert work == pytest.approx(energies[-1] - energies[0], abs=1e-6 * energies.max())
    faded, deepest = [], []
    for t in s:
        contact.gradient(state(t))
        faded.append(weights(contact).min() if len(contact._active) == 2 else 0.0)
        deepest.append(contact.statistics()[1])
    assert faded[0] == faded[-1] == 1.0 and min(faded) < 1e-3
    assert max(deepest) < 0.7 * THICKNESS  # 1.5 times the thickness on the wrong side


def test_parallel_edges_give_no_force():
    strips = Strips(0.0)
    contact = strips.edges(strips.at(0.01))
    for height in (0.5 * THICKNESS, 1e-9, 0.0):
        for dx, dy in ((0.0, 0.0), (0.1, 0.0), (0.0, WIDTH)):
            energy, gradient = contact.gradient(strips.at(height, dx, dy))
            assert energy == 0.0 and not gradient.any()


def test_tangent_is_the_derivative_up_to_a_term_proportional_to_the_gap():
    strips = Strips(0.9, 2)
    contact = strips.edges(strips.at(0.01))
    direction = np.random.default_rng(0).normal(size=strips.at(0.0).shape)
    errors = []
    for g in (1e-4, 1e-5, 1e-6):
        q = strips.at(THICKNESS - g)
        energy, gradient, matrix, stiffness = tangent(contact, q)
        again = contact.gradient(q)
        assert energy == again[0] and np.array_equal(gradient, again[1])
        assert matrix.shape == (len(stiffness), q.size) == (4, q.size)
        np.testing.assert_allclose(stiffness, EPS_N)
        e = 1e-4 * g
        change = (contact.gradient(q + e * direction)[1] - contact.gradient(q - e * direction)[1]) / (2 * e)
        main = matrix.T @ (stiffness * (matrix @ direction.ravel()))
        errors.append(np.linalg.norm(main - change.ravel()) / np.linalg.norm(change))
    assert errors[0] < 1e-2 and errors[2] < 0.02 * errors[0], errors


# --- sides ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("above", [1, -1])
def test_edges_are_pushed_back_to_their_own_side(above):
    """eps_e |g| at each of four crossings, from iterates beyond each other too; only accepted states decide."""
    strips = Strips(0.9)
    contact = strips.edges(strips.at(above * 0.004))
    for depth in (0.1, 0.5, 0.9, 1.0, 1.5, 2.5):
        q = strips.at(above * THICKNESS * (1.0 - depth))
        energy, _ = contact.gradient(q)
        assert energy == pytest.approx(4 * 0.5 * EPS_N * (depth * THICKNESS) ** 2)
        assert above * strips.force(contact, q)[2] == pytest.approx(4 * EPS_N * depth * THICKNESS)
        assert contact.statistics() == (4, pytest.approx(depth * THICKNESS))
    contact.accept(strips.at(above * 0.1 * THICKNESS))
    contact.accept(strips.at(-above * 0.1 * THICKNESS))
    assert above * strips.force(contact, strips.at(-above * 0.1 * THICKNESS))[2] > 0
    assert contact.gradient(strips.at(above * 1.01 * THICKNESS))[0] == 0.0
    assert contact.statistics()[0] == 0


def test_side_of_edges_that_meet_within_one_step_comes_from_the_last_accepted_state():
    strips = Strips(0.9)
    contact = strips.edges(strips.at(0.3))
    assert contact.gradient(strips.at(0.3))[0] == 0.0
    assert strips.force(contact, strips.at(-0.3 * THICKNESS))[2] > 0


def test_side_is_free_for_edges_that_came_over_an_end():
    """From beside each other they may meet on either side."""
    strips = Strips(0.9)
    for height in (0.5 * THICKNESS, -0.5 * THICKNESS):
        contact = strips.edges(strips.at(0.01, dx=2.0))
        assert np.sign(strips.force(contact, strips.at(height))[2]) == np.sign(height)


def test_a_bent_edge_crosses_another_twice():
    """An arc over a straight edge: triple products of opposite sign, both crossings pushed back to where they came."""
    strips = Strips(0.0)
    q = strips.at(0.0)
    upper = strips.coordinates.elements[strips.above[strips.mesh.triangles[:, 0]]]
    positions, slopes, _ = upper.reshape(-1, 3).T
    q[slopes, 1] = -np.sign(q[positions, 0]) * 4 * 0.3 * WIDTH / LENGTH  # middles displaced by 0.3 widths
    q[np.unique(positions), 1] -= 0.15 * WIDTH
    up = np.zeros_like(q)
    up[positions, 2] = 1.0
    contact = strips.edges(q + 0.01 * up, 4)
    for height in (0.5 * THICKNESS, -0.5 * THICKNESS):
        energy, _ = contact.gradient(q + height * up)
        assert contact.statistics()[0] == 4
        assert energy == pytest.approx(4 * 0.5 * EPS_N * (THICKNESS - height) ** 2, rel=1e-3)
        assert strips.force(contact, q + height * up)[2] == pytest.approx(4 * EPS_N * (THICKNESS - height), rel=1e-3)


# --- effective thickness ----------------------------------------------------------------------------------------------


def test_edges_stowed_closer_than_the_thickness_start_without_force():
    strips = Strips(0.9)
    d = 0.3 * THICKNESS
    contact = strips.edges(strips.at(d))
    assert contact.gradient(strips.at(d))[0] == 0.0
    assert strips.force(contact, strips.at(0.6 * d))[2] == pytest.approx(4 * EPS_N * 0.4 * d, rel=1e-6)


def test_edges_of_one_sheet_are_as_thick_as_their_flat_distance_allows():
    """Two flaps on one strip, bent over each other: c s counts where it is less than the thickness."""
    mesh = mesh_of(*grid(3, 1, (0.06, 0.02)), lambda m: np.abs(np.abs(m[:, 0]) - 0.01) < 1e-9)
    coordinates = number_coordinates(mesh)
    flat = affine_coordinates(mesh, coordinates, np.pad(mesh.vertices, ((0, 0), (0, 1))))
    contact = EdgeContact(mesh, coordinates, build_submesh(mesh, 2), THICKNESS, EPS_N, flat)
    near = contact._search.within(contact._controls.array, 1.0)
    curves = contact.curves
    found = contact._effective_thickness(near)
    middles = curves.flat.mean(axis=1)
    short = np.abs(np.ptp(curves.flat[:, :, 0], axis=1)) < 1e-9  # borders and creases across the strip
    across = short[near.first] & short[near.second]
    s = np.abs(middles[near.first, 0] - middles[near.second, 0])
    np.testing.assert_allclose(found[across], np.minimum(THICKNESS, CREASE_RATIO * s[across]), rtol=1e-12)
    assert across.sum() == 6
    shared = (curves.vertices[near.first][:, :, None] == curves.vertices[near.second][:, None]).any(axis=(1, 2))
    assert not shared.any()


def test_leaf_in_starts_without_edge_force():
    pattern = leaf_in()
    coordinates = number_coordinates(pattern.mesh)
    q = affine_coordinates(pattern.mesh, coordinates, pattern.stowed)
    contact = EdgeContact(pattern.mesh, coordinates, build_submesh(pattern.mesh, 4), 5e-4, EPS_N, q)
    energy, gradient = contact.gradient(q)
    assert energy == 0.0 and not gradient.any()
    assert contact.statistics()[1] == 0.0


def test_lips_of_a_cut_do_not_push_each_other(tmp_path):
    mesh = cut_square(tmp_path)
    coordinates = number_coordinates(mesh)
    flat = affine_coordinates(mesh, coordinates, np.pad(mesh.vertices, ((0, 0), (0, 1))))
    contact = EdgeContact(mesh, coordinates, build_submesh(mesh, 2), THICKNESS, EPS_N, flat)
    assert contact.gradient(flat)[0] == 0.0
    q = wavy(coordinates, flat, 3, 1e-5, 1e-3)
    assert np.isfinite(contact.gradient(q)[1]).all()


# --- search and state -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("angle", "divisions"), [(0.9, 3), (0.2, 16)])
def test_equal_states_give_equal_bits_however_they_were_reached(angle, divisions):
    """A search made in another state hands other parts of the edges to look from; those that count must be the same."""
    results = []
    for path in ((), (0.2, 0.05, -0.02), (0.012, 0.0113, 0.003)):
        strips = Strips(angle, 2)
        contact = strips.edges(strips.at(0.01), divisions)
        for height in path:
            contact.gradient(wavy(strips.coordinates, strips.at(height), 9))
        contact.accept(wavy(strips.coordinates, strips.at(2 * THICKNESS), 1))
        for height in path:
            contact.gradient(strips.at(height, 0.003))
        results.append(tangent(contact, wavy(strips.coordinates, strips.at(0.3 * THICKNESS), 2)))
        results.append(tangent(contact, wavy(strips.coordinates, strips.at(0.3 * THICKNESS), 2)))
    for energy, gradient, matrix, stiffness in results:
        assert energy == results[0][0] > 0.0
        assert np.array_equal(gradient, results[0][1])
        assert np.array_equal(matrix.data, results[0][2].data)
        assert np.array_equal(stiffness, results[0][3])


def test_restore_continues_bitwise():
    strips = Strips(0.9, 2)
    contact, other = (strips.edges(strips.at(0.01)) for _ in range(2))
    for height in (0.003, 0.0008, 0.0002, -0.0001):
        contact.accept(wavy(strips.coordinates, strips.at(height), 5, 1e-4))
    stored = {name: values.copy() for name, values in contact.state().items()}
    assert len(stored["sides"]) > 0
    other.restore(stored)
    for state in (other.state(), contact.state()):
        assert all(np.array_equal(state[name], stored[name]) for name in stored)
    q = wavy(strips.coordinates, strips.at(-0.0002), 6, 1e-4)
    a, b = contact.gradient(q), other.gradient(q)
    assert a[0] == b[0] > 0.0 and np.array_equal(a[1], b[1])
    assert strips.force(other, q)[2] > 0.0


def test_search_drops_no_pair_of_a_crowd():
    """Many strips in one place: far more pairs than there was room for, all found, once."""
    rng = np.random.default_rng(0)
    count = 30
    mesh = mesh_of(*joined(*(grid(1, 1, (0.2, 0.02), (k, 0.0), rng.uniform(0, 3)) for k in range(count))))
    coordinates = number_coordinates(mesh)
    curves = build_curves(mesh, coordinates)
    points = np.pad(mesh.vertices, ((0, 0), (0, 1)))
    points[:, 0] -= np.repeat(np.arange(count), 4)
    q = affine_coordinates(mesh, coordinates, points + 1e-3 * rng.normal(size=points.shape))
    controls = wp.array(curves.controls @ q, dtype=vec3, device="cpu")
    search = EdgeSearch(curves.vertices, 3, "cpu")
    near = search.within(controls, 0.5)
    n = 4 * count
    assert len(near.keys) == n * (n - 1) // 2 - 4 * count  # four corners of every strip are shared
    assert len(near.candidates) == 9 * len(near.keys) > 4 * 3 * n
    assert len(np.unique(near.keys)) == len(near.keys) and np.all(np.diff(near.distances) >= 0.0)


def test_search_finds_what_brute_force_finds():
    """Bent edges: every pair whose curves come within the radius."""
    strips = Strips(0.7, 3)
    curves = build_curves(strips.mesh, strips.coordinates)
    q = wavy(strips.coordinates, strips.at(0.02), 2, 0.01, 0.3)
    controls = curves.controls @ q
    s = np.linspace(0.0, 1.0, 41)
    basis = np.stack([(1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s**2 * (1 - s), s**3], axis=1)
    samples = np.einsum("sa,kad->ksd", basis, controls.reshape(-1, 4, 3))
    for divisions, radius in ((1, 0.01), (4, 0.03)):
        search = EdgeSearch(curves.vertices, divisions, "cpu")
        found = set(search.within(wp.array(controls, dtype=vec3, device="cpu"), radius).keys.tolist())
        wanted = set()
        for a in range(len(samples)):
            for b in range(a + 1, len(samples)):
                apart = np.linalg.norm(samples[a][:, None] - samples[b][None], axis=2).min()
                if apart <= radius and not set(curves.vertices[a]) & set(curves.vertices[b]):
                    wanted.add(a * len(samples) + b)
        assert wanted and wanted <= found and len(found) < len(samples) * (len(samples) - 1) // 4
