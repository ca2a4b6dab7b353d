"""Where the mixed iteration linearizes the law next: the point of the law near the strain and the stress of a step."""

import numpy as np
import warp as wp
from warp_origami.kernels import linear, srm
from warp_origami.kernels.precision import mat33, vec3

E, NU = 2.5e9, 0.34
MODULUS = 0.01 * E / (1 - NU**2)


def evaluator(law):
    """Kernel that takes steps from `at` to `to`."""
    Parameters, law_tangent = law.Parameters, law.tangent
    law_stress, law_next_strain = law.stress, law.next_strain

    @wp.kernel(enable_backward=False, module="unique")
    def take_steps(
        parameters: Parameters,
        at: wp.array(dtype=vec3),
        to: wp.array(dtype=vec3),
        # out
        following: wp.array(dtype=vec3),
        stress: wp.array(dtype=vec3),
        tangent: wp.array(dtype=mat33),
        following_stress: wp.array(dtype=vec3),
    ):
        """One thread per step."""
        i = wp.tid()
        _, s, c = law_tangent(parameters, at[i])
        stress[i] = s
        tangent[i] = c
        e = law_next_strain(parameters, at[i], to[i])
        following[i] = e
        _, following_s = law_stress(parameters, e)
        following_stress[i] = following_s

    return take_steps


EVALUATORS = {law: evaluator(law) for law in (srm, linear)}


def take(law, at, to, s1=1e-4, s2=1e-4):
    """Next strains, the stress that the law linearized at `at` gives `to`, the stress of the next strains; (n, 3)."""
    n = len(at)
    out = [wp.zeros(n, dtype=t, device="cpu") for t in (vec3, vec3, mat33, vec3)]
    inputs = [law.parameters(E, NU, s1, s2), *(wp.array(a, dtype=vec3, device="cpu") for a in (at, to))]
    wp.launch(EVALUATORS[law], dim=n, inputs=inputs, outputs=out, device="cpu")
    following, stress, tangent, following_stress = (a.numpy() for a in out)
    return following, stress + np.einsum("nij,nj->ni", tangent, to - at), following_stress


def as_strain(stress):
    """(S11, S22, 2 S12)."""
    return stress * [1.0, 1.0, 2.0]


def random_strains(seed, n=3000):
    """Strains of all sizes from 1e-7 to 1e-2."""
    rng = np.random.default_rng(seed)
    return 10.0 ** rng.uniform(-7, -2, (n, 1)) * rng.normal(size=(n, 3))


def test_strain_and_stress_together_lead_to_the_next_strain():
    """e + S(e) / m = e' + s' / m, from every state to every state, but for the kink of the slack law with s1 != s2."""
    at, to = random_strains(1), random_strains(2)
    for s1, s2 in ((1e-4, 1e-4), (1e-2, 1e-4), (1.0, 1.0)):
        following, led_to, stress = take(srm, at, to, s1, s2)
        wanted = to + as_strain(led_to) / MODULUS
        largest = E / MODULUS * np.abs(np.hstack([at, to])).max(axis=1, keepdims=True)
        found = (following + as_strain(stress) / MODULUS - wanted) / largest
        difference = np.hypot(following[:, 0] - following[:, 1], following[:, 2])
        smooth = difference > 1e-9 * np.abs(following).max(axis=1)
        assert smooth.all() or s1 != s2
        assert smooth.mean() > 0.8 and np.abs(found[smooth]).max() < 1e-13


def test_a_state_of_the_law_stays():
    """Where the iteration has converged it is that of the law itself."""
    strains = random_strains(3)
    following, _, _ = take(srm, strains, strains)
    np.testing.assert_allclose(following, strains, atol=1e-12 * np.abs(strains).max(axis=1).max())
    size = np.abs(strains).max(axis=1, keepdims=True)
    assert (np.abs(following - strains) / size).max() < 1e-11


def test_without_states_it_is_the_strain_of_the_step():
    at, to = random_strains(4), random_strains(5)
    assert np.array_equal(take(linear, at, to)[0], to)
    following, _, _ = take(srm, at, to, 1.0, 1.0)
    assert (np.abs(following - to).max(axis=1) / np.abs(np.hstack([at, to])).max(axis=1)).max() < 1e-11
