"""The equations of motion as a whole: gradients and tangents of all terms together, and what is said to be modelled."""

import numpy as np
import pytest

import warp_origami as wo
from contact_cases import wavy
from runs import GRAVITY, film, system_of
from warp_origami.description import describe
from warp_origami.errors import InputError
from warp_origami.solve.constraint_form import make_constraint_form
from warp_origami.solve.generalized_alpha import GeneralizedAlpha
from warp_origami.solve.step_potential import StepPotential

CORNERS = [[0.3, 0.3], [-0.3, 0.3], [-0.3, -0.3], [0.3, -0.3]]


def leaf_system(method="mixed", thickness=6e-3, constraints="eliminate"):
    """The leaf-in with its corners driven; the stowed layers, some millimetres apart, touch when they wave a little."""
    scene = wo.Scene(
        name="leaf",
        analysis={"kind": "dynamic", "duration": 1.0},
        pattern={"kind": "leaf_in"},
        material={
            "density": 1420.0,
            "youngs_modulus": 2.5e9,
            "poisson_ratio": 0.34,
            "thickness": 5e-4,
            "mass_damping": 1.5,
        },
        contact={"method": method, "thickness": thickness},
        driver=[{"at": {"near": at}, "translate_to": "deployed"} for at in CORNERS],
        load=[GRAVITY],
        integrator={"constraints": constraints},
    )
    return system_of(scene)


def waving(system, time=0.0, seed=0):
    """A folded state within the constraints, taut, wrinkled and slack at once."""
    c = system.constraints
    prescribed = c.right_inverse @ c.values(time)
    q = wavy(system.coordinates, system.q0, seed, position=2e-3, slope=2e-2).ravel()
    return (c.null_space @ (c.left_inverse @ (q - prescribed)) + prescribed).reshape(-1, 3)


def direction(system, seed):
    """A random motion within the constraints, 1 m at most."""
    d = np.random.default_rng(seed).normal(size=system.q0.shape) * system.row_lengths[:, None]
    c = system.constraints
    d = (c.null_space @ (c.left_inverse @ d.ravel())).reshape(d.shape)
    return d / np.abs(d).max()


@pytest.mark.parametrize("method", ["sts", "nts", "mixed"])
@pytest.mark.parametrize("seed", [0, 2])
def test_gradient_is_the_derivative_of_all_energies(method, seed):
    """Membrane and contact in a folded, waving, touching sheet, of which parts are taut, wrinkled and slack."""
    system = leaf_system(method)
    q = waving(system, seed=seed)
    here = system.evaluate(q)
    assert here.contact_energy > 0.0
    assert min(system.membrane.state_fractions(q)) > 0.02
    d = direction(system, seed)
    for h, limit in ((1e-6, 1e-6), (1e-7, 1e-7)):
        after, before = system.evaluate(q + h * d), system.evaluate(q - h * d)
        for name in ("strain_energy", "contact_energy"):
            assert getattr(here, name) != getattr(after, name)
        total = [e.strain_energy + e.contact_energy for e in (after, before)]
        assert abs((total[0] - total[1]) / (2 * h) - np.sum(here.gradient * d)) < limit * abs(np.sum(here.gradient * d))


def touching_lightly(system):
    """A state whose deepest penetration, of facets too, is a tenth of a micrometre: what the contact tangent leaves out
    (the turning of normals, proportional to the penetration) is then small against what it holds."""
    low, high = 0.0, 1.0
    waves = waving(system) - system.q0
    for _ in range(40):
        q = system.q0 + 0.5 * (low + high) * waves
        system.evaluate(q)
        pairs = system.contact.active_pairs()
        depth = np.max(pairs.forces / pairs.stiffness, initial=0.0)
        if 1e-8 < depth < 2e-7:
            return q
        low, high = (0.5 * (low + high), high) if depth == 0.0 else (low, 0.5 * (low + high))
    raise AssertionError("no such state")


@pytest.mark.parametrize("method", ["sts", "nts", "mixed"])
@pytest.mark.parametrize("constraints", ["eliminate", "multipliers"])
def test_newton_direction_fits_the_derivative_of_the_gradient(method, constraints):
    """Along d = -J^-1 grad the gradient within the constraints changes by minus itself: inertia, damping, membrane,
    contact and constraints together."""
    system = leaf_system(method, constraints=constraints)
    q = touching_lightly(system)
    method_of_time = GeneralizedAlpha(0.5)
    v = 0.1 * direction(system, 3)
    start = method_of_time.start(0.0, q, v, np.zeros_like(q), np.zeros_like(q), 1e-5)
    form = method_of_time.form(start, 1e-5)
    potential = StepPotential(system, make_constraint_form(system, system.mass), form, system.external.at(0.0))
    gradient, newton = potential.linearize(q.ravel())
    step = newton(gradient)
    null = system.constraints.null_space
    assert np.abs(system.constraints.equations @ step).max() < 1e-10 * np.abs(step).max()
    free = null.T @ gradient
    h = 1e-7 / potential.size(step)
    change = (potential.gradient(q.ravel() + h * step) - potential.gradient(q.ravel() - h * step)) / (2 * h)
    assert len(system.contact.active_pairs().forces) > 0
    assert np.abs(null.T @ change + free).max() < 1e-6 * np.abs(free).max()


def test_both_constraint_forms_give_the_same_direction():
    """And it does not depend on which unknowns are left: T y here, q and multipliers there."""
    steps = []
    for constraints in ("eliminate", "multipliers"):
        system = leaf_system("sts", constraints=constraints)
        q = waving(system)
        factor = make_constraint_form(system, system.mass).factorize(system.linearize(q), 1e10, 0.0)
        steps.append(factor.direction(system.evaluate(q).gradient.ravel()))
    np.testing.assert_allclose(steps[1], steps[0], atol=1e-10 * np.abs(steps[0]).max())


def test_contact_is_felt_only_where_it_is_asked_for():
    system = leaf_system()
    q = waving(system)
    scene = system.scene.model_copy(update={"contact": None})
    without = system_of(scene)
    assert without.contact is None
    assert without.evaluate(q).contact_energy == 0.0
    assert without.evaluate(q).strain_energy == system.evaluate(q).strain_energy
    assert not np.array_equal(without.evaluate(q).gradient, system.evaluate(q).gradient)


def test_terms_name_what_is_modelled():
    plain = system_of(film(1.0, {}, {"model": "linear"}))
    assert plain.terms == ["membrane (linear)", "inertia"]
    assert not [
        name
        for name in plain.kernel_modules
        if any(word in name for word in ("srm", "point_contact", "facet", "broad"))
    ]
    full = leaf_system("sts")
    names = ["membrane (srm)", "inertia", "mass damping", "contact (sts)", "gravity", "fold lines", "drivers"]
    assert full.terms == names
    modules = " ".join(full.kernel_modules)
    assert "srm" in modules and "broadphase" in modules and "point_contact" in modules and "facet_pairs" not in modules


def test_weight_is_gravity_times_mass_and_follows_its_profile():
    load = {"kind": "gravity", "acceleration": [1.0, -2.0, 3.0], "profile": {"kind": "linear", "end": 0.5}}
    system = system_of(film(1.0, {}, load=[load, GRAVITY]))
    positions = system.coordinates.positions
    mass = 1420.0 * 5e-4 * 0.36
    for time, factor in ((0.0, 0.0), (0.25, 0.5), (0.9, 1.0)):
        expected = mass * np.array([factor, -2.0 * factor, 3.0 * factor - 9.81])
        np.testing.assert_allclose(
            system.external.at(time).dead[positions].sum(axis=0), expected, rtol=1e-12, atol=1e-12
        )


def test_initial_velocity_adds_up_and_yields_to_supports_and_folds():
    pattern = {"creases_x": [1]}
    whole = {"kind": "initial_velocity", "value": [1.0, 0.0, 0.0]}
    right = {"kind": "initial_velocity", "value": [0.0, 0.0, 2.0], "at": {"box": [[0.6, 0.0], [0.6, 0.6]]}}
    left = {"at": {"box": [[0.0, 0.0], [0.0, 0.6]]}, "fix": "x"}
    system = system_of(film(1.0, pattern, load=[whole, right], support=[left]))
    x = system.mesh.vertices[:, 0]
    at_vertices = system.v0[system.coordinates.positions]
    np.testing.assert_allclose(at_vertices[:, 0], np.where(x > 0, 1.0, 0.0), atol=1e-14)
    np.testing.assert_allclose(at_vertices[:, 2], np.where(x > 0.59, 2.0, 0.0), atol=1e-14)
    assert np.abs(system.constraints.equations @ system.v0.ravel()).max() < 1e-13


def test_a_stretched_start_is_the_flat_sheet_scaled():
    system = system_of(film(1.0, {"initial": {"stretch": [1.2, 0.9]}}))
    positions = system.q0[system.coordinates.positions]
    np.testing.assert_allclose(positions[:, :2], system.mesh.vertices * [1.2, 0.9], atol=1e-15)
    gradients = system.coordinates.sector_gradients
    np.testing.assert_allclose(system.q0[gradients], np.tile([1.2, 0, 0], (len(gradients), 1)), atol=1e-15)
    np.testing.assert_allclose(system.q0[gradients + 1], np.tile([0, 0.9, 0], (len(gradients), 1)), atol=1e-15)


def test_layers_that_coincide_are_refused():
    """Two panels folded flat onto each other and a third between: nobody can say which lies above."""
    pattern = {"nx": 3, "ny": 1, "creases_x": [1, 2], "opening": 1e-12}
    with pytest.raises(InputError, match=r"pattern\.initial: .* coincide in unknown order: 3 pairs .* as \d and \d"):
        system_of(film(1.0, pattern, contact={"method": "sts"}))


def test_check_says_what_is_held_and_driven_and_how_far():
    driver = [{"name": "corner", "at": {"near": [0.61, 0.6]}, "axes": "xz", "translate": [0.03, 5.0, 0.04]}]
    lines = dict(describe(film(1.0, {}, support=[{"at": {"box": [[0.0, 0.0], [0.0, 0.6]]}}], driver=driver)))
    assert lines["support.0"] == "3 vertices, x 0 to 0, y 0 to 0.6: holds x, y, z"
    assert lines["corner"] == "vertex 8 at (0.6, 0.6): drives x, z, 0.05 m at the end"
