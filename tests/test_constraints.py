"""Fold lines and prescribed motion as equations: exact elimination, rank, conditioning, what stays possible."""

import numpy as np
import pytest
from scipy.sparse import identity
from scipy.spatial import Delaunay

from membrane_cases import field_coordinates, linear_field, rotation
from runs import film, system_of
from warp_origami.model.constraints import build_constraints
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.generators.leaf_in import leaf_in
from warp_origami.model.generators.sheet import sheet
from warp_origami.model.mesh import CREASE, build_mesh
from warp_origami.model.prescribed import prescribed_rows

LARGEST_UNKNOWN = 50.0
"""Bound of the norm of T: how far a unit change of an unknown moves the coordinates."""


def fold_constraints(mesh):
    """Constraints of the folds alone."""
    coordinates = number_coordinates(mesh)
    empty = np.zeros((coordinates.count, 3))
    rows = prescribed_rows(mesh, coordinates, [], empty, empty)
    return coordinates, build_constraints(mesh, coordinates, [], rows)


def fan(angles):
    """Triangles around one vertex with a crease along every spoke; `angles` in degrees."""
    points = np.stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))], axis=1)
    n = len(angles)
    spokes = np.stack([np.zeros(n, int), 1 + np.arange(n)], axis=1)
    triangles = np.stack([np.zeros(n, int), 1 + np.arange(n), 1 + (1 + np.arange(n)) % n], axis=1)
    return build_mesh(np.vstack([[0.0, 0.0], points]), triangles, spokes, np.full(n, "M"))


def random_pattern(seed, share):
    """Random triangles with a random share of their edges as creases: crossings, tips, single creases."""
    rng = np.random.default_rng(seed)
    points = np.vstack([rng.uniform(size=(25, 2)), [[0, 0], [1, 0], [0, 1], [1, 1]]])
    plain = build_mesh(points, Delaunay(points).simplices)
    creases = plain.edges[rng.uniform(size=len(plain.edges)) < share]
    return build_mesh(plain.vertices, plain.triangles, creases, np.full(len(creases), "V"))


MESHES = {
    "crossing of 8": fan(np.arange(0, 360, 45)),
    "crossing of 5": fan([0, 50, 110, 200, 280]),
    "collinear folds": fan([0, 90, 180, 270]),
    "almost collinear folds": fan([0, 60, 179.9, 240]),
    "narrow sectors": fan([0, 2, 4, 120, 122, 240]),
    "one crease": sheet(1.0, 0.5, 4, 2, creases_x=(2,)).mesh,
    "crossing creases": sheet(1.0, 1.0, 4, 4, creases_x=(1, 2), creases_y=(2,)).mesh,
    "leaf-in": leaf_in().mesh,
} | {f"random {seed}": random_pattern(seed, share) for seed, share in enumerate((0.2, 0.5, 0.8, 1.0))}


@pytest.fixture(params=MESHES, name="mesh")
def mesh_fixture(request):
    return MESHES[request.param]


def largest(matrix):
    return np.abs(matrix.toarray()).max(initial=0.0)


def dense_rank(matrix):
    return np.linalg.matrix_rank(matrix.toarray(), tol=1e-8)


def test_elimination_is_exact(mesh):
    """q = T y + P d fulfils C q = d for any y and d, and R gives y back."""
    _, c = fold_constraints(mesh)
    n, m, ny = c.null_space.shape[0], c.equations.shape[0], c.null_space.shape[1]
    assert m + ny == n
    assert largest(c.equations @ c.null_space) < 1e-13
    assert largest(c.equations @ c.right_inverse - identity(m)) < 1e-12
    assert largest(c.left_inverse @ c.null_space - identity(ny)) < 1e-12
    rng = np.random.default_rng(0)
    y, d = rng.normal(size=ny), rng.normal(size=m)
    q = c.null_space @ y + c.right_inverse @ d
    np.testing.assert_allclose(c.equations @ q, d, atol=1e-11)
    np.testing.assert_allclose(c.left_inverse @ (q - c.right_inverse @ d), y, atol=1e-11)


def test_unknowns_are_well_conditioned(mesh):
    _, c = fold_constraints(mesh)
    norms = np.sqrt(np.asarray(c.null_space.multiply(c.null_space).sum(axis=0))).ravel()
    print(f"largest column of T {norms.max():.3g}, largest entry {np.abs(c.null_space.data).max():.3g}")
    assert norms.max() < LARGEST_UNKNOWN


def all_fold_equations(mesh, coordinates):
    """Every equation (48), from the definition: slope along the crease in both faces, at both ends."""
    rows = []
    for d in np.flatnonzero(mesh.edge_kinds == CREASE):
        a, b = mesh.edges[d]
        tangent = mesh.vertices[b] - mesh.vertices[a]
        for v in (a, b):
            row = np.zeros(coordinates.count)
            for e, sign in zip(mesh.edge_triangles[d], (1.0, -1.0), strict=True):
                corner = int(np.flatnonzero(mesh.triangles[e] == v)[0])
                g = coordinates.elements[e, 3 * corner + 1]
                row[[g, g + 1]] += sign * tangent
            rows.append(row)
    return np.array(rows)


def test_every_fold_equation_is_fulfilled_and_nothing_else_is_asked(mesh):
    coordinates, c = fold_constraints(mesh)
    wanted = all_fold_equations(mesh, coordinates)
    y = np.random.default_rng(1).normal(size=c.null_space.shape[1])
    q = (c.null_space @ y).reshape(-1, 3)
    np.testing.assert_allclose(wanted @ q, 0.0, atol=1e-11)
    rank = np.linalg.matrix_rank(wanted, tol=1e-8)
    assert c.equations.shape[0] == 3 * rank
    trivial = np.sum(~wanted.any(axis=1))  # at the tip of a crease one sector lies on both sides
    assert c.dropped == 3 * (len(wanted) - trivial - rank)


@pytest.mark.parametrize("angles", [[0, 90, 180, 270], [0, 60, 130, 250], np.arange(0, 360, 45)])
def test_around_a_vertex_where_n_creases_meet_n_slopes_are_free(angles):
    """Each of the n sectors lies between two creases, whose slopes determine its gradient."""
    mesh = fan(angles)
    coordinates, c = fold_constraints(mesh)
    rows = coordinates.sector_gradients[coordinates.sector_vertices == 0]
    assert len(rows) == len(angles)
    columns = (3 * np.concatenate([rows, rows + 1])[:, None] + np.arange(3)).ravel()
    rank = np.linalg.matrix_rank(c.equations.toarray()[:, columns], tol=1e-8)
    assert len(columns) - rank == 3 * len(angles)


def rigid(mesh, coordinates):
    turn = rotation([1, -2, 3], 2.0)
    return field_coordinates(mesh, coordinates, linear_field(turn[:, :2], (1.0, -0.5, 0.3)))


def test_rigid_motions_and_affine_maps_are_possible(mesh):
    coordinates, c = fold_constraints(mesh)
    affine = field_coordinates(mesh, coordinates, linear_field(np.arange(6.0).reshape(3, 2), (1.0, 2.0, 3.0)))
    for q in (rigid(mesh, coordinates), affine):
        assert np.abs(c.equations @ q.ravel()).max(initial=0.0) < 1e-12
        np.testing.assert_allclose(c.null_space @ (c.left_inverse @ q.ravel()), q.ravel(), atol=1e-11)


@pytest.mark.parametrize("pattern", [leaf_in(), sheet(1.0, 0.5, 6, 2, creases_x=(2, 4), opening=1.0)])
def test_folding_is_possible(pattern):
    """The stowed state, with every face turned rigidly, fulfils the fold equations and is a T y."""
    coordinates, c = fold_constraints(pattern.mesh)
    q = affine_coordinates(pattern.mesh, coordinates, pattern.stowed).ravel()
    assert np.abs(c.equations @ q).max() < 1e-9
    np.testing.assert_allclose(c.null_space @ (c.left_inverse @ q), q, atol=1e-9)


def test_any_piecewise_affine_surface_over_creased_triangles_is_possible():
    """With a crease along every edge the vertices can be put anywhere."""
    mesh = MESHES["random 3"]
    assert (mesh.edge_kinds != 0).all()
    coordinates, c = fold_constraints(mesh)
    points = np.random.default_rng(5).normal(size=(len(mesh.vertices), 3))
    q = affine_coordinates(mesh, coordinates, points).ravel()
    assert np.abs(c.equations @ q).max() < 1e-10


def test_a_kink_across_a_crease_is_possible_and_one_along_it_is_not():
    mesh = MESHES["one crease"]
    coordinates, c = fold_constraints(mesh)
    x = mesh.vertices[:, 0]
    kink = affine_coordinates(mesh, coordinates, np.column_stack([mesh.vertices, np.abs(x - 0.5)]))
    assert np.abs(c.equations @ kink.ravel()).max() < 1e-13
    sheared = np.zeros((coordinates.count, 3))
    left = coordinates.elements[np.flatnonzero(mesh.vertices[mesh.triangles].mean(axis=1)[:, 0] < 0.5)]
    sheared[np.unique(left[:, 2::3]), 2] = 1.0  # r_y of the left face alone
    assert np.abs(c.equations @ sheared.ravel()).max() > 0.1


def test_the_tip_of_a_crease_has_one_gradient():
    """A crease that ends inside a face leaves one sector there; its equation is empty and not counted."""
    plain = sheet(1.0, 1.0, 4, 4).mesh
    row = np.flatnonzero(np.isclose(plain.vertices[:, 1], 0.5))
    row = row[np.argsort(plain.vertices[row, 0])]
    lines = np.stack([row[:2], row[1:3]], axis=1)  # from the rim to the middle
    mesh = build_mesh(plain.vertices, plain.triangles, lines, ["M", "M"])
    coordinates, c = fold_constraints(mesh)
    sectors = np.bincount(coordinates.sector_vertices)
    assert [sectors[v] for v in row] == [2, 2, 1, 1, 1]
    assert c.dropped == 3  # of two collinear folds between the same two sectors one is enough
    assert c.equations.shape[0] == 2 * 3


BOX = {"box": [[0.0, 0.0], [0.0, 1.0]]}
MIDDLE = {"box": [[0.5, 0.0], [0.5, 1.0]]}


@pytest.mark.parametrize(
    ("support", "driver"),
    [
        ([{"at": BOX, "fix": "xyz"}], [{"at": {"near": [1.0, 1.0]}, "translate": [0.1, 0.2, 0.3]}]),
        ([{"at": {"boundary": True}, "fix": "z"}, {"at": BOX, "fix": "xy"}, {"at": {"near": [0, 0]}}], []),
        ([{"at": {"all": True}, "fix": "y"}], [{"at": MIDDLE, "axes": "xz", "translate": [0.1, 0.0, -0.1]}]),
        ([], [{"at": {"boundary": True}, "translate_to": "deployed", "overstretch": 1e-3}]),
        ([{"at": {"all": True}, "fix": "x"}, {"at": {"all": True}, "fix": "yz"}], []),
    ],
)
def test_supports_and_drivers_go_with_folds(support, driver):
    """Folds and prescribed values hold at once at any time; repeated equations are dropped, not lost."""
    pattern = {"width": 1.0, "height": 1.0, "nx": 4, "ny": 4, "creases_x": [1, 2], "opening": 2.0}
    system = system_of(film(1.0, pattern, support=support, driver=driver))
    c = system.constraints
    n, ny = c.null_space.shape
    assert dense_rank(c.equations) == c.equations.shape[0] == n - ny
    assert largest(c.equations @ c.null_space) < 1e-13
    assert largest(c.equations @ c.right_inverse - identity(n - ny)) < 1e-12
    np.testing.assert_allclose(c.equations @ system.q0.ravel(), c.values(0.0), atol=1e-12)
    y = np.random.default_rng(2).normal(size=ny)
    for time in (0.0, 0.6, 1.0):
        q = (c.null_space @ y + c.right_inverse @ c.values(time)).reshape(-1, 3)
        np.testing.assert_allclose(all_fold_equations(system.mesh, system.coordinates) @ q, 0.0, atol=1e-11)
        for prescriber in c.prescribers:
            rows, held = system.coordinates.positions[prescriber.selection.vertices], list(prescriber.components)
            motion = prescriber.motion
            moved = np.zeros(3) if motion is None else motion.profile(time) * motion.translate
            if motion is None or motion.overstretch is None:
                np.testing.assert_allclose(q[rows][:, held], (system.q0[rows] + moved)[:, held], atol=1e-12)


def test_a_sheet_held_everywhere_has_no_unknowns():
    """Of held slopes and folds, which say the same at every vertex, as many are kept as there are coordinates."""
    pattern = {"width": 1.0, "height": 1.0, "nx": 2, "ny": 2, "creases_x": [1]}
    c = system_of(film(1.0, pattern, support=[{"at": {"all": True}}])).constraints
    assert c.null_space.shape[1] == 0
    assert dense_rank(c.equations) == c.equations.shape[0] == c.null_space.shape[0]
    assert c.dropped > 0
