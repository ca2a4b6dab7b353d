"""What counts as thickness between layers of a folded sheet, and on which side they lie."""

import numpy as np
import pytest

from contact_cases import EPS_S, THICKNESS, TwoSheets, settings
from contact_meshes import cut_square, grid, mesh_of
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.generators.leaf_in import leaf_in
from warp_origami.terms.contact import Contact
from warp_origami.terms.contact.thickness import CREASE_RATIO


class Fold:
    """Two square faces of 0.1 m joined by a crease along x = 0, folded upwards to an angle between them."""

    def __init__(self, n=2):
        self.mesh = mesh_of(*grid(2 * n, n, (0.2, 0.1)), lambda m: np.abs(m[:, 0]) < 1e-9)
        self.coordinates = number_coordinates(self.mesh)

    def at(self, between):
        """q with the faces at an angle `between` (rad), the left one fixed."""
        x, y = self.mesh.vertices.T
        turn = np.pi - between
        right = x > 0
        points = np.stack([np.where(right, x * np.cos(turn), x), y, np.where(right, x * np.sin(turn), 0.0)], axis=1)
        return affine_coordinates(self.mesh, self.coordinates, points)

    def contact(self, start, method="mixed"):
        return Contact(self.mesh, self.coordinates, settings(method), self.at(start))


@pytest.mark.parametrize("method", ["sts", "nts", "mixed"])
def test_leaf_in_starts_without_contact_force(method):
    pattern = leaf_in()
    coordinates = number_coordinates(pattern.mesh)
    q = affine_coordinates(pattern.mesh, coordinates, pattern.stowed)
    contact = Contact(pattern.mesh, coordinates, settings(method, 5e-4), q, pattern.face_orders, pattern.pattern_faces)
    energy, gradient = contact.gradient(q)
    assert energy == 0.0 and not gradient.any()
    assert len(contact.coincident_layers) == 0
    assert contact.statistics().max_penetration == 0.0
    assert contact.summary().pairs > 100


def test_summary_names_what_the_crease_rule_weakens():
    summary = Fold().contact(np.pi).summary()
    assert summary.layers == 2 and summary.divisions == 4
    np.testing.assert_array_equal(summary.crease_neighbours, [[0, 1]])
    assert len(summary.vertex_neighbours) == 0
    assert summary.weakened_by_crease > 0 and summary.left_out == 0


def test_folding_up_meets_no_force_until_the_distance_is_the_effective_thickness():
    """Near the crease c s counts: sin(angle) = c is where the two faces touch along their whole length at once."""
    fold = Fold()
    contact = fold.contact(np.pi)
    touch = np.arcsin(CREASE_RATIO)
    for between in np.linspace(np.pi, 1.001 * touch, 80):
        contact.accept(fold.at(between))
        if 0.1 * np.sin(between) > THICKNESS:
            assert contact.gradient(fold.at(between))[0] == 0.0
    assert contact.gradient(fold.at(0.97 * touch))[0] > 0.0


def test_effective_thickness_of_points_near_a_crease():
    """min(h, c s) at every slave point of one face with respect to the other."""
    fold = Fold()
    contact = fold.contact(np.pi)
    points, table = contact._surfaces._points, contact._surfaces._table
    slaves = np.arange(points.slave_count)
    x = points.flat[points.node_count :, 0]
    layer = np.where(x > 0, fold.mesh.faces[fold.mesh.vertices[fold.mesh.triangles].mean(axis=1)[:, 0] < 0][0], 0)
    right = x > 1e-9
    values = table.of(contact._surfaces._search.key_of(slaves[right], layer[right]))
    np.testing.assert_allclose(values, np.minimum(THICKNESS, CREASE_RATIO * x[right]), rtol=1e-9)


def test_a_closed_fold_is_kept_apart():
    """Folded together through the stop, the faces are pushed open again."""
    fold = Fold()
    contact = fold.contact(np.pi)
    for between in np.linspace(np.pi, 1.2 * CREASE_RATIO, 60):
        contact.accept(fold.at(between))
    for share in (0.6, 0.2, -0.1):
        between = share * CREASE_RATIO
        _, gradient = contact.gradient(fold.at(between))
        opening = fold.at(between + 1e-6) - fold.at(between)
        assert -np.vdot(gradient, opening) > 0


def test_layers_stowed_closer_than_the_thickness_start_without_force():
    """Their stowed distance counts: force only when they come closer than they were."""
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(2, 2, (0.3, 0.3)))
    d = 0.3 * THICKNESS
    contact = sheets.contact("sts", start=d)
    assert contact.gradient(sheets.at(d))[0] == 0.0
    g = 0.4 * d
    assert sheets.force(contact, sheets.at(d - g))[2] == pytest.approx(EPS_S * g * 0.09, rel=1e-6)
    assert contact.summary().weakened_by_start > 0


def test_separate_sheets_do_not_know_each_others_flat_distance():
    """Two sheets that are drawn side by side, even over each other, are at full thickness."""
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(2, 2, (0.3, 0.3)))
    sheets.mesh.vertices[sheets.above, 0] -= sheets.shift - 0.003
    sheets.shift = 0.003
    contact = sheets.contact("sts")
    assert contact.summary().weakened_by_crease == 0
    assert sheets.force(contact, sheets.at(0.9 * THICKNESS))[2] > 0


def test_coincident_layers_are_reported():
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(2, 2, (0.3, 0.3)))
    contact = sheets.contact("mixed", start=0.0)
    np.testing.assert_array_equal(contact.coincident_layers, [[0, 1]])
    assert len(sheets.contact("mixed", start=1e-5).coincident_layers) == 0


@pytest.mark.parametrize("above", [1, -1])
@pytest.mark.parametrize("given", ["of the upper", "of the lower"])
def test_face_orders_say_which_of_coincident_layers_lies_above(above, given):
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(2, 2, (0.3, 0.3)))
    faces = sheets.above[sheets.mesh.triangles[:, 0]].astype(int)
    order = [[1, 0, above]] if given == "of the upper" else [[0, 1, -above]]
    contact = sheets.contact("sts", start=0.0, face_orders=np.array(order), pattern_faces=faces)
    assert len(contact.coincident_layers) == 0
    assert contact.gradient(sheets.at(0.0))[0] == 0.0
    assert contact.gradient(sheets.at(above * 1e-4))[0] == 0.0
    g = 1e-4
    assert sheets.force(contact, sheets.at(-above * g))[2] == pytest.approx(above * EPS_S * g * 0.09, rel=1e-6)
    contact.accept(sheets.at(-above * g))
    assert sheets.force(contact, sheets.at(-above * g))[2] == pytest.approx(above * EPS_S * g * 0.09, rel=1e-6)


def test_lips_of_a_cut_do_not_coincide(tmp_path):
    """The two sides of a cut touch along a line; no layer lies on another, and nothing pushes them apart."""
    mesh = cut_square(tmp_path)
    coordinates = number_coordinates(mesh)
    flat = affine_coordinates(mesh, coordinates, np.pad(mesh.vertices, ((0, 0), (0, 1))))
    contact = Contact(mesh, coordinates, settings("mixed"), flat)
    assert len(np.unique(mesh.faces)) == 2
    assert len(contact.coincident_layers) == 0
    assert contact.gradient(flat)[0] == 0.0
