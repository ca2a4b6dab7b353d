"""The verification suite, and the same classes of problems with other parameters and meshes; `pytest -s` prints errors.

Exact values come from exact_membranes.py, exact_annulus.py and exact_strips.py, which know nothing of the program.
"""

import csv
import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial import Delaunay

import warp_origami as wo
from exact_annulus import twisted_annulus
from exact_membranes import clamped_disc, drum, drum_deflection, pillow
from exact_strips import bent_rectangle, uniaxial
from warp_origami.cli import main
from warp_origami.errors import InputError
from warp_origami.model.generators.disc import disc
from warp_origami.model.submesh import build_submesh
from warp_origami.scene.expression import parse
from warp_origami.study.results import read_value, volume
from warp_origami.study.verification.cases import case_names, find_cases
from warp_origami.study.verification.convergence import Claim, Convergence, Level

FILM = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4}
HELD_FLAT = {"at": {"all": True}, "fix": "z"}


def membrane(kind, pattern, material=None, **tables):
    """What a static or modal run gave."""
    analysis = {"kind": kind, "load_steps": tables.pop("load_steps", 1)}
    scene = wo.Scene(name="case", analysis=analysis, pattern=pattern, material=FILM | (material or {}), **tables)
    return wo.simulate(scene)


def last(run, of):
    return read_value(of, run)


def irregular_square(path, side, n, seed):
    """FOLD file of an irregular mesh of a square; returns the points."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(*2 * [np.linspace(0.0, side, n + 1)], indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    inside = (points > 1e-9) & (points < side - 1e-9)  # points of the rim slide along it
    points += np.where(inside, random.uniform(-0.22, 0.22, points.shape) * side / n, 0.0)
    triangles = Delaunay(points).simplices
    one, two = (points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2))
    triangles = triangles[np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) > 1e-6 * (side / n) ** 2]
    path.write_text(json.dumps({"vertices_coords": points.tolist(), "faces_vertices": triangles.tolist()}))
    return points


# The suite -----------------------------------------------------------------------------------------------------------


@cache
def quick(name):
    (case,) = find_cases(name)
    return case.convergence(list(case.levels(quick=True)))


@pytest.mark.parametrize("name", case_names())
def test_quick_meshes_keep_their_tolerances(name):
    found = quick(name.removeprefix("verification/"))
    for k, claim in enumerate(found.claims):
        print(name, claim.name, [f"{error:.1e}" for error in found.errors(k)], "order", found.order(k))
    assert found.passed


@pytest.mark.slow
@pytest.mark.parametrize("name", case_names())
def test_all_meshes_keep_their_tolerances(name):
    (case,) = find_cases(name)
    assert case.convergence(list(case.levels(quick=False))).passed


ORDERS = [
    ("drum", "f11 (Hz)", 4.0),
    ("clamped_disc", "w0 / a", 2.0),
    ("clamped_disc", "S_rim / E", 2.0),
    ("clamped_disc_dead", "S_rim / E", 2.0),
    ("twisted_annulus", "T / T_w, finite s0", 2.0),
    ("twisted_annulus_1e-4", "T / T_w, finite s0", 2.0),
    ("pendulum", "error of lambda", 2.0),
    ("order", "z (m)", 2.0),
    ("order", "F (N)", 2.0),
]


@pytest.mark.parametrize(("name", "value", "order"), ORDERS)
def test_errors_have_the_order_of_the_method(name, value, order):
    found = quick(name)
    assert found.order(claim_of(found, value)) == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize(
    ("name", "value"),
    [("pillow", "w0 / a"), ("pillow", "volume of both halves / a^3"), ("pressed_stack", "gap at the centre (m)")],
)
def test_errors_fall_at_least_by_order_two(name, value):
    """On coarse meshes they fall faster than on fine ones."""
    found = quick(name)
    assert found.order(claim_of(found, value)) > 1.9


def test_a_wrinkle_front_inside_elements_costs_order_two():
    """The force tends to what meshes with edges along the front give, where only the finite strain remains."""
    aligned, unaligned = quick("bent_rectangle"), quick("bent_rectangle_unaligned")
    force = claim_of(aligned, "P / (E t H)")
    limit = aligned.errors(force)
    assert limit[0] == pytest.approx(limit[1], abs=1e-7)
    coarse, fine = (error - limit[1] for error in unaligned.errors(force))
    assert math.log(coarse / fine) / math.log(9.0 / 5.0) == pytest.approx(2.0, abs=0.1)


def claim_of(found, name):
    return [claim.name for claim in found.claims].index(name)


# The same with other parameters and meshes ---------------------------------------------------------------------------


@pytest.mark.parametrize(("side", "stress", "nu"), [(0.35, 4e6, 0.1), (1.3, 2e5, 0.45)])
def test_drum_on_an_irregular_mesh(tmp_path, side, stress, nu):
    irregular_square(tmp_path / "drum.fold", side, 4, seed=1)
    stretch = math.sqrt(1.0 + 2.0 * stress * (1.0 - nu) / FILM["youngs_modulus"])
    pattern = {"kind": "fold", "file": str(tmp_path / "drum.fold"), "initial": {"stretch": [stretch, stretch]}}
    exact = np.array([mode.frequency for mode in drum(side, stress, FILM["density"], 4)])
    worst = []
    for refine in (1, 2):
        run = wo.simulate(
            wo.Scene(
                name="drum",
                analysis={"kind": "modal", "count": 4, "load_steps": 1},
                pattern=pattern | {"refine": refine},
                material=FILM | {"poisson_ratio": nu},
                support=[{"at": {"boundary": True}}],
            )
        )
        errors = np.array(run.summary["frequencies"]) / exact - 1.0
        print(f"drum of {side} m, refined {refine}: {errors}")
        worst.append(np.abs(errors).max())
    assert worst[0] < 4e-3
    assert worst[1] < 3e-4
    assert worst[0] / worst[1] > 10.0


def test_drum_deflection_away_from_the_centre_of_a_rectangle():
    stress, nu, pressure = 2e6, 0.34, 0.05
    stretch = math.sqrt(1.0 + 2.0 * stress * (1.0 - nu) / FILM["youngs_modulus"])
    run = membrane(
        "static",
        {"kind": "sheet", "width": 0.8, "height": 0.4, "nx": 16, "ny": 8, "initial": {"stretch": [stretch, stretch]}},
        support=[{"at": {"boundary": True}}],
        load=[{"kind": "pressure", "value": pressure, "follower": False}],
        probe=[{"name": "there", "at": [0.2, 0.1]}],
    )
    scale = pressure * 0.8**2 / (stress * FILM["thickness"])
    assert last(run, "probes.there.z") / scale == pytest.approx(drum_deflection(0.25, 0.25, 0.5), rel=1e-3)


@pytest.mark.parametrize(("q", "nu", "follower"), [(0.05, 0.2, True), (1e-3, 0.45, False)])
def test_disc_of_graded_rings(q, nu, follower):
    radius = 0.4
    exact = clamped_disc(q, nu, follower)
    unit = FILM["youngs_modulus"] * FILM["thickness"] / radius
    run = membrane(
        "static",
        {"kind": "disc", "radius": radius, "rings": 6, "segments": 64, "grading": 0.6},
        {"poisson_ratio": nu},
        support=[{"name": "rim", "at": {"boundary": True}}],
        load=[{"kind": "pressure", "value": q * unit, "follower": follower}],
        probe=[{"name": "pole", "at": [0.0, 0.0]}, {"name": "middle", "at": [0.2, 0.0]}],
    )
    height = last(run, "probes.pole.z") / radius / exact.w0 - 1.0
    stress = last(run, "probes.pole.s1") / FILM["youngs_modulus"] / exact.stress_pole - 1.0
    middle = np.interp(last(run, "(probes.middle.x ** 2 + probes.middle.y ** 2) ** 0.5") / radius, exact.r, exact.z)
    swept = last(run, "surface.volume") / radius**3 / exact.volume - 1.0
    print(f"disc, q = {q}: w0 {height:.1e}, S_pole {stress:.1e}, volume {swept:.1e}")
    assert abs(height) < 1e-3
    assert abs(stress) < 5e-3
    assert abs(swept) < 3e-3
    assert last(run, "probes.middle.z") / radius == pytest.approx(middle, rel=2e-3)


@pytest.mark.parametrize(("q", "s"), [(8.503401e-3, 1e-2), (3e-2, 1e-3)])
def test_pillow_of_other_residual_stiffness(q, s):
    radius, nu = 0.6, 0.4
    exact = pillow(q, nu, s)
    run = membrane(
        "static",
        {"kind": "disc", "radius": radius, "rings": 8, "segments": 64},
        {"poisson_ratio": nu, "s1": s, "s2": s},
        support=[
            {"at": {"boundary": True}, "fix": "z"},
            {"at": {"near": [0.0, 0.0]}, "fix": "xy"},
            {"at": {"near": [radius, 0.0]}, "fix": "y"},
        ],
        load=[{"kind": "pressure", "value": q * FILM["youngs_modulus"] * FILM["thickness"] / radius}],
        probe=[{"name": "pole", "at": [0.0, 0.0]}],
    )
    height = last(run, "probes.pole.z") / radius / exact.w0 - 1.0
    swept = last(run, "surface.volume") / radius**3 / exact.volume - 1.0
    wrinkled = last(run, "history.wrinkled + history.slack") / (1.0 - exact.wrinkled_from**2) - 1.0
    print(f"pillow, q = {q}, s = {s}: w0 {height:.1e}, volume {swept:.1e}, wrinkled share {wrinkled:.1e}")
    assert abs(height) < 2e-3
    assert abs(swept) < 1e-3
    assert abs(wrinkled) < 0.02


@pytest.mark.parametrize(("b_over_a", "nu", "angle"), [(2.0, 0.1, 3.0), (4.0, 0.4, 6.0)])
def test_annulus_of_other_radii(b_over_a, nu, angle):
    a, prestress, s = 0.1, 1e-5, 1e-6
    exact = twisted_annulus(b_over_a, nu, prestress, angle=angle, s=s)
    stretch = math.sqrt(1.0 + 2.0 * prestress * (1.0 - nu))
    run = membrane(
        "static",
        {
            "kind": "annulus",
            "inner_radius": a,
            "outer_radius": a * b_over_a,
            "rings": 10,
            "segments": 64,
            "grading": b_over_a**0.9,
            "initial": {"stretch": [stretch, stretch]},
        },
        {"poisson_ratio": nu, "s1": s, "s2": s},
        load_steps=4,
        support=[HELD_FLAT, {"at": {"circle": [0.0, 0.0, a * b_over_a]}, "fix": "xy"}],
        driver=[
            {
                "name": "hub",
                "at": {"circle": [0.0, 0.0, a]},
                "axes": "xy",
                "rotate": {"axis": [0.0, 0.0, 1.0], "angle": angle * prestress},
            }
        ],
    )
    first = 2.0 * math.pi * FILM["thickness"] * a**2 * prestress * FILM["youngs_modulus"]
    torque = last(run, "reactions.hub.mz") / first / exact.torque - 1.0
    share = (exact.wrinkled_to**2 - 1.0) / (b_over_a**2 - 1.0)
    wrinkled = last(run, "history.wrinkled + history.slack")
    print(f"annulus b/a = {b_over_a}: torque {torque:.1e}, wrinkled share {wrinkled:.4f}, exact {share:.4f}")
    assert abs(torque) < 5e-3
    assert wrinkled == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize("k", [0.8, 2.0, 6.0])
def test_rectangle_bent_to_other_curvatures(k):
    length, height, load = 0.3, 0.1, 1e-5
    exact = bent_rectangle(k, load, s=1e-5)
    angle, pull = exact.curvature / height * length / 2.0, exact.strain * length / 2.0
    force = load * FILM["youngs_modulus"] * FILM["thickness"] * height

    def end(name, side):
        x = side * length / 2.0
        return {
            "name": name,
            "at": {"box": [[x, -height / 2.0], [x, height / 2.0]]},
            "axes": "x",
            "rotate": {"axis": [0.0, 0.0, -side], "centre": [x, 0.0, 0.0], "angle": angle},
            "translate": [side * pull, 0.0, 0.0],
        }

    run = membrane(
        "static",
        {
            "kind": "sheet",
            "width": length,
            "height": height,
            "nx": 15,
            "ny": 5,
            "origin": [-length / 2.0, -height / 2.0],
        },
        {"s1": 1e-5, "s2": 1e-5},
        support=[HELD_FLAT, {"at": {"near": [0.01, height / 2.0]}, "fix": "y"}],
        driver=[end("left", -1.0), end("right", 1.0)],
    )
    moment = 2.0 * last(run, "-reactions.right.mz") / (force * height)
    print(f"k' = {k}: 2M/PH {moment:.6f}, exact {exact.moment:.6f}, P {last(run, 'reactions.right.fx') / force:.6f}")
    assert moment == pytest.approx(exact.moment, rel=2e-3)
    assert last(run, "reactions.right.fx") == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize("model", ["srm", "linear"])
def test_strip_pulled_on_an_irregular_mesh_is_uniaxial(tmp_path, model):
    """Force, energy and contraction to round-off: the exact state is linear in the coordinates."""
    side, strain = 0.4, 0.03
    exact = uniaxial(FILM["youngs_modulus"], FILM["poisson_ratio"], strain, side, FILM["thickness"])
    irregular_square(tmp_path / "strip.fold", side, 3, seed=4)
    run = membrane(
        "static",
        {"kind": "fold", "file": str(tmp_path / "strip.fold")},
        {"model": model},
        support=[
            HELD_FLAT,
            {"at": {"box": [[0.0, 0.0], [0.0, side]]}, "fix": "x"},
            {"at": {"near": [0.0, 0.0]}, "fix": "y"},
        ],
        driver=[
            {
                "name": "pulled",
                "at": {"box": [[side, 0.0], [side, side]]},
                "axes": "x",
                "translate": [strain * side, 0.0, 0.0],
            }
        ],
        probe=[{"name": "corner", "at": [side, side]}],
    )
    assert last(run, "reactions.pulled.fx") == pytest.approx(exact.force, rel=1e-9)
    assert last(run, "history.strain_energy") == pytest.approx(exact.energy * side**2 * FILM["thickness"], rel=1e-9)
    assert last(run, "probes.corner.y") == pytest.approx(exact.width * side, rel=1e-9)


# Values, orders, volumes ---------------------------------------------------------------------------------------------


def test_expressions_take_the_last_row():
    columns = {"history.taut": np.array([1.0, 4.0]), "probes.a-b.z": np.array([2.0, 3.0]), "frequencies.1": 7.0}

    def value(text):
        return parse(text).value(columns.__getitem__)

    assert value("history.taut") == 4.0
    assert value("history.taut ** 0.5 - 2 * probes.a-b.z-probes.a-b.z") == 2.0 - 9.0
    assert value("max(probes.a-b.z - history.taut)") == 1.0
    assert value("-frequencies.1 / (1 + 1)") == -3.5
    assert parse("(history.taut + probes.a-b.z) / history.taut").paths == (
        "history.taut",
        "probes.a-b.z",
        "history.taut",
    )


NO_EXPRESSIONS = """
1 + 2; history; history.taut +; probes.a; taut; __import__('os'); history.taut.real; print(history.taut); [history.taut]
history.taut if 1 else 2; history.taut == 1; max(history.taut, 1); result_0 + history.taut; history.taut + True
"""


@pytest.mark.parametrize("text", ["", *NO_EXPRESSIONS.strip().replace("\n", "; ").split("; ")])
def test_other_texts_are_no_expressions(text):
    with pytest.raises(ValueError):
        parse(text)


LONG = {"terms": "+history.taut" * 3000, "brackets": "(" * 240 + "history.taut" + ")" * 240, "digits": "9" * 400}


@pytest.mark.parametrize("text", [LONG["terms"], LONG["brackets"], "history.taut + " + LONG["digits"]], ids=LONG)
def test_expressions_beyond_all_limits_are_none(text):
    with pytest.raises(ValueError):
        parse(text)


def convergence(values, sizes, exact=1.0, tolerances=None):
    levels = tuple(Level(f"n={n}", n * n, 1, 0.0, (value,)) for n, value in zip(sizes, values, strict=True))
    return Convergence("case", "nowhere", (Claim("x", exact, tolerances or (None,) * len(sizes)),), levels)


def test_order_and_extrapolation_of_a_power():
    sizes = (4, 8, 16)
    found = convergence([1.0 + 3.0 / n**2.5 for n in sizes], sizes)
    assert found.order(0) == pytest.approx(2.5)
    assert found.extrapolated(0) == pytest.approx(1.0, abs=1e-12)
    exact = convergence([1.0, 1.0, 1.0], sizes)
    assert exact.order(0) is None
    assert exact.extrapolated(0) is None


def test_changes_that_hardly_fall_are_not_extrapolated():
    """Order 0.8: what the finest mesh gives is nearer than what would be extrapolated from noise of that size."""
    sizes = (4, 8, 16)
    assert convergence([1.0 + 3.0 / n**0.8 for n in sizes], sizes).extrapolated(0) is None
    assert convergence([1.0 + 3.0 / n**1.1 for n in sizes], sizes).extrapolated(0) == pytest.approx(1.0)


@pytest.mark.parametrize("sizes", [(4, 4, 4), (16, 8, 4), (4, 8, 8), (0, 0, 0)])
def test_levels_that_are_not_finer_have_no_order(sizes):
    found = convergence([1.03, 1.02, 1.015], sizes)
    assert found.order(0) is None
    assert found.extrapolated(0) is None


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_no_number_has_no_order_and_is_missed(value):
    for values in ([1.1, value], [value, 1.1]):
        found = convergence(values, (4, 8), tolerances=(None, 1.0))
        assert found.order(0) is None
        assert not found.passed
    assert convergence([1.1, value, 1.2], (4, 8, 16)).extrapolated(0) is None


def test_errors_are_absolute_where_nothing_is_expected():
    found = convergence([1e-3, 2e-3], (4, 8), exact=0.0, tolerances=(1e-3, 1e-3))
    assert found.errors(0) == [1e-3, 2e-3]
    assert [found.holds(0, i) for i in (0, 1)] == [True, False]
    assert not found.passed
    assert convergence([2.0], (4,), tolerances=(None,)).passed


@pytest.mark.parametrize("divisions", [1, 2, 4])
def test_volume_under_a_cubic_surface(divisions):
    """What sub-triangles leave is of order four in their number; downwards the volume is negative."""
    surface = build_submesh(disc(1.0, 4, 32).mesh, divisions)
    x, y = surface.flat.T
    points = np.stack([x, y, 1.0 - x**2 - y**2 + 0.3 * x**3], axis=1)
    exact = sum(_cubic_volume(surface))
    assert volume(points, surface) == pytest.approx(exact, rel=4e-2 if divisions == 1 else 1e-12)
    assert volume(points * [1.0, 1.0, -1.0], surface) == -volume(points, surface)


def _cubic_volume(surface):
    """Per triangle, by a rule exact for cubics: -27/48 at the centroid, 25/48 at three points inside."""
    corners = surface.flat[surface.triangles]
    for triangle, area in zip(corners, surface.triangle_areas, strict=True):
        for weight, areas in [(-27 / 48, [1 / 3] * 3)] + [(25 / 48, np.roll([0.6, 0.2, 0.2], k)) for k in range(3)]:
            x, y = np.asarray(areas) @ triangle
            yield area * weight * (1.0 - x**2 - y**2 + 0.3 * x**3)


# The command ---------------------------------------------------------------------------------------------------------


def verify(*arguments):
    return CliRunner().invoke(main, ["verify", *map(str, arguments)])


TWO_MESHES = '[["pattern.nx=2", "pattern.ny=2"], ["pattern.nx=3", "pattern.ny=3"]]'


@pytest.fixture
def own_scene(tmp_path):
    """A scene of one's own: the drum, with what is expected of it."""

    def write(exact=31.2744427, of="frequencies.0", tolerance="6e-3", more="", refinement=TWO_MESHES):
        bundled = Path(str(wo.scene.files._find("verification/drum"))).read_text(encoding="utf-8")
        table = f"""[verification]
source = "a book"
refinement = {refinement}
{more}
[[verification.value]]
name = "f11"
of = "{of}"
exact = {exact}
tolerance = {tolerance}
"""
        path = tmp_path / "own.toml"
        path.write_text(bundled.partition("[verification]")[0] + table)
        return path

    return write


def test_a_scene_of_ones_own_is_verified(own_scene, tmp_path):
    ended = verify(own_scene(), "--out", tmp_path / "results")
    assert ended.exit_code == 0, ended.output
    assert "all values are within their tolerances" in ended.output
    with (tmp_path / "results" / "verification.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["elements"] for row in rows] == ["8", "18"]
    assert float(rows[0]["error"]) == pytest.approx(5.4e-3, rel=0.05)
    assert float(rows[1]["order"]) == pytest.approx(4.6, abs=0.1)  # still coarse
    (case,) = json.loads((tmp_path / "results" / "verification.json").read_text())
    assert case["passed"]
    assert (tmp_path / "results" / "own.png").read_bytes().startswith(b"\x89PNG")


def test_a_missed_tolerance_exits_3_and_is_marked(own_scene):
    ended = verify(own_scene(tolerance="[1e-2, 1e-9]"))
    assert ended.exit_code == 3
    assert "MISSED" in ended.output
    assert "missed in" in ended.output
    assert verify(own_scene(tolerance="[1e-2, 1e-9]"), "--quick").exit_code == 0


def test_meshes_that_do_not_differ_are_compared_without_an_order(own_scene, tmp_path):
    same = (
        '[["material.s1=1e-3", "pattern.nx=2", "pattern.ny=2"], ["material.s1=1e-4", "pattern.nx=2", "pattern.ny=2"]]'
    )
    ended = verify(own_scene(refinement=same), "--out", tmp_path / "results")
    assert ended.exit_code == 0, ended.output
    with (tmp_path / "results" / "verification.csv").open() as file:
        assert [row["order"] for row in csv.DictReader(file)] == ["", ""]


def test_a_frequency_beyond_those_of_the_sheet_is_missed(own_scene):
    meshes = (
        '[["analysis.count=9", "pattern.nx=1", "pattern.ny=1"], ["analysis.count=9", "pattern.nx=2", "pattern.ny=2"]]'
    )
    ended = verify(own_scene(of="frequencies.5", tolerance="10.0", refinement=meshes))
    assert ended.exit_code == 3
    assert "frequencies.5: the sheet has only" in ended.output


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"of": LONG["terms"]}, "value.0.of: got 39000 characters, wants a result"),
        ({"of": LONG["brackets"]}, "wants a result"),
        ({"of": "frequencies.6"}, "frequencies.0 to frequencies.5"),
        ({"of": "probes.nobody.z"}, "probes of the scene, which has none"),
        ({"of": "reactions.rim.force"}, "one of the columns fx, fy, fz"),
        ({"of": "frequencies"}, "wants a result"),
        ({"tolerance": "[1e-2]"}, "one number, or 2: one for each mesh"),
        ({"more": "quick = 3"}, "at most the 2 meshes"),
        ({"tolerance": "0.0"}, "a number > 0"),
    ],
)
def test_wrong_tables_exit_2_before_anything_runs(own_scene, change, message):
    ended = verify(own_scene(**change))
    assert ended.exit_code == 2
    assert message in ended.output
    assert ended.output.startswith("verification.")


def test_unknown_names_are_told_what_there_is():
    ended = verify("no_such_case")
    assert ended.exit_code == 2
    assert "NAME: got 'no_such_case'" in ended.output
    assert "drum, " in ended.output
    assert "pendulum" in ended.output


def test_scenes_without_exact_values_cannot_be_verified():
    with pytest.raises(InputError, match=r"verification: got nothing in leaf_in"):
        find_cases("leaf_in")


def test_names_with_and_without_their_folder_are_the_same():
    assert find_cases("drum")[0].name == find_cases("verification/drum")[0].name == "verification/drum"
    assert len(find_cases(None)) == len(case_names())
