"""The membrane element: patch test, rigid motion, derivatives in every state, precision, determinism."""

import numpy as np
import pytest
import warp as wp

from membrane_cases import Film, distorted_sheet, field_coordinates, linear_field, rotation
from warp_origami.errors import InputError
from warp_origami.terms.membrane import Membrane
from warp_origami.terms.quadrature import rule
from warp_origami.terms.shapes import tabulate

PAIRS = np.triu_indices(9)

STRETCHES = {
    "taut": (1.01, 1.008),
    "wrinkled": (1.01, 0.98),
    "slack": (0.985, 0.99),
    "equal taut": (1.01, 1.01),
    "equal slack": (0.99, 0.99),
}


@pytest.fixture(scope="module")
def sheet():
    return distorted_sheet(crease=1)


def dense_tangent(coordinates, blocks):
    """Full (3 n, 3 n) tangent from the 45 blocks of each element."""
    n = coordinates.count
    full = np.zeros((n, 3, n, 3))
    for rows, own in zip(coordinates.elements, blocks, strict=True):
        for i, j, block in zip(*PAIRS, own, strict=True):
            full[rows[i], :, rows[j], :] += block
            if i != j:
                full[rows[j], :, rows[i], :] += block.T
    return full.reshape(3 * n, 3 * n)


def stretched(mesh, coordinates, stretch, bump=0.0, seed=0):
    """Sheet stretched in its plane, turned in space, nodal values moved at random by `bump` (relative)."""
    gradient = rotation([1, 2, 3], 0.7) @ np.diag([*stretch, 1.0])[:, :2]
    q = field_coordinates(mesh, coordinates, linear_field(gradient, (0.1, -0.2, 0.3)))
    size = np.ones(coordinates.count)
    size[coordinates.positions] = 0.1
    return q + bump * size[:, None] * np.random.default_rng(seed).normal(size=q.shape)


def reference(mesh, coordinates, film, q, degree):
    """Energy and gradient by NumPy from (16), (20), with eigenvalues, element by element."""
    areas, weights = rule(degree)
    energy, gradient = 0.0, np.zeros_like(q)
    e, nu, s1, s2 = film.youngs_modulus, film.poisson_ratio, film.s1, film.s2
    for k, rows in enumerate(coordinates.elements):
        table = tabulate(mesh, np.full(len(areas), k), areas)
        for shape, w in zip(table.gradients, weights * mesh.areas[k] * film.thickness, strict=True):
            r = shape.T @ q[rows]  # r_x, r_y
            strain = 0.5 * (r @ r.T - np.eye(2))
            (g2, g1), vectors = np.linalg.eigh(strain)
            if film.model == "linear" or g2 + nu * g1 >= 0:
                gamma = e / (1 - nu**2) * np.array([[1, nu], [nu, 1]])
            elif g1 + s1 * nu * g2 > 0:
                gamma = e / (1 - s1 * nu**2) * np.array([[1, s1 * nu], [s1 * nu, s1]])
            else:
                gamma = e / (1 - s1 * s2 * nu**2) * np.array([[s2, s1 * s2 * nu], [s1 * s2 * nu, s1]])
            t = gamma @ [g1, g2]
            stress = vectors @ np.diag(t[::-1]) @ vectors.T
            energy += w * 0.5 * t @ [g1, g2]
            gradient[rows] += w * shape @ stress @ r
    return energy, gradient


@pytest.mark.parametrize("model", ["srm", "linear"])
@pytest.mark.parametrize("state", ["taut", "wrinkled", "slack"])
def test_patch(sheet, model, state):
    """A uniform strain is reproduced to round-off: strain energy, stress, and no residual inside, over a crease too."""
    mesh, coordinates = sheet
    film = Film(model=model)
    membrane = Membrane(mesh, coordinates, film)
    stretch = np.array(STRETCHES[state])
    q = stretched(mesh, coordinates, stretch)
    energy, gradient = membrane.gradient(q)

    g1, g2 = (stretch**2 - 1) / 2 if state != "slack" else (stretch[::-1] ** 2 - 1) / 2
    e, nu, s = film.youngs_modulus, film.poisson_ratio, film.s1
    ratios = {"taut": (1.0, 1.0), "wrinkled": (1.0, s), "slack": (s, s)}[state if model == "srm" else "taut"]
    a, b = ratios
    factor = e / (1 - min(1.0, b) * min(1.0, a) * nu**2)
    t = factor * np.array([a * g1 + a * b * nu * g2, a * b * nu * g1 + b * g2])
    volume = 0.36 * film.thickness
    np.testing.assert_allclose(energy, 0.5 * (t @ [g1, g2]) * volume, rtol=1e-12)

    table = tabulate(mesh, np.arange(len(mesh.triangles)), np.full((len(mesh.triangles), 3), 1 / 3))
    sample = membrane.stress(q, table)
    np.testing.assert_allclose(sample.s1, t.max(), rtol=1e-12, atol=1e-14 * e)
    np.testing.assert_allclose(sample.s2, t.min(), rtol=1e-12, atol=1e-14 * e)
    np.testing.assert_allclose(sample.von_mises, np.sqrt(t[0] ** 2 - t[0] * t[1] + t[1] ** 2), rtol=1e-12)

    inside = (mesh.vertices > 1e-9).all(axis=1) & (mesh.vertices < 0.6 - 1e-9).all(axis=1)
    shared = np.bincount(coordinates.sector_vertices, minlength=len(mesh.vertices)) == 1  # off the crease
    scale = np.abs(gradient).max()
    assert np.abs(gradient[coordinates.positions[inside]]).max() < 1e-12 * scale
    rows = coordinates.sector_gradients[(inside & shared)[coordinates.sector_vertices]]
    assert len(rows) > 0
    assert np.abs(gradient[[rows, rows + 1]]).max() < 1e-12 * scale


@pytest.mark.parametrize("model", ["srm", "linear"])
def test_rigid_motion_of_an_unstressed_sheet_gives_no_force(sheet, model):
    mesh, coordinates = sheet
    film = Film(model=model)
    energy, gradient = Membrane(mesh, coordinates, film).gradient(stretched(mesh, coordinates, (1.0, 1.0)))
    assert energy < 1e-25
    assert np.abs(gradient).max() < 1e-14 * film.youngs_modulus * film.thickness * 0.6


@pytest.mark.parametrize("model", ["srm", "linear"])
def test_forces_of_a_stressed_sheet_turn_with_it(sheet, model):
    mesh, coordinates = sheet
    membrane = Membrane(mesh, coordinates, Film(model=model, s1=1e-2, s2=1e-3))
    q = stretched(mesh, coordinates, (1.005, 0.995), bump=5e-3)
    turn, shift = rotation([3, -1, 2], 2.1), np.zeros((coordinates.count, 3))
    shift[coordinates.positions] = [1.0, -2.0, 0.5]
    energy, gradient, blocks = membrane.tangent(q)
    blocks = blocks.copy()
    energy_turned, gradient_turned, blocks_turned = membrane.tangent(q @ turn.T + shift)
    np.testing.assert_allclose(energy_turned, energy, rtol=1e-11)
    np.testing.assert_allclose(gradient_turned, gradient @ turn.T, atol=1e-11 * np.abs(gradient).max())
    np.testing.assert_allclose(blocks_turned, turn @ blocks @ turn.T, atol=1e-11 * np.abs(blocks).max())


@pytest.mark.parametrize(
    ("model", "s1", "s2"), [("srm", 1e-4, 1e-4), ("srm", 1e-2, 1e-2), ("srm", 1e-2, 1e-3), ("linear", 1.0, 1.0)]
)
@pytest.mark.parametrize("state", [*STRETCHES, "mixed"])
def test_gradient_and_tangent_are_derivatives(sheet, model, s1, s2, state):
    """Central differences along random directions."""
    if state == "equal slack" and s1 != s2:
        pytest.skip("the law itself has a kink at equal slack strains when s1 != s2")
    mesh, coordinates = sheet
    membrane = Membrane(mesh, coordinates, Film(model=model, s1=s1, s2=s2))
    stretch, bump = (STRETCHES[state], 1e-5) if state != "mixed" else ((1.002, 0.999), 3e-3)
    bump *= not state.startswith("equal")
    q = stretched(mesh, coordinates, stretch, bump)
    fractions = membrane.state_fractions(q)
    if model == "srm":
        expected = {"taut": 0, "wrinkled": 1, "slack": 2}.get(state.split()[-1])
        assert min(fractions) > 0.02 if expected is None else fractions[expected] > 1 - 1e-14
    _, gradient, blocks = membrane.tangent(q)
    tangent = dense_tangent(coordinates, blocks)
    assert np.array_equal(gradient, membrane.gradient(q)[1])
    for seed in range(3):
        d = np.random.default_rng(10 + seed).normal(size=q.shape)
        d[coordinates.positions] *= 0.1
        h = 1e-8 if state == "mixed" else 1e-6
        (u_plus, g_plus), (u_minus, g_minus) = membrane.gradient(q + h * d), membrane.gradient(q - h * d)
        size = np.linalg.norm(gradient) * np.linalg.norm(d)
        assert abs((u_plus - u_minus) / (2 * h) - np.sum(gradient * d)) < 1e-6 * size
        product = (tangent @ d.ravel()).reshape(q.shape)
        assert np.abs((g_plus - g_minus) / (2 * h) - product).max() < 1e-6 * np.abs(product).max()


@pytest.mark.parametrize("model", ["srm", "linear"])
def test_the_tangent_is_symmetric(sheet, model):
    mesh, coordinates = sheet
    _, _, blocks = Membrane(mesh, coordinates, Film(model=model)).tangent(
        stretched(mesh, coordinates, (1.002, 0.999), 3e-3)
    )
    diagonal = blocks[:, PAIRS[0] == PAIRS[1]]
    assert np.abs(diagonal - diagonal.transpose(0, 1, 3, 2)).max() < 1e-14 * np.abs(blocks).max()


@pytest.mark.parametrize("model", ["srm", "linear"])
@pytest.mark.parametrize("degree", [2, 6])
def test_energy_and_gradient_equal_those_of_numpy(sheet, model, degree):
    """All three states occur, and constants that float32 would truncate: 1e-14 leaves no room for a float32."""
    mesh, coordinates = sheet
    film = Film(2.5e9 / 3, 1 / 3, 1e-3 / 3, model, 1e-2 / 3, 1e-2 / 7)
    membrane = Membrane(mesh, coordinates, film, degree=degree)
    q = stretched(mesh, coordinates, (1.2 - 1 / 30, 0.8), bump=0.1)
    energy, gradient = membrane.gradient(q)
    expected_energy, expected_gradient = reference(mesh, coordinates, film, q, degree)
    if model == "srm":
        assert min(membrane.state_fractions(q)) > 0.01
    assert abs(energy - expected_energy) < 1e-14 * expected_energy
    assert np.abs(gradient - expected_gradient).max() < 1e-14 * np.abs(expected_gradient).max()


def test_repeated_runs_agree_bitwise(sheet):
    mesh, coordinates = sheet
    q = stretched(mesh, coordinates, (1.002, 0.999), 3e-3)
    runs = []
    for _ in range(3):
        membrane = Membrane(mesh, coordinates, Film())
        energy, gradient, blocks = membrane.tangent(q)
        runs.append((energy, gradient.tobytes(), blocks.tobytes(), membrane.gradient(q)[0]))
    assert runs[0] == runs[1] == runs[2]


def test_state_fractions_and_samples_agree_with_uniform_states(sheet):
    mesh, coordinates = sheet
    membrane = Membrane(mesh, coordinates, Film())
    sampler = membrane.sampler(tabulate(mesh, np.array([0, 3]), np.full((2, 3), 1 / 3)))
    for k, state in enumerate(("taut", "wrinkled", "slack")):
        q = stretched(mesh, coordinates, STRETCHES[state])
        expected = np.zeros(3)
        expected[k] = 1.0
        np.testing.assert_allclose(membrane.state_fractions(q), expected, atol=1e-14)
        assert (sampler(q).state == 2 - k).all()


def test_unknown_model_is_refused(sheet):
    with pytest.raises(InputError, match=r"material\.model: got rubber, wants srm or linear"):
        Membrane(*sheet, Film(model="rubber"))


@pytest.mark.cuda
def test_cuda_agrees_with_the_cpu(sheet):
    if not wp.is_cuda_available():
        pytest.skip("no CUDA device")
    mesh, coordinates = sheet
    q = stretched(mesh, coordinates, (1.002, 0.999), 3e-3)
    host, device = (Membrane(mesh, coordinates, Film(), device=name).tangent(q) for name in ("cpu", "cuda:0"))
    for a, b in zip(host, device, strict=True):
        np.testing.assert_allclose(b, a, atol=1e-11 * np.abs(a).max())
