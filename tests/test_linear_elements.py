"""Linear elements: plane triangles of constant strain, of order two, that fold along every edge and keep energy."""

import numpy as np
import pytest
from scipy.sparse import identity

import warp_origami as wo
from runs import GRAVITY, film, run, system_of
from warp_origami.model.crossing import find_crossing
from warp_origami.terms.shapes import tabulate

LINEAR = {"elements": "linear"}
EDGE = {"box": [[0.0, 0.0], [0.0, 0.6]]}
GRID = {"nx": 3, "ny": 3, "diagonal": "alternate"}


def largest(matrix):
    return np.abs(matrix.toarray()).max(initial=0.0)


def crumpled(system, size=0.05):
    """Any state of the free coordinates."""
    c = system.constraints
    y = c.left_inverse @ system.q0.ravel() + size * np.random.default_rng(4).normal(size=c.null_space.shape[1])
    return (c.null_space @ y + c.right_inverse @ c.values(0.0)).reshape(-1, 3)


@pytest.mark.parametrize(
    ("support", "driver"),
    [
        ([], []),
        ([{"at": EDGE, "fix": "xyz"}], [{"at": {"near": [0.6, 0.6]}, "translate": [0.1, 0.2, 0.3]}]),
        ([{"at": {"boundary": True}, "fix": "z"}, {"at": EDGE, "fix": "xyz"}], []),
        ([{"at": {"all": True}, "fix": "xy"}], []),
    ],
)
def test_elimination_is_exact(support, driver):
    system = system_of(film(1.0, GRID | {"creases_x": [1]}, support=support, driver=driver, integrator=LINEAR))
    c = system.constraints
    n, ny = c.null_space.shape
    assert np.linalg.matrix_rank(c.equations.toarray(), tol=1e-8) == c.equations.shape[0] == n - ny
    assert largest(c.equations @ c.null_space) < 1e-12
    assert largest(c.equations @ c.right_inverse - identity(n - ny)) < 1e-12
    assert largest(c.left_inverse @ c.null_space - identity(ny)) == 0.0
    np.testing.assert_allclose(c.equations @ system.q0.ravel(), c.values(0.0), atol=1e-12)
    held = {(int(v), k) for p in c.prescribers for v in p.selection.vertices for k in p.components}
    assert ny == 3 * len(system.mesh.vertices) - len(held)


def test_elements_are_plane_triangles():
    """Anywhere in an element the sheet is the plane through its corners."""
    system = system_of(film(1.0, GRID, integrator=LINEAR))
    q = crumpled(system)
    count = len(system.mesh.triangles)
    areas = np.random.default_rng(1).dirichlet(np.ones(3), count)
    table = tabulate(system.mesh, np.arange(count), areas)
    corners = q[system.coordinates.positions[system.mesh.triangles]]
    plane = np.einsum("ek,ekc->ec", areas, corners)
    np.testing.assert_allclose(table.interpolation(system.coordinates) @ q, plane, atol=1e-14)


@pytest.mark.parametrize("model", ["srm", "linear"])
def test_energy_is_that_of_constant_strain(model):
    """Against the formula of the triangle, which has one point of any law: here the energy of the plain one."""
    system = system_of(film(1.0, GRID, {"model": model}, integrator=LINEAR))
    q = system.q0 + 0.0
    q[:, :2] *= 1.01  # taut, so that both laws agree
    q[:, 2] += 0.02 * q[:, 0]
    q = (system.constraints.null_space @ (system.constraints.left_inverse @ q.ravel())).reshape(-1, 3)
    mesh, m = system.mesh, system.scene.material
    flat = mesh.vertices[mesh.triangles]
    deformed = q[system.coordinates.positions[mesh.triangles]]
    f = (np.stack([deformed[:, 1] - deformed[:, 0], deformed[:, 2] - deformed[:, 0]], axis=2)) @ np.linalg.inv(
        np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=2)
    )
    e = 0.5 * (np.einsum("eki,ekj->eij", f, f) - np.eye(2))
    factor = m.youngs_modulus / (1 - m.poisson_ratio**2)
    trace = e[:, 0, 0] + e[:, 1, 1]
    density = 0.5 * factor * (m.poisson_ratio * trace**2 + (1 - m.poisson_ratio) * np.einsum("eij,eij->e", e, e))
    expected = m.thickness * mesh.areas @ density
    assert system.evaluate(q).strain_energy == pytest.approx(expected, rel=1e-12)


def test_mass_is_the_consistent_one():
    """rho h A / 12 between two corners of a triangle, twice that at each."""
    system = system_of(film(1.0, GRID, integrator=LINEAR))
    t = system.constraints.null_space
    mass = (t.T @ system.full_mass @ t).toarray()
    mesh, m = system.mesh, system.scene.material
    expected = np.zeros((len(mesh.vertices), len(mesh.vertices)))
    for triangle, area in zip(mesh.triangles, mesh.areas, strict=True):
        expected[np.ix_(triangle, triangle)] += m.density * m.thickness * area / 12 * (np.ones((3, 3)) + np.eye(3))
    order = np.argsort(system.coordinates.positions)
    np.testing.assert_allclose(mass, np.kron(expected[np.ix_(order, order)], np.eye(3)), atol=1e-14)


def test_frequencies_of_the_drum_are_of_order_two():
    errors = []
    for n in (8, 16):
        scene = wo.load_scene("verification/drum", [f"pattern.nx={n}", f"pattern.ny={n}", "integrator.elements=linear"])
        errors.append(wo.simulate(scene, device="cpu").summary["frequencies"][0] / 31.2744427100334 - 1)
    assert 0.0 < errors[1] < 0.006
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)


def test_a_hanging_sheet_pulls_with_its_weight():
    support = [{"name": "rod", "at": EDGE}]
    result = wo.simulate(
        wo.Scene(
            name="hanging",
            analysis={"kind": "static"},
            pattern={"kind": "sheet", "width": 0.6, "height": 0.6, "nx": 3, "ny": 3},
            material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4},
            support=support,
            load=[{"kind": "gravity", "acceleration": [9.81, 0.0, 0.0]}],
            integrator=LINEAR,
        ),
        device="cpu",
    )
    weight = 1420.0 * 5e-4 * 0.36 * 9.81
    np.testing.assert_allclose(result.reactions["rod"][-1, :3], [-weight, 0.0, 0.0], atol=1e-8 * weight)
    np.testing.assert_allclose(result.reactions["rod"][-1, 5], 0.3 * weight, rtol=1e-6)  # its strain is of that size


def test_both_constraint_forms_give_the_same_motion():
    ends = []
    for form in ("eliminate", "multipliers"):
        settings = LINEAR | {"constraints": form, "step": 2e-3, "spectral_radius": 0.8}
        scene = film(0.02, GRID, {"model": "linear"}, support=[{"at": EDGE}], load=[GRAVITY], integrator=settings)
        ends.append(run(scene).q[-1])
    np.testing.assert_allclose(*ends, atol=1e-9)


def test_the_swinging_sheet_keeps_its_energy():
    """To 1e-4 of m g L / 2 after its free end has whipped, in steps that cubic elements do not bear."""
    changes = ["pattern.nx=24", "pattern.ny=1", "integrator.elements=linear", "integrator.step=5e-4"]
    result = wo.simulate(wo.load_scene("swinging_sheet", changes), device="cpu", until=0.45)
    assert result.history["kinetic_energy"].max() > 0.5
    assert abs(result.history["energy_error"][-1]) < 1e-4 * 0.7523


def test_layers_touch_without_crossing():
    """A corner poked into a stack of layers at 10 m/s."""
    scene = wo.load_scene("hard/poked_stack_10", ["integrator.elements=linear", "output.fields=[]"])
    system = system_of(scene)
    result = run(scene, until=1e-3)
    assert result.history["contact_energy"].max() > 0.0
    assert result.summary["energy_gain"] < 5e-3
    for q in result.q:
        points = q[system.coordinates.positions]
        assert find_crossing(points, system.mesh.edges, system.mesh.triangles) is None


def test_a_hub_goes_with_linear_elements():
    """Elimination stays exact with points that are fixed to a hub, free or held, and a free spin is kept."""
    middle = {"box": [[0.2, 0.2], [0.4, 0.4]]}
    spin = {"kind": "initial_spin", "rate": 3.0, "centre": [0.3, 0.3, 0.0]}
    settings = LINEAR | {"step": 1e-3, "spectral_radius": 0.9}
    for mount in ("free", "axis"):
        hub = {"at": middle, "mass": 0.1, "axial_inertia": 0.01, "mount": mount}
        scene = film(0.05, GRID, load=[spin], hub=hub, integrator=settings)
        c = system_of(scene).constraints
        n, ny = c.null_space.shape
        assert np.linalg.matrix_rank(c.equations.toarray(), tol=1e-8) == c.equations.shape[0] == n - ny
        assert largest(c.equations @ c.null_space) < 1e-12
        assert largest(c.equations @ c.right_inverse - identity(n - ny)) < 1e-12
        assert largest(c.left_inverse @ c.null_space - identity(ny)) == 0.0
        assert c.ties == 3 * 4
        assert abs(run(scene).summary["angular_momentum_change"]) < 1e-6
