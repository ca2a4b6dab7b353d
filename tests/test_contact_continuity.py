"""Contact along a motion: thickness that layers get back, gaps and forces that do not jump, nothing counted twice."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact_cases import EPS_N, EPS_S, THICKNESS, TwoSheets, settings, wavy
from contact_meshes import grid
from warp_origami.model.coordinates import affine_coordinates
from warp_origami.terms.contact import Contact

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


def turned_about(axis, angle):
    """Rotation matrix."""
    return Rotation.from_rotvec(angle * np.asarray(axis)).as_matrix()


# Over borders, around corners, across creases -------------------------------------------------------------------------


def flat(start, end, height=0.6 * THICKNESS):
    """A small sheet dragged over a large one from one place to another, in the plane."""
    sheets = TwoSheets(grid(3, 3, (0.1, 0.1)), grid(1, 1, (0.02, 0.02), angle=0.3))
    start, end = np.array(start), np.array(end)
    return sheets, lambda s: sheets.at(height, *(start + s * (end - start)))


def round_the_rim():
    """A small sheet carried round the rim of a large one, from over it to under it."""
    sheets = TwoSheets(grid(2, 2, (0.1, 0.1)), grid(1, 1, (0.02, 0.02), angle=0.3))
    half, radius = 0.05, 0.6 * THICKNESS

    def at(s):
        turn = np.pi * s
        q = sheets.at(0.0)
        upper = np.unique(sheets.coordinates.elements[sheets.above[sheets.mesh.triangles[:, 0]]])
        q[upper] = q[upper] @ turned_about([0.0, 1.0, 0.0], turn).T
        points = sheets.coordinates.positions[sheets.above]
        # a place beside its middle stays next to the rim
        c, s = np.cos(turn), np.sin(turn)
        q[points] += [half - 0.005 * c + radius * s, 0.0, 0.005 * s + radius * c]
        return q

    return sheets, at


def across_a_crease(slope):
    """A small sheet dragged over the crease between two faces: a ridge, a valley, or none."""
    lower = grid(4, 2, (0.1, 0.1))
    sheets = TwoSheets(lower, grid(1, 1, (0.02, 0.02), angle=0.3), lambda m: np.abs(m[:, 0]) < 1e-9)

    def at(s):
        q = sheets.at(0.6 * THICKNESS, 0.008 * (s - 0.5))
        low = np.unique(sheets.coordinates.elements[~sheets.above[sheets.mesh.triangles[:, 0]]])
        points = np.pad(sheets.mesh.vertices, ((0, 0), (0, 1)))
        points[:, 2] = -slope * np.abs(points[:, 0])
        bent = affine_coordinates(sheets.mesh, sheets.coordinates, points)
        q[low] = bent[low]
        return q

    return sheets, at


PATHS = {
    "borders of elements": lambda: flat([-0.03, -0.02], [-0.022, -0.016]),
    "outer edge": lambda: flat([0.056, 0.003], [0.064, 0.004]),
    "corner": lambda: flat([0.052, 0.058], [0.058, 0.052]),
    "along an edge": lambda: flat([0.0603, -0.003], [0.0603, 0.003]),
    "round the rim": round_the_rim,
    "flat crease": lambda: across_a_crease(0.0),
    "ridge": lambda: across_a_crease(0.02),
    "valley": lambda: across_a_crease(-0.02),
}


def steps_of_force(path, method, count):
    """Force on the small sheet along a path in `count` steps, N, and its largest change in a step."""
    sheets, at = PATHS[path]()
    start = at(0.0)
    start[sheets.coordinates.positions[sheets.above], 2] += 4.0 * THICKNESS
    contact = Contact(sheets.mesh, sheets.coordinates, settings(method), start)
    forces = []
    for s in np.linspace(0.0, 1.0, count + 1):
        q = at(s)
        forces.append(sheets.force(contact, q))
        contact.accept(q)
    forces = np.array(forces)
    return forces, np.linalg.norm(np.diff(forces, axis=0), axis=1).max()


@pytest.mark.parametrize("path", PATHS)
def test_the_force_does_not_jump(path):
    """Changes fall with the step, all of them: a jump anywhere on the way would stay as large as it is."""
    forces, coarse = steps_of_force(path, "mixed", 48)
    _, fine = steps_of_force(path, "mixed", 384)
    print(f"{path}: force up to {np.abs(forces).max():.3g} N, changes {coarse:.3g} N in 48 steps, {fine:.3g} N in 384")
    assert fine < 0.25 * coarse


def test_a_flat_crease_presses_twice_in_a_narrow_band_only():
    """Where it is nearer than the thickness to the crease a point has a gap to both faces.

    That is as if there were more of the sheet: 4/3 sqrt(2 h g) times the length of the crease, for small depths g.
    """
    depth = 0.1 * THICKNESS
    z = THICKNESS - depth
    width = np.sqrt(THICKNESS**2 - z**2)
    band = 2.0 * z * (THICKNESS * np.arcsinh(width / z) - width) / depth  # integral of (h / r - 1) z
    assert band == pytest.approx(4.0 / 3.0 * np.sqrt(2.0 * THICKNESS * depth), rel=0.06)
    small = grid(1, 1, (0.02, 0.02))
    lower = grid(2, 1, (0.1, 0.1))
    plain = TwoSheets(lower, small)
    creased = TwoSheets(lower, small, lambda m: np.abs(m[:, 0]) < 1e-9)
    spacing = 0.02 / 4
    forces = []
    for sheets in (plain, creased):
        contact = sheets.contact("nts")  # forces on its nodes, averaged over their places between two of them
        places = (np.arange(400) + 0.5) / 400 * spacing
        forces.append(np.mean([sheets.force(contact, sheets.at(THICKNESS - depth, dx))[2] for dx in places]))
    rows = 5  # nodes in a line along the crease, one line per spacing
    excess = (forces[1] - forces[0]) / (EPS_N * depth * rows)
    assert excess * spacing == pytest.approx(band, rel=0.01)


# Turned meshes --------------------------------------------------------------------------------------------------------


def some_motion(seed):
    rng = np.random.default_rng(seed)
    return Rotation.random(random_state=rng.integers(1 << 30)).as_matrix(), rng.normal(size=3)


@pytest.mark.parametrize("method", ["sts", "nts", "mixed"])
def test_contact_turns_with_the_sheets(method):
    """Turned and moved in space: the same energy and turned forces, for sheets that cross at an angle."""
    sheets = TwoSheets(grid(2, 1, (0.4, 0.05)), grid(3, 1, (0.4, 0.05), angle=0.8))
    far, near = sheets.at(4 * THICKNESS), wavy(sheets.coordinates, sheets.at(0.5 * THICKNESS), 3)
    contact = sheets.contact(method)
    contact.accept(far)
    energy, gradient = contact.gradient(near)
    rotation, shift = some_motion(5)
    still = np.zeros((len(near), 1))
    still[sheets.coordinates.positions] = 1.0
    moved = Contact(sheets.mesh, sheets.coordinates, settings(method), far @ rotation.T + still * shift)
    again, turned = moved.gradient(near @ rotation.T + still * shift)
    assert again == pytest.approx(energy, rel=1e-9)
    np.testing.assert_allclose(turned, gradient @ rotation.T, atol=1e-9 * np.abs(gradient).max())


@pytest.mark.parametrize("cells, angle", [(3, 0.0), (3, np.pi / 2), (5, 0.0), (4, np.pi)])
def test_impact_of_meshes_that_do_not_match_turned_in_space(cells, angle):
    """Half a sine of duration pi sqrt(m / (2 eps)), v sqrt(m / (2 eps)) deep, in whatever direction they meet."""
    sheets = TwoSheets(grid(2, 2, (0.3, 0.3)), grid(cells, cells, (0.3, 0.3), angle=angle))
    rotation, shift = some_motion(cells)
    still = np.zeros((sheets.coordinates.count, 1))
    still[sheets.coordinates.positions] = 1.0
    normal = rotation @ [0.0, 0.0, 1.0]

    def at(height):
        return sheets.at(height) @ rotation.T + still * shift

    contact = Contact(sheets.mesh, sheets.coordinates, settings("sts"), at(0.01))
    m, v, area = 0.71, 1.0, 0.09
    duration, deepest = np.pi * np.sqrt(m / (2 * EPS_S)), v * np.sqrt(m / (2 * EPS_S))
    h, height, speed, least, time = duration / 200, THICKNESS, -v, 0.0, 0.0
    while height <= THICKNESS + 1e-12 and time < 2 * duration:
        for share in (0.0, 1.0):
            height += share * h * speed
            speed += 0.5 * h * 2 * (sheets.force(contact, at(height)) @ normal) / (m * area)
        least, time = max(least, THICKNESS - height), time + h
    assert time == pytest.approx(duration, rel=0.01)
    assert least == pytest.approx(deepest, rel=2e-3)
    assert speed == pytest.approx(v, rel=2e-3)
