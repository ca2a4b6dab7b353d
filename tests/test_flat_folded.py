"""Sheets that a FOLD file folds exactly flat: its faceOrders say which layer lies above, and they stay there."""

import json

import ipctk
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import warp_origami as wo
from runs import run, system_of
from warp_origami.errors import InputError
from warp_origami.model.coordinates import affine_coordinates
from warp_origami.model.fold import read_fold
from warp_origami.model.generators import build_pattern
from warp_origami.model.generators.miura import miura
from warp_origami.model.letter_order import find_circle
from warp_origami.model.locate import area_coordinates
from warp_origami.model.opening import SLOPE, SLOPE_BENT, opened
from warp_origami.model.pattern_report import describe_pattern

WIDTH, HEIGHT, THICKNESS = 0.1, 0.08, 5e-4


def accordion(layers, above=1, orders=None):
    """FOLD content: panels folded onto each other without any distance, the later ones above (or below) the others."""
    lines = np.arange(layers + 1)
    ends = lambda x: [[float(a), b, 0.0] for a in x for b in (0.0, HEIGHT)]  # noqa: E731
    edges = [[2 * i, 2 * i + 1] for i in lines]
    kinds = ["B" if i in (0, layers) else ("MV" if above > 0 else "VM")[i % 2] for i in lines]
    for i in lines[:-1]:
        edges += [[2 * i, 2 * i + 2], [2 * i + 1, 2 * i + 3]]
        kinds += ["B", "B"]
    if orders is None:  # every second panel is turned over
        orders = [
            [f, g, above * (1 if f > g else -1) * (-1) ** g] for f in range(layers) for g in range(layers) if f != g
        ]
    return {
        "file_spec": 1.2,
        "vertices_coords": ends(lines * WIDTH),
        "edges_vertices": np.array(edges).tolist(),
        "edges_assignment": kinds,
        "faces_vertices": [[2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1] for i in range(layers)],
        "file_frames": [
            {
                "frame_classes": ["foldedForm"],
                "frame_parent": 0,
                "frame_inherit": True,
                "vertices_coords": ends(lines % 2 * WIDTH),
                "faceOrders": orders,
            }
        ],
    }


def scene(path, content, duration=1e-3, seed=None, **pattern):
    """A film folded so, shaken by random velocities of its vertices of 5 cm/s."""
    (path / "flat.fold").write_text(json.dumps(content))
    rng = np.random.default_rng(seed)
    loads = [
        {"kind": "initial_velocity", "value": (0.05 * rng.normal(size=3)).tolist(), "at": {"near": point[:2]}}
        for point in (content["vertices_coords"] if seed is not None else [])
    ]
    return wo.Scene(
        name="flat",
        analysis={"kind": "dynamic", "duration": duration},
        pattern={"kind": "fold", "file": str(path / "flat.fold"), "refine": 2} | pattern,
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": THICKNESS},
        contact={"method": "mixed"},
        load=loads,
        output={"fps": "steps", "fields": []},
    )


def heights(mesh, points, layers):
    """Height of each panel over places (n,) of the folded panel, (layers, n)."""
    places = np.random.default_rng(0).uniform(0.02, 0.98, (40, 2)) * [WIDTH, HEIGHT]
    result = []
    for layer in range(layers):
        flat = places.copy()
        flat[:, 0] = layer * WIDTH + (places[:, 0] if layer % 2 == 0 else WIDTH - places[:, 0])
        found = []
        for place in flat:
            areas = area_coordinates(mesh, np.arange(len(mesh.triangles)), np.tile(place, (len(mesh.triangles), 1)))
            element = np.argmax(areas.min(axis=1))
            found.append(areas[element] @ points[mesh.triangles[element], 2])
        result.append(found)
    return np.array(result)


@pytest.mark.parametrize("layers", [2, 4, 10])
@pytest.mark.parametrize("above", [1, -1])
def test_coincident_layers_open_in_their_order(tmp_path, layers, above):
    """Without stress to speak of, without contact force, without crossing."""
    system = system_of(scene(tmp_path, accordion(layers, above)))
    points = system.q0[system.coordinates.positions]
    assert np.abs(points[:, :2] - system.pattern.stowed[:, :2]).max() < SLOPE**2 * layers * WIDTH
    between = np.diff(heights(system.mesh, points, layers), axis=0)
    assert (above * between).min() > 0.02 * SLOPE * WIDTH
    start = system.evaluate(system.q0)
    assert start.strain_energy < 1e-12 and start.contact_energy < 1e-30
    assert np.ptp(points[:, 2]) <= 1.001 * layers * SLOPE * WIDTH
    collisions = ipctk.CollisionMesh(points, system.mesh.edges, system.mesh.triangles)
    assert not ipctk.has_intersections(collisions, points)


def test_orders_may_be_told_from_either_face(tmp_path):
    """Each pair once, from the upper or from the lower face."""
    for orders in ([[1, 0, 1], [2, 0, 1], [2, 1, -1]], [[0, 1, 1], [0, 2, -1], [1, 2, -1]]):
        system = system_of(scene(tmp_path, accordion(3, orders=orders)))
        between = np.diff(heights(system.mesh, system.q0[system.coordinates.positions], 3), axis=0)
        assert between.min() > 0.0


def without_orders(content, **frame):
    """The same, with letters alone to tell the order of layers."""
    content["file_frames"][0] |= {"faceOrders": []} | frame
    return content


def read(path, content):
    (path / "flat.fold").write_text(json.dumps(content))
    return read_fold(path / "flat.fold")


def rolled():
    """Three panels rolled up by two valleys: letters do not tell how the first one and the last one lie."""
    content = without_orders(accordion(3))
    content["edges_assignment"][:4] = "BVVB"
    return content


def waterbomb(letters):
    """Its six panels meet in the middle of the sheet; folded, all lie on the lowest one."""
    points = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1], [1, 1]]
    folded = [[0, 0], [1, 0], [2, 0], [1, 0], [2, 0], [1, 0], [0, 0], [1, 0], [1, 1]]
    return {
        "frame_unit": "cm",
        "vertices_coords": points,
        "edges_vertices": [[i, (i + 1) % 8] for i in range(8)] + [[8, i] for i in (0, 2, 4, 6, 3, 7)],
        "edges_assignment": list("BBBBBBBB" + letters),
        "file_frames": [{"frame_classes": ["foldedForm"], "vertices_coords": folded}],
    }


def unlettered():
    """The first panel under the second and under the third says nothing about these two."""
    content = accordion(3, orders=[[1, 0, 1], [2, 0, 1]])
    content["edges_assignment"][:4] = "BUUB"
    return content


@pytest.mark.parametrize("content", [waterbomb("UUUUUU"), rolled(), unlettered()])
def test_layers_that_share_vertices_in_unknown_order_are_told_of(tmp_path, content):
    pattern = read(tmp_path, content)
    line = dict(describe_pattern(pattern))["stowed state"]
    assert "unknown order" in line and "faceOrders" in line
    with pytest.raises(InputError, match=r"pattern\.initial.*coincide in unknown order.*faceOrders"):
        system_of(scene(tmp_path, content, refine=1))
    system_of(scene(tmp_path, content, refine=1).model_copy(update={"contact": None}))


def test_letters_tell_the_order_of_layers(tmp_path):
    """Of a waterbomb and of accordions all pairs, as faceOrders would."""
    pattern = read(tmp_path, waterbomb("VVVVMM"))
    assert len(pattern.face_orders) == 11  # all 15 but the two on the left with the two on the right
    assert "unknown" not in dict(describe_pattern(pattern))["stowed state"]
    for above in (1, -1):
        told = read(tmp_path, accordion(5, above))
        concluded = read(tmp_path, without_orders(accordion(5, above)))
        assert len(concluded.face_orders) == 10
        assert {tuple(row) for row in concluded.face_orders} <= {tuple(row) for row in told.face_orders}
    system = system_of(scene(tmp_path, without_orders(accordion(4))))
    between = np.diff(heights(system.mesh, system.q0[system.coordinates.positions], 4), axis=0)
    assert between.min() > 0.02 * SLOPE * WIDTH


def test_rounded_layers_open_in_their_order(tmp_path):
    content = accordion(4)
    for frame in (content, content["file_frames"][0]):
        frame["vertices_coords"] = [[x + 1e-6 * (i % 3), *yz] for i, (x, *yz) in enumerate(frame["vertices_coords"])]
    system = system_of(scene(tmp_path, content))
    between = np.diff(heights(system.mesh, system.q0[system.coordinates.positions], 4), axis=0)
    assert between.min() > 0.02 * SLOPE * WIDTH


@pytest.mark.parametrize("digits", [6, 7])
def test_rounded_layers_open_in_any_plane(tmp_path, digits):
    """A waterbomb of 20 mm, turned about and written with some digits."""
    content = waterbomb("VVVVMM")
    folded = content["file_frames"][0]
    turn = Rotation.from_euler("xyz", [0.3, 0.7, 0.2])
    folded["vertices_coords"] = np.round(
        turn.apply(np.pad(folded["vertices_coords"], ((0, 0), (0, 1)))), digits
    ).tolist()
    pattern = read(tmp_path, content)
    points = opened(pattern.mesh, pattern.pattern_faces, pattern.face_orders, pattern.stowed)
    heights = turn.inv().apply(points)[:, 2]
    assert np.ptp(heights) > 0.01 * SLOPE_BENT * 0.02
    magnified = turn.inv().apply(points) * [1.0, 1.0, 1e3]
    collisions = ipctk.CollisionMesh(magnified, pattern.mesh.edges, pattern.mesh.triangles)
    assert not ipctk.has_intersections(collisions, magnified)


def test_a_rounded_start_runs(tmp_path):
    """Gradients at folds agree on both sides, else the first step would move them at once, with any speed."""
    content = waterbomb("VVVVMM")
    content["file_frames"][0]["vertices_coords"] = [
        [x + 3e-6 * (i % 2), y - 2e-6 * (i % 3)]
        for i, (x, y) in enumerate(content["file_frames"][0]["vertices_coords"])
    ]
    case = scene(tmp_path, content, duration=2e-5)
    constraints, q0 = (system := system_of(case)).constraints, system.q0
    assert np.abs(constraints.equations @ q0.ravel() - constraints.values(0.0)).max() < 1e-15
    given = affine_coordinates(system.mesh, system.coordinates, system.pattern.stowed)
    assert 1e-7 < np.abs(constraints.equations @ given.ravel()).max() < 1e-5
    start = system.evaluate(q0).strain_energy
    result = run(case)
    assert result.summary["status"] == "done"
    assert result.history["kinetic_energy"].max() < start


@pytest.mark.parametrize(
    ("orders", "key", "got", "wants"),
    [
        ([[1, 0, -1]], "faceOrders[0]", "[1, 0, -1]", "V: edge 1"),
        ([[1, 2, 0], [2, 1, 1]], "faceOrders[1]", "[2, 1, 1]", "M: edge 2"),
        ([[2, 0, -1]], "faceOrders", "face 0 above", "one order"),
    ],
)
def test_orders_that_contradict_letters_or_each_other_are_refused(tmp_path, orders, key, got, wants):
    with pytest.raises(InputError) as error:
        read(tmp_path, accordion(3, orders=orders))
    assert error.value.key.endswith(f"file_frames[0].{key}")
    assert got in error.value.got and wants in error.value.wants


def test_flaps_of_a_box_lie_above_each_other_in_a_circle():
    """The classic twist: its four pleats have no common point."""
    pattern = build_pattern("square_twist", {"assignment": "classic"})
    assert find_circle(pattern.mesh, pattern.pattern_faces, pattern.face_orders, pattern.stowed) is None


def test_states_without_coincident_layers_are_left_alone(tmp_path):
    content = accordion(2)
    content["file_frames"][0]["vertices_coords"] = [[0, 0, 0], [0, 0.08, 0], [0.1, 0, 0], [0.1, 0.08, 0]] + [
        [0.0, y, 0.01] for y in (0.0, 0.08)
    ]
    content["file_frames"][0]["vertices_coords"][4][0] = content["file_frames"][0]["vertices_coords"][5][0] = float(
        0.1 - np.sqrt(0.01 - 1e-4)
    )
    system = system_of(scene(tmp_path, content))
    assert np.array_equal(system.q0[system.coordinates.positions], system.pattern.stowed)


@pytest.mark.parametrize("n", [2, 3])
def test_a_miura_sheet_opens(n):
    """Its panels overlap in parts and are held together at vertices of four creases."""
    nearly, shut = miura(n, n, 0.1, 0.1, 1.0, 0.02), miura(n, n, 0.1, 0.1, 1.0, 1e-12)
    mesh, shut = nearly.mesh, shut.stowed
    shut[:, 1] = 0.0
    panels = nearly.pattern_faces

    corners = mesh.vertices[mesh.triangles]
    inside = np.array([(i, j, 12 - i - j) for i in range(1, 11) for j in range(1, 12 - i)]) / 12.0
    places = np.einsum("kc,ecd->ekd", inside, shut[mesh.triangles])[..., [0, 2]]
    orders = []
    for e, element in enumerate(mesh.triangles):
        base = np.concatenate([shut[element][:, [0, 2]].T, np.ones((1, 3))])
        turned = np.linalg.det(np.stack([*(corners[e, 1:] - corners[e, 0])])) * np.linalg.det(base) < 0.0
        for f, points in enumerate(places):  # of element f over (or under) element e
            areas = np.linalg.solve(base, np.concatenate([points.T, np.ones((1, len(points)))])).T
            common = areas.min(axis=1) > 0.0
            if common.any() and panels[e] != panels[f]:
                own = inside[common] @ nearly.stowed[mesh.triangles[f], 1]
                higher = np.sign(own - areas[common] @ nearly.stowed[element, 1]).mean()
                assert abs(higher) == 1.0
                # x and z are turned against each other, so the normal of what is not turned over is -y
                orders.append([panels[f], panels[e], int(higher) * (1 if turned else -1)])
    points = opened(mesh, panels, np.array(orders), shut)
    assert 0.05 * SLOPE < np.ptp(points[:, 1]) < SLOPE
    collisions = ipctk.CollisionMesh(points * [1.0, 1e3, 1.0], mesh.edges, mesh.triangles)
    assert not ipctk.has_intersections(collisions, points * [1.0, 1e3, 1.0])


@pytest.mark.parametrize("layers", [2, 4])
def test_a_flat_stack_is_shaken_without_crossing(tmp_path, layers):
    """Every accepted step, on the drawn triangles."""
    result = run(scene(tmp_path, accordion(layers), 1.5e-3, seed=layers, refine=1))
    assert result.summary["status"] == "done"
    triangles = result.surface.triangles
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    collisions = ipctk.CollisionMesh(result.frames[0].points, edges, triangles)
    crossed = [frame.time for frame in result.frames if ipctk.has_intersections(collisions, frame.points)]
    print(f"{layers} layers: {len(result.frames)} frames, {result.history['contacts_sts'].max():.0f} contacts at most")
    assert not crossed
    assert result.history["contacts_sts"].max() > 50
