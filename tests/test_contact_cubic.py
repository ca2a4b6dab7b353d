"""Masters are the cubic elements: where the closest point lies, and forces on all coordinates of an element."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from contact_cases import EPS_S, THICKNESS, TwoSheets, settings, wavy
from contact_meshes import grid
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.contact import Contact
from warp_origami.terms.contact.projection import project
from warp_origami.terms.inertia import mass_matrix
from warp_origami.terms.shapes import tabulate

SIZE = (0.3, 0.3)


@pytest.mark.parametrize("divisions", [1, 4])
def test_sub_triangles_and_projection_find_the_reference_projection(divisions):
    """Over all elements of the layer, each projected on from its middle: the least distance and its point."""
    sheets = TwoSheets(grid(2, 2, SIZE), grid(2, 2, (0.2, 0.2), (0.01, 0.02), 0.3))
    contact = sheets.contact("mixed", divisions=divisions)
    q = wavy(sheets.coordinates, sheets.at(0.5 * THICKNESS), 3, slope=0.02)
    contact.accept(wavy(sheets.coordinates, sheets.at(4 * THICKNESS), 3, slope=0.02))
    contact.gradient(q)
    state, active = contact._surfaces._narrow, contact._surfaces._active
    assert len(active) > 50
    points = (contact._surfaces._interpolation @ q)[contact._surfaces._points.node_count + state.points[active]]
    layers = contact._surfaces._search.layers_of(state.keys[active])
    best, place = np.full(len(active), np.inf), np.zeros((len(active), 3))
    for element, face in enumerate(sheets.mesh.faces):
        mine = np.flatnonzero(layers == face)
        found = project(sheets.mesh, sheets.coordinates, q, points[mine], np.full(len(mine), element))
        closer = found.distances < best[mine]
        best[mine[closer]], place[mine[closer]] = found.distances[closer], found.positions[closer]
    np.testing.assert_allclose(np.abs(state.distances.read()[active]), best, rtol=1e-9)
    rows = sheets.coordinates.elements[state.elements.read()[active]]
    feet = np.einsum("ki,kic->kc", state.shapes.read()[active], q[rows])
    single = np.linalg.norm(feet - place, axis=1) < 1e-3  # not two points at the same distance
    assert single.all()
    np.testing.assert_allclose(feet, place, atol=1e-9 * SIZE[0])


def turned(part):
    """A grid with its diagonals the other way."""
    vertices, triangles = part
    return vertices * [-1.0, 1.0], triangles[:, ::-1]


def acceleration_error(lower, upper, **options):
    """Deviation of M^-1 f from the uniform field of two flat sheets at uniform penetration, in the norm of M."""
    sheets = TwoSheets(lower, upper)
    mass = mass_matrix(sheets.mesh, sheets.coordinates, 1420.0, 5e-4)
    g = 1e-4
    force = -sheets.contact(**options).gradient(sheets.at(THICKNESS - g))[1]
    wanted = np.zeros(len(force))
    wanted[sheets.coordinates.positions] = np.where(sheets.above, 1.0, -1.0)
    error = spsolve(mass.tocsc(), force[:, 2]) * 0.71 / (EPS_S * g) - wanted
    assert np.abs(force[:, :2]).max() < 1e-12 * np.abs(force).max()
    return np.sqrt(error @ mass @ error / (wanted @ mass @ wanted))


@pytest.mark.parametrize(
    ("lower", "upper"),
    [
        (grid(1, 1, SIZE), grid(1, 1, SIZE)),
        (grid(1, 1, SIZE), turned(grid(1, 1, SIZE))),
        (grid(2, 2, SIZE), turned(grid(2, 2, SIZE))),
        (grid(3, 3, SIZE), grid(2, 2, SIZE)),
        (grid(3, 3, SIZE), turned(grid(2, 2, SIZE))),
    ],
    ids=["matching", "turned", "turned fine", "non-matching", "non-matching turned"],
)
def test_uniform_pressure_accelerates_flat_sheets_uniformly(lower, upper):
    """Consistent with the mass on both sides: what is left is the error of integrating over the other's elements."""
    error = acceleration_error(lower, upper)
    finer = acceleration_error(lower, upper, sts_degree=6)
    print(f"{100 * error:.3f} %, with degree 6 {100 * finer:.3f} %")
    assert error < 0.01
    assert finer < 1e-3


def test_sheets_that_start_bent_and_closer_than_the_thickness_start_without_force():
    """The cubic surface bulges out of its sub-triangles: its own distance counts."""
    sheets = TwoSheets(grid(2, 2, SIZE), grid(3, 3, SIZE))
    q = wavy(sheets.coordinates, sheets.at(0.9 * THICKNESS), 1, position=1e-4, slope=5e-3)
    for divisions in (1, 4):
        contact = Contact(sheets.mesh, sheets.coordinates, settings("mixed"), q, divisions=divisions)
        energy, gradient = contact.gradient(q)
        assert energy == 0.0 and not gradient.any()
        assert contact.gradient(q - (sheets.at(2e-4) - sheets.at(0.0)))[0] > 0.0


@pytest.mark.parametrize("divisions", [1, 2, 4])
def test_the_cubic_surface_stays_within_the_bound_of_its_distance_from_sub_triangles(divisions):
    sheets = TwoSheets(grid(2, 2, SIZE), turned(grid(3, 2, SIZE)))
    q = wavy(sheets.coordinates, sheets.at(1.0), 7, slope=0.3)
    contact = sheets.contact(divisions=divisions)
    contact.gradient(q)
    bounds = contact._surfaces._surfaces.masters.errors.numpy()
    sub = build_submesh(sheets.mesh, divisions)
    fine = build_submesh(sheets.mesh, 12 * divisions)
    corners = (tabulate(sheets.mesh, sub.elements, sub.areas).interpolation(sheets.coordinates) @ q)[sub.triangles]
    surface = tabulate(sheets.mesh, fine.elements, fine.areas).interpolation(sheets.coordinates) @ q
    a, b, c = (sub.flat[sub.triangles[:, k]] for k in range(3))
    ratios = []
    system = np.linalg.inv(np.stack([b - a, c - a], axis=2))
    for element in range(len(sheets.mesh.triangles)):
        for t in np.flatnonzero(sub.triangle_elements == element):
            own = np.flatnonzero(fine.elements == element)
            local = (fine.flat[own] - a[t]) @ system[t].T
            weights = np.column_stack([1.0 - local.sum(axis=1), local])
            inside = weights.min(axis=1) > -1e-9
            error = np.linalg.norm(weights[inside] @ corners[t] - surface[own[inside]], axis=1).max()
            assert error <= bounds[element]  # of it and its neighbours
            ratios.append(error / bounds[element])
    assert max(ratios) > 0.5
