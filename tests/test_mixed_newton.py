"""The mixed iteration: its strains, that it ends where the plain one does, and that it needs fewer factorizations."""

from dataclasses import dataclass

import numpy as np
import pytest

import warp_origami as wo
from membrane_cases import Film, distorted_sheet
from runs import States
from warp_origami.model.coordinates import affine_coordinates
from warp_origami.scene import load_scene
from warp_origami.solve import mixed_newton, step
from warp_origami.solve.newton import minimize
from warp_origami.terms.membrane import Membrane


@pytest.fixture(scope="module")
def sheet():
    """A membrane, a bent and wrinkled state of it and a small step."""
    mesh, coordinates = distorted_sheet()
    rng = np.random.default_rng(4)
    q = affine_coordinates(mesh, coordinates, np.pad(mesh.vertices, ((0, 0), (0, 1))))
    q += 1e-3 * rng.normal(size=q.shape)
    return Membrane(mesh, coordinates, Film()), q, 1e-4 * rng.normal(size=q.shape)


def test_with_the_strains_of_q_it_is_the_plain_linearization(sheet):
    membrane, q, _ = sheet
    energy, gradient, blocks = membrane.tangent(q)
    blocks = blocks.copy()
    membrane.take_strains(q)
    held_energy, held_gradient = membrane.linearize(q, mixed=True)
    assert held_energy == pytest.approx(energy, rel=1e-14)
    np.testing.assert_allclose(held_gradient, gradient, atol=1e-14 * np.abs(gradient).max())
    np.testing.assert_allclose(membrane.blocks.numpy(), blocks, atol=1e-14 * np.abs(blocks).max())


@pytest.fixture(scope="module")
def elastic():
    """The sheet with the linear law; SRM takes strains on to where it is to be linearized next."""
    return Membrane(*distorted_sheet(), Film(model="linear"))


def test_strains_after_a_step_are_those_of_its_end_to_second_order(elastic, sheet):
    """|grad d|^2 / 2 is left."""
    _, q, d = sheet
    errors = []
    for scale in (1.0, 0.5):
        elastic.take_strains(q)
        elastic.advance_strains(q, scale * d, 1.0)
        advanced = elastic._strains.numpy().copy()
        elastic.take_strains(q + scale * d)
        errors.append(np.abs(advanced - elastic._strains.numpy()).max())
    assert errors[1] == pytest.approx(0.25 * errors[0], rel=1e-6)


def test_half_a_step_takes_the_strains_half_of_the_way(elastic, sheet):
    (_, q, d), strains = sheet, []
    for lengths in ((), (1.0,), (0.5,)):
        elastic.take_strains(q - d)
        for length in lengths:
            elastic.advance_strains(q, d, length)
        strains.append(elastic._strains.numpy().copy())
    np.testing.assert_allclose(strains[2], 0.5 * (strains[0] + strains[1]), atol=1e-16)


def test_strains_of_q_stay_where_there_is_no_step(sheet):
    """What the iteration converges to is the law at q."""
    membrane, q, d = sheet
    membrane.take_strains(q)
    before = membrane._strains.numpy().copy()
    membrane.advance_strains(q, 0.0 * d, 1.0)
    np.testing.assert_allclose(membrane._strains.numpy(), before, atol=1e-13 * np.abs(before).max())


def test_without_its_geometric_part_the_tangent_is_positive(sheet):
    membrane, q, _ = sheet
    membrane.linearize(q, geometric=False)
    diagonals = membrane.blocks.numpy()[:, 0].copy()
    assert np.linalg.eigvalsh(diagonals).min() > -1e-12 * np.abs(diagonals).max()
    membrane.linearize(q)  # the options do not stay
    assert not np.array_equal(diagonals, membrane.blocks.numpy()[:, 0])


def counted(scene, until, plain, monkeypatch):
    """Last q, Newton iterations and steps of a run."""
    if plain:
        monkeypatch.setattr(
            step, "minimize_mixed", lambda potential, start, before, tol: minimize(potential, start, tol)
        )
    states = States()
    summary = wo.simulate(scene, device="cpu", until=until, observers=[states]).summary
    monkeypatch.undo()
    return states.q[-1], summary["newton_iterations"], summary["steps_accepted"]


def test_ends_where_the_plain_iteration_ends_with_fewer_factorizations(monkeypatch):
    """Leaf-in with fixed steps: the two runs come together as Newton's tolerance, 1e-4 of that here, falls."""
    apart = []
    for tolerance in (1e-6, 1e-7):
        scene = load_scene("leaf_in", ["integrator.step=0.005", f"integrator.tolerance={tolerance}"])
        scene = scene.model_copy(update={"contact": None})
        ends = [counted(scene, 0.1, plain, monkeypatch) for plain in (True, False)]
        apart.append(np.abs(ends[0][0] - ends[1][0]).max())
        print([end[1:] for end in ends], apart[-1])
        assert ends[0][2] == ends[1][2] == 20
        assert ends[1][1] < 0.85 * ends[0][1]
    assert apart[0] < 1e-7 and apart[1] < 0.1 * apart[0]


def test_ends_where_the_plain_iteration_ends_in_contact(monkeypatch):
    """Strips that fall on each other, until just after they touch."""
    scene = load_scene("hard/crossing_strips", ["integrator.step=0.001", "integrator.tolerance=1e-7"])
    touched = wo.simulate(scene, device="cpu", until=0.021).history["contact_energy"]
    assert touched.max() > 0.0
    ends = [counted(scene, 0.021, plain, monkeypatch) for plain in (True, False)]
    print([end[1:] for end in ends], np.abs(ends[0][0] - ends[1][0]).max())
    assert ends[0][2] == ends[1][2]
    np.testing.assert_allclose(ends[1][0], ends[0][0], atol=1e-8)


@dataclass
class Spring:
    """q + curvature q^3 / 3 = 1 in each of two unknowns, without strains of its own; counts factorizations."""

    curvature: float
    touching: bool = False
    factorized: int = 0

    def gradient(self, q):
        return q + self.curvature * q**3 / 3.0 - 1.0

    def linearize(self, q):
        self.factorized += 1
        stiffness = 1.0 + self.curvature * q**2
        return self.gradient(q), lambda gradient: -gradient / stiffness

    linearize_mixed = linearize

    def take_strains(self, q):
        pass

    def advance_strains(self, q, step, length):
        pass

    def size(self, step):
        return float(np.abs(step).max())


def test_where_the_last_factor_suffices_there_is_no_other():
    """Nearly linear: one factorization, and the end is that of the exact equation."""
    spring = Spring(1e-2)
    result = mixed_newton.minimize_mixed(spring, np.zeros(2), np.zeros(2), 1e-9)
    assert result.failure is None and result.iterations == spring.factorized == 1
    assert np.abs(spring.gradient(result.q)).max() < mixed_newton.CLOSED_SHARE * 1e-9


def test_where_the_last_factor_does_not_suffice_there_is_another():
    """Strongly curved: steps with the first factor do not fall, and it is Newton's iteration."""
    spring = Spring(50.0)
    result = mixed_newton.minimize_mixed(spring, np.zeros(2), np.zeros(2), 1e-9)
    assert result.failure is None and 2 < result.iterations == spring.factorized < 12
    assert np.abs(spring.gradient(result.q)).max() < 1e-9


def test_goes_on_plainly_where_there_is_no_mixed_factor():
    """A potential without a mixed linearization is minimized all the same."""

    class Quadratic:
        touching = False

        def gradient(self, q):
            return q - 1.0

        def linearize(self, q):
            return q - 1.0, lambda gradient: -gradient

        def linearize_mixed(self, q):
            return None

        def take_strains(self, q):
            pass

        def size(self, step):
            return float(np.abs(step).max())

    result = mixed_newton.minimize_mixed(Quadratic(), np.zeros(2), np.zeros(2), 1e-9)
    assert result.failure is None and result.iterations == 3
    np.testing.assert_allclose(result.q, 1.0)
