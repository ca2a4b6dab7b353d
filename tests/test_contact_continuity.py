"""Contact along a motion: thickness that layers get back, gaps and forces that do not jump, nothing counted twice."""

import numpy as np
import pytest

from contact_cases import EPS_S, THICKNESS, TwoSheets
from contact_meshes import grid

# Layers that start closer than the thickness ------------------------------------------------------------------------

AREA = 0.09


def close_sheets(method="sts", start=0.3 * THICKNESS, angle=0.0):
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(2, 2, (0.3, 0.3), angle=angle))
    return sheets, sheets.contact(method, start=start)


@pytest.mark.parametrize("start", [0.0, 1e-9, 0.3 * THICKNESS])
def test_layers_get_their_thickness_back_as_they_move_apart(start):
    """What they have been apart counts, up to the thickness; moving apart meets and stores nothing."""
    orders = {"face_orders": np.array([[1, 0, 1]]), "pattern_faces": np.repeat([0, 1], 8)}
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(2, 2, (0.3, 0.3)))
    contact = sheets.contact("sts", start=start, **orders)
    for height, thickness in ((0.5, 0.5), (0.4, 0.5), (0.9, 0.9), (0.2, 0.9), (3.0, 1.0), (100.0, 1.0), (0.6, 1.0)):
        contact.accept(sheets.at(height * THICKNESS))
        depth = 0.1 * THICKNESS
        force = sheets.force(contact, sheets.at(thickness * THICKNESS - depth))[2]
        assert force == pytest.approx(EPS_S * depth * AREA, rel=1e-6), height
        energy = contact.gradient(sheets.at(thickness * THICKNESS))[0]
        assert energy < 1e-12 * EPS_S * THICKNESS**2 * AREA


def test_what_touches_gets_nothing_back():
    """On the wrong side too, however deep: it is pushed back to where it came from."""
    sheets, contact = close_sheets()
    for height in (0.2, -0.1, -0.9, 0.1):
        contact.accept(sheets.at(height * THICKNESS))
        depth = 0.2 * THICKNESS
        force = sheets.force(contact, sheets.at(0.3 * THICKNESS - depth))[2]
        assert force == pytest.approx(EPS_S * depth * AREA, rel=1e-6), height


def test_edges_get_their_thickness_back():
    sheets = TwoSheets(grid(1, 1, (0.4, 0.05)), grid(1, 1, (0.4, 0.05), angle=1.0))
    contact = sheets.contact("mixed", start=0.3 * THICKNESS)
    contact.gradient(sheets.at(0.8 * THICKNESS))
    assert contact.statistics().contacts_edge == 0
    for height in (0.6, 2.0):
        contact.accept(sheets.at(height * THICKNESS))
        contact.gradient(sheets.at(0.8 * min(height, 1.0) * THICKNESS))
        assert contact.statistics().contacts_edge == 4
        assert contact.statistics().max_penetration == pytest.approx(0.2 * min(height, 1.0) * THICKNESS, rel=1e-6)


def test_a_restored_state_has_the_same_thickness():
    sheets, one = close_sheets("mixed", angle=0.3)
    one.accept(sheets.at(0.7 * THICKNESS))
    other = sheets.contact("mixed", start=0.3 * THICKNESS)
    other.restore({name: np.array(values) for name, values in one.state().items()})
    for height in (0.6, 0.1):
        a, b = (contact.gradient(sheets.at(height * THICKNESS)) for contact in (one, other))
        assert a[0] == b[0] > 0.0 and np.array_equal(a[1], b[1])
