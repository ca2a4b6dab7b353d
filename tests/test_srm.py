"""The stiffness reduction model against the paper's principal formulas, its own derivatives, and at its switches."""

import numpy as np
import pytest
import warp as wp
from warp_origami.kernels import linear, srm
from warp_origami.kernels.precision import mat33, real, vec3

E, NU = 2.5e9, 0.34


def evaluator(law):
    """Kernel that evaluates a law at each strain."""
    Parameters, law_tangent, law_stress, law_state = law.Parameters, law.tangent, law.stress, law.state

    @wp.kernel(enable_backward=False, module="unique")
    def evaluate_law(
        parameters: Parameters,
        strains: wp.array(dtype=vec3),
        # out
        energy: wp.array(dtype=real),
        stress: wp.array(dtype=vec3),
        stress_only: wp.array(dtype=vec3),
        tangent: wp.array(dtype=mat33),
        state: wp.array(dtype=wp.int32),
    ):
        """The law at each strain, one thread per strain."""
        i = wp.tid()
        w, s, c = law_tangent(parameters, strains[i])
        energy[i] = w
        stress[i] = s
        tangent[i] = c
        _, alone = law_stress(parameters, strains[i])
        stress_only[i] = alone
        state[i] = law_state(parameters, strains[i])

    return evaluate_law


EVALUATORS = {law: evaluator(law) for law in (srm, linear)}


def evaluate(strains, s1=1e-4, s2=1e-4, law=srm):
    """Energy (n,), stress (n, 3), tangent (n, 3, 3), state (n,)."""
    strains = np.ascontiguousarray(np.atleast_2d(strains), dtype=float)
    n = len(strains)
    out = [np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3, 3)), np.zeros(n, dtype=np.int32)]
    types = [real, vec3, vec3, mat33, wp.int32]
    arrays = [wp.array(a, dtype=t, device="cpu", copy=False) for a, t in zip(out, types, strict=True)]
    inputs = [law.parameters(E, NU, s1, s2), wp.array(strains, dtype=vec3, device="cpu")]
    wp.launch(EVALUATORS[law], dim=n, inputs=inputs, outputs=arrays, device="cpu")
    assert np.array_equal(out[1], out[2]), "stress() and tangent() must give the same stress"
    return out[0], out[1], out[3], out[4]


def paper_law(strain, s1, s2):
    """(9)-(15), (20) written with NumPy's eigenvectors: energy, stress, state."""
    tensor = np.array([[strain[0], strain[2] / 2], [strain[2] / 2, strain[1]]])
    (g2, g1), vectors = np.linalg.eigh(tensor)
    if g2 + NU * g1 >= 0:
        gamma, state = E / (1 - NU**2) * np.array([[1, NU], [NU, 1]]), 2
    elif g1 + s1 * NU * g2 > 0:
        gamma, state = E / (1 - s1 * NU**2) * np.array([[1, s1 * NU], [s1 * NU, s1]]), 1
    else:
        gamma, state = E / (1 - s1 * s2 * NU**2) * np.array([[s2, s1 * s2 * NU], [s1 * s2 * NU, s1]]), 0
    t = gamma @ [g1, g2]
    s = t[0] * np.outer(vectors[:, 1], vectors[:, 1]) + t[1] * np.outer(vectors[:, 0], vectors[:, 0])
    return 0.5 * t @ [g1, g2], np.array([s[0, 0], s[1, 1], s[0, 1]]), state


def in_the_plane(g1, g2, angle):
    """Strain (E11, E22, 2 E12) with given principal values and direction."""
    mean, half = (g1 + g2) / 2, (g1 - g2) / 2
    return np.stack(
        [mean + half * np.cos(2 * angle), mean - half * np.cos(2 * angle), 2 * half * np.sin(2 * angle)], -1
    )


def strains_of(state, count=200, seed=0, scale=1e-3, s1=1e-4):
    """Random strains well inside one state."""
    rng = np.random.default_rng(seed)
    big, fraction, angle = scale * rng.uniform(0.1, 1.0, count), rng.uniform(0.05, 0.9, count), rng.uniform(0, 7, count)
    if state == "taut":
        return in_the_plane(big, big * (fraction * (1 + NU) - NU), angle)
    if state == "wrinkled":
        return in_the_plane(big, -big * NU - big * fraction, angle)
    return in_the_plane(-big * fraction, -big, angle)


RATIOS = [(1e-4, 1e-4), (1e-2, 1e-2), (1.0, 1.0), (1e-2, 1e-3), (1e-3, 1e-1)]
STATES = {"slack": 0, "wrinkled": 1, "taut": 2}


@pytest.mark.parametrize(("s1", "s2"), RATIOS)
@pytest.mark.parametrize("name", STATES)
def test_energy_stress_and_state_are_the_papers(name, s1, s2):
    strains = strains_of(name)
    energy, stress, _, state = evaluate(strains, s1, s2)
    for strain, w, s, k in zip(strains, energy, stress, state, strict=True):
        expected_w, expected_s, expected_state = paper_law(strain, s1, s2)
        assert k == expected_state == STATES[name]
        assert abs(w - expected_w) < 1e-13 * expected_w
        np.testing.assert_allclose(s, expected_s, atol=1e-13 * np.abs(expected_s).max() + 1e-16 * E * 1e-3)


@pytest.mark.parametrize(("s1", "s2"), RATIOS)
@pytest.mark.parametrize("name", STATES)
def test_stress_is_the_gradient_of_the_energy_and_the_tangent_that_of_the_stress(name, s1, s2):
    strains = strains_of(name)
    _, stress, tangent, _ = evaluate(strains, s1, s2)
    h = 1e-9
    for k in range(3):
        step = h * np.eye(3)[k]
        w_plus, s_plus, _, _ = evaluate(strains + step, s1, s2)
        w_minus, s_minus, _, _ = evaluate(strains - step, s1, s2)
        largest = np.abs(stress).max(axis=1)
        assert (np.abs((w_plus - w_minus) / (2 * h) - stress[:, k]) / largest).max() < 1e-6
        largest = np.abs(tangent).max(axis=(1, 2))
        error = np.abs((s_plus - s_minus) / (2 * h) - tangent[:, :, k]).max(axis=1) / largest
        assert error.max() < 1e-6
    assert np.array_equal(tangent, tangent.transpose(0, 2, 1))


@pytest.mark.parametrize("s", [1e-4, 1e-2, 1.0])
@pytest.mark.parametrize("g", [1e-3, 1e-9, -1e-9, -1e-3])
def test_equal_principal_strains_have_an_isotropic_tangent(g, s):
    """There sqrt(d) of (10) is not differentiable, but the law with s1 = s2 is."""
    _, stress, tangent, _ = evaluate([g, g, 0.0], s, s)
    ratio, nu = (1.0, NU) if g > 0 else (s, s * NU)
    modulus = ratio * E / (1 - nu**2)
    expected = modulus * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    np.testing.assert_allclose(tangent[0], expected, rtol=1e-13, atol=1e-13 * modulus)
    np.testing.assert_allclose(stress[0], modulus * (1 + nu) * g * np.array([1, 1, 0]), rtol=1e-13)


@pytest.mark.parametrize("s", [1e-4, 1e-2])
@pytest.mark.parametrize("g", [1e-3, -1e-3])
def test_the_tangent_is_continuous_at_equal_principal_strains(g, s):
    _, _, equal, _ = evaluate([g, g, 0.0], s, s)
    for distance in (1e-12, 1e-16, 1e-19):
        for angle in (0.0, 0.4, 1.1):
            _, _, near, _ = evaluate(in_the_plane(g + distance, g - distance, angle), s, s)
            np.testing.assert_allclose(near, equal, atol=1e-12 * np.abs(equal).max())


@pytest.mark.parametrize(("s1", "s2"), RATIOS)
@pytest.mark.parametrize("scale", [0.0, 1e-320, 1e-200, 1e-150, 1e-17])
def test_everything_is_finite_near_zero_strain(scale, s1, s2):
    directions = np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 1], [-1, -1, 0], [1, -1, 0.3], [-1, -2, 1.0]])
    energy, stress, tangent, _ = evaluate(scale * directions, s1, s2)
    assert np.isfinite(energy).all() and np.isfinite(stress).all() and np.isfinite(tangent).all()
    assert np.abs(stress).max() <= 4 * E * scale
    assert np.abs(tangent).max() < 1e12 * E


def test_the_kink_of_unequal_ratios_is_bounded():
    """With s1 != s2 the slack law has no derivative at g1 = g2 < 0; stress and tangent stay finite there."""
    g = -1e-3
    at, near = np.array([g, g, 0.0]), in_the_plane(g * (1 - 1e-13), g * (1 + 1e-13), 0.3)
    _, stress, tangent, _ = evaluate([at, near], 1e-2, 1e-3)
    assert np.abs(stress).max() < 1e-2 * E * 2e-3
    assert np.isfinite(tangent).all()


@pytest.mark.parametrize(("s1", "s2"), RATIOS)
def test_energy_and_stress_are_continuous_over_both_switches(s1, s2):
    """Uniaxial tension lies on f1 = 0; the jump must vanish with the distance to the switch, at every direction."""
    angle = np.linspace(0, 3, 7)
    g = np.full(7, 1e-3)
    for switch in ("f1", "f2"):
        for distance in (1e-6, 1e-9, 1e-12):
            if switch == "f1":
                sides = [in_the_plane(g, -NU * g + sign * distance, angle) for sign in (1, -1)]
            else:
                sides = [in_the_plane(s1 * NU * g + sign * distance, -g, angle) for sign in (1, -1)]
            (w_a, s_a, _, k_a), (w_b, s_b, _, k_b) = (evaluate(side, s1, s2) for side in sides)
            assert (k_a != k_b).all()
            assert np.abs(s_a - s_b).max() < 3 * E * distance + 1e-15 * E * 1e-3
            assert np.abs(w_a - w_b).max() < 3 * E * 1e-3 * distance + 1e-15 * E * 1e-6


def test_the_law_does_not_depend_on_the_axes():
    g1, g2 = 1e-3, -7e-4
    energy, stress, _, _ = evaluate(in_the_plane(np.full(9, g1), np.full(9, g2), np.linspace(0, 3, 9)))
    np.testing.assert_allclose(energy, energy[0], rtol=1e-13)
    trace, determinant = stress[:, 0] + stress[:, 1], stress[:, 0] * stress[:, 1] - stress[:, 2] ** 2
    np.testing.assert_allclose(trace, trace[0], rtol=1e-13)
    np.testing.assert_allclose(determinant, determinant[0], atol=1e-13 * trace[0] ** 2)


def test_ratios_of_one_give_the_linear_law():
    strains = np.concatenate([strains_of(name) for name in STATES])
    for a, b in zip(evaluate(strains, 1.0, 1.0)[:3], evaluate(strains, law=linear)[:3], strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-13, atol=1e-13 * np.abs(b).max())
    assert (evaluate(strains, law=linear)[3] == 2).all()


def test_no_constant_is_single_precision():
    """Poisson's ratio and strains that float32 would truncate, to the last digits of float64."""
    strain = np.array([1e-3 / 3, 1e-3 / 7, 1e-3 / 11])
    for law, ratios in ((srm, (1e-2 / 3, 1e-2 / 3)), (linear, (1.0, 1.0))):
        energy, stress, tangent, _ = evaluate(strain, *ratios, law=law)
        expected_w, expected_s, _ = paper_law(strain, *ratios)
        assert abs(energy[0] - expected_w) < 1e-15 * expected_w * 4
        np.testing.assert_allclose(stress[0], expected_s, rtol=1e-14)
        modulus = E / (1 - NU**2)
        exact = modulus * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]])
        np.testing.assert_allclose(tangent[0], exact, atol=1e-15 * modulus)
