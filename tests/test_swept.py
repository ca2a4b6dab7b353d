"""The swept test: no vertex passes through a triangle, no edge through an edge unseen; nothing else is reported."""

from itertools import pairwise

import ipctk
import numpy as np
import pytest
import warp as wp
from warp_origami.kernels import swept
from warp_origami.kernels.precision import real, vec3

from contact_cases import TwoSheets
from contact_meshes import grid, joined, mesh_of
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.mesh import build_mesh
from warp_origami.model.refine import refine
from warp_origami.model.submesh import build_submesh
from warp_origami.terms.contact.features import submesh_features
from warp_origami.terms.contact.swept import TOUCHING_SHARE, SweptTest
from warp_origami.terms.shapes import tabulate

# the oracle stops at a fraction of the initial distance, which would count closeness as crossing
EXACT = ipctk.TightInclusionCCD(conservative_rescaling=1.0 - 1e-6)


class Swept:
    """The swept test of a mesh, with positions of the mesh's vertices for q."""

    def __init__(self, mesh, divisions=1, **options):
        self.mesh, self.coordinates = mesh, number_coordinates(mesh)
        self.submesh = build_submesh(mesh, divisions)
        self.test = SweptTest(mesh, submesh_features(mesh, self.coordinates, self.submesh), "cpu", **options)
        self.interpolation = tabulate(mesh, self.submesh.elements, self.submesh.areas).interpolation(self.coordinates)

    def at(self, points):
        return affine_coordinates(self.mesh, self.coordinates, np.asarray(points, dtype=float))

    def passage(self, start, end):
        return self.test.first_passage(self.at(start), self.at(end))

    def points(self, q):
        return np.asfortranarray(self.interpolation @ q)

    def oracle(self):
        edges = ipctk.edges(self.submesh.triangles)
        return ipctk.CollisionMesh(np.pad(self.submesh.flat, ((0, 0), (0, 1))), edges, self.submesh.triangles)


def two_triangles():
    """Two separate triangles, 0 and 1; every place in space is given by the tests."""
    flat = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [2.0, 0.0], [3.0, 0.0], [2.0, 1.0]])
    return Swept(mesh_of(flat, [[0, 1, 2], [3, 4, 5]]))


FLOOR = np.array([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]])


def needle(tip):
    """A triangle that stands on its corner and leans towards -x and -y."""
    return np.array(tip) + np.array([[0.0, 0.0, 0.0], [-0.3, 0.0, 2.0], [0.0, -0.4, 2.0]])


def along_x(y, z):
    """A triangle that hangs down from an edge along x."""
    return np.array([[-1.0, y, z], [1.0, y, z], [0.0, y, z - 2.0]])


def along_y(x, z):
    """A triangle that stands on an edge along y."""
    return np.array([[x, -1.0, z], [x, 1.0, z], [x, 0.0, z + 2.0]])


def test_vertex_through_a_triangle():
    swept_sheets = two_triangles()
    start = np.concatenate([FLOOR, needle([0.2, 0.1, 0.37])])
    end = np.concatenate([FLOOR, needle([0.2, 0.1, -0.63])])
    found = swept_sheets.passage(start, end)
    assert (found.kind, found.elements, found.faces) == ("vertex-triangle", (1, 0), (1, 0))
    assert found.t == pytest.approx(0.37, abs=1e-9) and found.t < 0.37
    assert found.flat[0] == (2.0, 0.0)
    np.testing.assert_allclose(found.flat[1], [0.3, 0.275], atol=1e-12)
    q0, q1 = swept_sheets.at(start), swept_sheets.at(end)
    assert swept_sheets.test.largest_safe_fraction(q0, q1) == found.t
    assert swept_sheets.test.largest_safe_fraction(q0, q0 + found.t * (q1 - q0) * (1 - 1e-9)) == 1.0


def test_edge_through_an_edge():
    found = two_triangles().passage(
        np.concatenate([along_x(0.5, 0.0), along_y(-0.4, 0.37)]),
        np.concatenate([along_x(0.5, 0.0), along_y(-0.4, -0.63)]),
    )
    assert found.kind == "edge-edge" and set(found.elements) == {0, 1}
    assert found.t == pytest.approx(0.37, abs=1e-9)
    places = dict(zip(found.elements, found.flat, strict=True))
    np.testing.assert_allclose(places[0], [0.3, 0.0], atol=1e-9)
    np.testing.assert_allclose(places[1], [2.75, 0.0], atol=1e-9)


@pytest.mark.parametrize("distance", [0.3, 1e-3, 1e-6, 1e-9, -1e-9, -1e-6, -0.3])
def test_near_misses(distance):
    """Past a side, a corner, an edge and the inside of a face; a negative distance hits."""
    swept_sheets = two_triangles()
    assert TOUCHING_SHARE * swept_sheets.mesh.size < 1e-9
    down = np.array([0.0, 0.0, -1.3])
    side = np.concatenate([FLOOR, needle([0.7, -1.0 - distance, 0.4])])
    corner = np.concatenate([FLOOR, needle([-1.0 - 0.6 * distance, -1.0 - 0.8 * distance, 0.4])])
    edge = np.concatenate([along_x(1.0 + distance, 0.0), along_y(-0.4, 0.4)])
    for start in (side, corner, edge):
        end = start.copy()
        end[3:] += down
        assert (swept_sheets.passage(start, end) is None) == (distance > 0), start
    landing = np.concatenate([FLOOR, needle([0.2, 0.1, 0.37])])
    end = landing.copy()
    end[3:, 2] += distance - 0.37
    assert (swept_sheets.passage(landing, end) is None) == (distance > 0)


def test_layers_that_slide_closely_past_each_other():
    """Parallel, a millionth of their size apart, over many times their distance: nothing touches."""
    sheets = TwoSheets(grid(4, 4), grid(3, 3, (0.7, 0.7), angle=0.3))
    test = SweptTest(
        sheets.mesh, submesh_features(sheets.mesh, sheets.coordinates, build_submesh(sheets.mesh, 2)), "cpu"
    )
    assert test.first_passage(sheets.at(1e-6), sheets.at(1e-6, dx=0.3, dy=-0.2)) is None
    assert test.first_passage(sheets.at(1e-6), sheets.at(-1e-6, dx=0.3, dy=-0.2)).t == pytest.approx(0.5, abs=1e-3)


def test_of_several_passages_the_first_is_reported():
    """A comb of needles through a floor, each at its own time, two of them at once."""
    heights = [0.9, 0.31, 0.62, 0.31]
    flat, triangles = joined(
        *[(np.array([[i, 0.0], [i + 0.5, 0.0], [i, 0.5]]), np.array([[0, 1, 2]])) for i in range(5)]
    )
    comb = Swept(mesh_of(flat, triangles))
    teeth = [needle([0.4 * i - 0.5, 0.0, z]) for i, z in enumerate(heights)]
    start = np.concatenate([FLOOR, *teeth])
    end = start - np.r_[0.0, 0.0, 1.0] * (np.arange(len(start)) >= 3)[:, None]
    found = comb.passage(start, end)
    assert found.t == pytest.approx(0.31, abs=1e-8) and found.elements == (2, 0)


def random_pairs(kind, count, rng):
    """Positions at start and end of `count` pairs of features, (count, 4, 3); one in two gets close."""
    start, end = rng.normal(size=(2, count, 4, 3))
    close = rng.random(count) < 0.5
    weights = rng.random((count, 4)) * (0.5 if kind == swept.VERTEX_TRIANGLE else 1.0)
    middle = 0.5 * (start + end)
    if kind == swept.VERTEX_TRIANGLE:
        u, v = weights[:, :1] * 0.9, weights[:, 1:2] * 0.9
        gap = (1 - u - v) * middle[:, 1] + u * middle[:, 2] + v * middle[:, 3] - middle[:, 0]
        moved = slice(0, 1)
    else:
        u, v = weights[:, :1], weights[:, 1:2]
        gap = (1 - v) * middle[:, 2] + v * middle[:, 3] - (1 - u) * middle[:, 0] - u * middle[:, 1]
        moved = slice(0, 2)
    miss = gap - 10.0 ** rng.uniform(-8, 0, size=(count, 1)) * rng.normal(size=(count, 3))
    end[close, moved] += miss[close, None]
    start[close, moved] += miss[close, None]
    return start, end


@pytest.mark.parametrize("kind", [swept.VERTEX_TRIANGLE, swept.EDGE_EDGE])
def test_pairs_agree_with_the_oracle(kind):
    """Random vertices and triangles, random edges: the same answer, and the same time to the oracle's tolerance."""
    count = 1000
    start, end = random_pairs(kind, count, np.random.default_rng(0))
    first = np.arange(count) * 4 if kind == swept.VERTEX_TRIANGLE else np.arange(count) * 2
    second = np.arange(count) if kind == swept.VERTEX_TRIANGLE else np.arange(count) * 2 + 1
    features = swept.Features()
    features.triangles = wp.array(4 * np.arange(count)[:, None] + [1, 2, 3], dtype=wp.int32, device="cpu")
    features.edges = wp.array(np.arange(4 * count).reshape(-1, 2), dtype=wp.int32, device="cpu")
    times = wp.zeros(count, dtype=real, device="cpu")
    names = [wp.array(a, dtype=wp.int32, device="cpu") for a in (np.full(count, kind), first, second)]
    places = [wp.array(x.reshape(-1, 3), dtype=vec3, device="cpu") for x in (start, end)]
    wp.launch(
        swept.advance_pairs, dim=count, inputs=[*names, *places, features, real(1e-10)], outputs=[times], device="cpu"
    )
    times = times.numpy()
    ccd = EXACT.point_triangle_ccd if kind == swept.VERTEX_TRIANGLE else EXACT.edge_edge_ccd
    answers = [ccd(*start[i], *end[i]) for i in range(count)]
    hits = np.array([hit for hit, _ in answers])
    assert 0.1 < hits.mean() < 0.9
    np.testing.assert_array_equal(times <= 1.0, hits)
    # the oracle's tolerance is one in space: where features come near each other slowly, a long time
    late = times[hits] - np.array([t for _, t in answers])[hits]
    assert np.all(late > -1e-9) and np.quantile(late, 0.95) < 1e-5


def z_fold(vertices, angle):
    """A sheet folded at x = -1/6 and x = 1/6 in opposite senses, by the same angle."""
    points = np.pad(vertices, ((0, 0), (0, 1)))
    for sign in (1.0, -1.0):
        out = sign * vertices[:, 0] - 1 / 6
        part = out > 0
        points[part, 0] = sign * (1 / 6 + out[part] * np.cos(angle))
        points[part, 2] = sign * out[part] * np.sin(angle)
    return points


def z_fold_sheet(divisions=2):
    vertices, triangles = grid(6, 4)
    return vertices, Swept(mesh_of(vertices, triangles, lambda m: np.abs(np.abs(m[:, 0]) - 1 / 6) < 1e-9), divisions)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_random_motions_of_a_creased_sheet_agree_with_the_oracle(seed):
    """Never free where the oracle finds a crossing; here no false alarm either, in 100 steps of every size."""
    vertices, folded = z_fold_sheet()
    oracle = folded.oracle()
    rng = np.random.default_rng(seed)
    size = np.full((folded.coordinates.count, 1), 0.02)
    size[folded.coordinates.positions] = 0.003
    answers = []
    while len(answers) < 100:
        angle, scale = rng.uniform(2.8, 3.1), 10 ** rng.uniform(-1, 0.8)
        q0 = folded.at(z_fold(vertices, angle)) + 0.2 * size * rng.normal(size=(len(size), 3))
        if ipctk.has_intersections(oracle, folded.points(q0)):
            continue
        turn = rng.uniform(-0.1, 0.1) * scale
        q1 = folded.at(z_fold(vertices, angle + turn)) + 3 * scale * size * rng.normal(size=(len(size), 3))
        points = folded.points(q0), folded.points(q1)
        free = ipctk.is_step_collision_free(oracle, *points, narrow_phase_ccd=EXACT)
        found = folded.test.first_passage(q0, q1)
        answers.append((free, found is None))
        if found is not None:  # safe until it is found, not beyond
            until = points[0] + found.t * (points[1] - points[0])
            assert not ipctk.has_intersections(oracle, until)
    free, said_free = np.array(answers).T
    assert 20 < free.sum() < 80
    np.testing.assert_array_equal(said_free, free)


def test_features_of_one_place_do_not_alarm_in_rigid_motions():
    vertices, folded = z_fold_sheet(3)
    axis = np.array([0.6, -0.48, 0.64])
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(3) + np.sin(0.7) * cross + (1 - np.cos(0.7)) * cross @ cross
    points = z_fold(vertices, 3.1)
    for _ in range(4):
        moved = points @ turn + [0.3, -2.0, 1.0]
        assert folded.passage(points, moved) is None
        points = moved


def test_a_crease_folds_until_flat_and_no_farther():
    vertices, folded = z_fold_sheet(3)
    angles = np.linspace(0.0, np.pi - 1e-4, 40)
    for a, b in pairwise(angles):
        assert folded.passage(z_fold(vertices, a), z_fold(vertices, b)) is None
        assert folded.passage(z_fold(vertices, b), z_fold(vertices, a)) is None
    found = folded.passage(z_fold(vertices, np.pi - 0.01), z_fold(vertices, np.pi + 0.03))
    assert found.t == pytest.approx(0.25, abs=0.01)


def test_what_touches_from_the_start_may_part_but_not_meet_again():
    sheets = TwoSheets(grid(4, 4), grid(3, 3, (0.7, 0.7), angle=0.3))
    test = SweptTest(
        sheets.mesh, submesh_features(sheets.mesh, sheets.coordinates, build_submesh(sheets.mesh, 2)), "cpu"
    )
    assert test.first_passage(sheets.at(0.0), sheets.at(0.0)) is None
    assert test.first_passage(sheets.at(0.0), sheets.at(1e-3, dx=0.01)) is None
    assert test.first_passage(sheets.at(0.0), sheets.at(-1e-3, dx=0.01)) is None
    assert test.first_passage(sheets.at(1e-3), sheets.at(0.0)).t == pytest.approx(1.0, abs=1e-6)
    assert test.first_passage(sheets.at(1e-3), sheets.at(-1e-3)).t == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(("cells", "divisions"), [(1, 1), (1, 3), (2, 2)])
def test_lips_of_a_cut_are_one_place(cells, divisions):
    """Points on both sides of a cut belong together, and nothing else does; the lips may open and overlap."""
    vertices, triangles = grid(3, 3)
    mesh = refine(build_mesh(vertices, triangles, [(1, 5), (5, 9)], ["C", "C"]), cells)
    submesh = build_submesh(mesh, divisions)
    groups = submesh_features(mesh, number_coordinates(mesh), submesh).groups
    _, place = np.unique(submesh.flat.round(9), axis=0, return_inverse=True)
    np.testing.assert_array_equal(groups[:, None] == groups, place.ravel()[:, None] == place.ravel())
    assert len(np.unique(groups)) < len(groups)

    lips = Swept(mesh, divisions)
    flat = np.pad(mesh.vertices, ((0, 0), (0, 1)))
    parts = [flat * [1.0, 1.0 + s, 1.0] for s in (0.0, 1e-3, -1e-3)]
    for a in parts:
        for b in parts:
            assert lips.passage(a, b) is None


def test_the_answer_depends_on_the_two_states_alone():
    """A test that has followed a motion says bitwise what a new one says, though it searches much less often."""
    vertices, folded = z_fold_sheet()
    rng = np.random.default_rng(5)
    size = np.full((folded.coordinates.count, 1), 0.02)
    size[folded.coordinates.positions] = 0.004
    noise = size * rng.normal(size=(2, len(size), 3))
    states = [
        folded.at(z_fold(vertices, 2.6 + 0.012 * i)) + np.einsum("k,kij->ij", [np.cos(0.1 * i), np.sin(0.1 * i)], noise)
        for i in range(41)
    ]
    found = [folded.test.first_passage(a, b) for a, b in pairwise(states)]
    features = submesh_features(folded.mesh, folded.coordinates, folded.submesh)
    fresh = [SweptTest(folded.mesh, features, "cpu").first_passage(a, b) for a, b in pairwise(states)]
    assert found == fresh
    assert 3 < sum(one is not None for one in found) < 38
    assert folded.test.cost.searches < 30


def test_small_steps_need_no_search():
    vertices, folded = z_fold_sheet()
    for i in range(100):
        angle = 2.5 + 1e-3 * i
        assert folded.passage(z_fold(vertices, angle), z_fold(vertices, angle + 1e-3)) is None
    assert folded.test.cost.searches <= 10
    shift = np.array([5.0, -3.0, 2.0])  # all points alike
    searches = folded.test.cost.searches
    assert folded.passage(z_fold(vertices, angle), z_fold(vertices, angle) + shift) is None
    assert folded.test.cost.searches == searches


def test_the_number_of_near_pairs_grows_with_the_elements():
    """Sheets that lie over each other at a tenth of an edge: as many pairs per element whatever the mesh."""
    per_element = []
    for n in (8, 16, 32):
        sheets = TwoSheets(grid(n, n), grid(n, n, angle=0.3))
        test = SweptTest(
            sheets.mesh, submesh_features(sheets.mesh, sheets.coordinates, build_submesh(sheets.mesh, 1)), "cpu"
        )
        assert test.first_passage(sheets.at(0.1 / n), sheets.at(0.11 / n)) is None
        per_element.append(test.cost.near / len(sheets.mesh.triangles))
    assert max(per_element) < 1.1 * min(per_element)

    single = Swept(mesh_of(*grid(30, 30)))
    flat = np.pad(single.mesh.vertices, ((0, 0), (0, 1)))
    assert single.passage(flat, flat + [[0.0, 0.0, 1e-3]] * np.sin(9 * flat[:, :1])) is None
    assert single.test.cost.near == 0


def test_a_graded_mesh_misses_nothing():
    """A small sheet through a large element, and a large element through small ones: search sizes differ by 300."""
    for fine, coarse in (((0.01, 0.01), (3.0, 3.0)), ((3.0, 3.0), (0.01, 0.01))):
        sheets = TwoSheets(grid(1, 1, coarse), grid(4, 4, fine))
        test = SweptTest(
            sheets.mesh, submesh_features(sheets.mesh, sheets.coordinates, build_submesh(sheets.mesh, 1)), "cpu"
        )
        found = test.first_passage(sheets.at(0.02, dx=0.3), sheets.at(-0.03, dx=0.3))
        assert found is not None and found.t == pytest.approx(0.4, abs=1e-6)


def test_states_that_are_not_finite_are_refused():
    vertices, folded = z_fold_sheet()
    q = folded.at(z_fold(vertices, 1.0))
    with pytest.raises(ValueError, match="finite"):
        folded.test.first_passage(q, np.full_like(q, np.nan))
