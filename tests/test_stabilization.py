"""Reduced integration with stabilization: no deformation is without energy, and bent elements do not lock."""

import numpy as np
import pytest

from membrane_cases import Film, dense_tangent, field_coordinates, square_mesh
from warp_origami.errors import InputError
from warp_origami.model.coordinates import number_coordinates
from warp_origami.scene import load_scene
from warp_origami.terms.membrane import Membrane
from warp_origami.terms.quadrature import STABILIZING_DEGREE, rule, stabilized_rule


def bent_into_an_arc(radius):
    """Isometric: a cylinder about an axis along y."""

    def field(x, y):
        a, zero, one = x / radius, np.zeros_like(x), np.ones_like(x)
        r = np.stack([radius * np.sin(a), y, radius * (1 - np.cos(a))], axis=1)
        return r, np.stack([np.cos(a), zero, np.sin(a)], axis=1), np.stack([zero, one, zero], axis=1)

    return field


def flat(x, y):
    zero, one = np.zeros_like(x), np.ones_like(x)
    return np.stack([x, y, zero], 1), np.stack([one, zero, zero], 1), np.stack([zero, one, zero], 1)


@pytest.mark.parametrize("degree", [1, 2])
def test_energy_is_the_weighted_mean_of_both_rules(degree):
    mesh = square_mesh(3, distortion=0.25)
    coordinates = number_coordinates(mesh)
    q = field_coordinates(mesh, coordinates, bent_into_an_arc(0.2))
    reduced, full, both = (
        Membrane(mesh, coordinates, Film(model="linear"), *options).gradient(q)
        for options in ((degree,), (STABILIZING_DEGREE,), (degree, 0.03))
    )
    assert both[0] == pytest.approx(0.97 * reduced[0] + 0.03 * full[0], rel=1e-12)
    np.testing.assert_allclose(both[1], 0.97 * reduced[1] + 0.03 * full[1], atol=1e-12 * np.abs(full[1]).max())


def test_no_deformation_in_the_plane_is_without_energy():
    """Rank of the tangent of two flat, unstressed triangles: all in-plane coordinates but three rigid motions."""
    mesh = square_mesh(1, distortion=0.0)
    coordinates = number_coordinates(mesh)
    q = field_coordinates(mesh, coordinates, flat)

    def rank(*options):
        _, _, blocks = Membrane(mesh, coordinates, Film(model="linear"), *options).tangent(q)
        values = np.linalg.eigvalsh(dense_tangent(coordinates, blocks))
        return np.count_nonzero(values > 1e-10 * values.max())

    in_plane = 2 * coordinates.count - 3
    assert rank(STABILIZING_DEGREE) == in_plane
    assert rank(1) < rank(2) < in_plane
    assert rank(1, 1e-2) == rank(2, 1e-2) == in_plane


@pytest.mark.parametrize("cells", [2, 3, 4])
def test_bent_elements_lock_less(cells):
    """Bent over a radius of 20 cm, cells of 30, 20 and 15 cm store less than a sixth of what they store otherwise."""
    mesh = square_mesh(cells)
    coordinates = number_coordinates(mesh)
    q = field_coordinates(mesh, coordinates, bent_into_an_arc(0.2))
    locked, _ = Membrane(mesh, coordinates, Film(model="linear"), 6).gradient(q)
    unlocked, _ = Membrane(mesh, coordinates, Film(model="linear"), 2, 1e-2).gradient(q)
    assert unlocked < locked / 6


def test_without_stabilization_the_rule_is_the_reduced_one():
    for mine, plain in zip(stabilized_rule(2, 0.0), rule(2), strict=True):
        assert np.array_equal(mine, plain)


def test_stabilization_of_full_integration_is_refused():
    with pytest.raises(InputError, match=r"integrator\.stabilization: got 0\.01, wants 0 with quadrature = 6"):
        load_scene("swinging_sheet", ["integrator.stabilization=0.01"])
    scene = load_scene("swinging_sheet", ["integrator.stabilization=0.01", "integrator.quadrature=2"])
    assert scene.integrator.stabilization == 0.01
