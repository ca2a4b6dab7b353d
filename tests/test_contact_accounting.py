"""What contact tells of itself: balanced forces, consistent normals, numbers of pairs, pressure on the sheet."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import warp_origami as wo
from contact_cases import EPS_S, THICKNESS, TwoSheets, settings, wavy
from contact_meshes import grid, mesh_of
from runs import run
from warp_origami.errors import InputError
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.locate import area_coordinates
from warp_origami.model.submesh import build_submesh
from warp_origami.output.run_directory import RunDirectory
from warp_origami.terms.contact import Contact, PressureField
from warp_origami.terms.shapes import tabulate


class Turned(TwoSheets):
    """A strip on another one that crosses it, in a random state with all kinds of contact."""

    def __init__(self, seed, method="mixed"):
        super().__init__(grid(2, 1, (0.4, 0.05)), grid(2, 1, (0.4, 0.05), (0.003, 0.001), 0.3 + 0.25 * seed))
        self.term = self.contact(method)
        self.term.accept(wavy(self.coordinates, self.at(4 * THICKNESS), seed))
        self.q = wavy(self.coordinates, self.at(0.5 * THICKNESS), seed)


class Folded:
    """Two faces folded together about a crease through the stop there, in a random state."""

    def __init__(self, seed, method="mixed"):
        self.mesh = mesh_of(*grid(4, 2, (0.2, 0.1)), lambda m: np.abs(m[:, 0]) < 1e-9)
        self.coordinates = number_coordinates(self.mesh)
        self.term = Contact(self.mesh, self.coordinates, settings(method), self.at(0.05))
        self.q = wavy(self.coordinates, self.at(0.012), seed, 1e-4, 2e-3)

    def at(self, between):
        x, y = self.mesh.vertices.T
        c, s = -np.cos(between), np.sin(between)
        points = np.stack([np.where(x > 0, x * c, x), y, np.where(x > 0, x * s, 0.0)], axis=1)
        return affine_coordinates(self.mesh, self.coordinates, points)


CASES = [(Turned, m) for m in ("sts", "nts", "mixed")] + [(Folded, m) for m in ("sts", "nts", "mixed")]
IDS = [f"{case.__name__}-{method}" for case, method in CASES]


def evaluated(case, method, seed):
    """A case, its contact forces at its state, and the pairs that touch there."""
    case = case(seed, method)
    energy, gradient = case.term.gradient(case.q)
    assert energy > 0.0
    return case, gradient, case.term.active_pairs()


# Forces --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case, method", CASES, ids=IDS)
@pytest.mark.parametrize("seed", range(3))
def test_forces_and_moments_sum_to_zero(case, method, seed):
    case, gradient, _ = evaluated(case, method, seed)
    forces = gradient[case.coordinates.positions]
    assert np.abs(forces.sum(axis=0)).max() < 1e-13 * np.abs(forces).sum()
    moments = np.cross(case.q, gradient)  # every row of q turns with the sheet
    assert np.abs(moments.sum(axis=0)).max() < 1e-13 * np.abs(moments).sum()


@pytest.mark.parametrize("case, method", CASES, ids=IDS)
def test_no_gap_changes_in_rigid_motion(case, method):
    case, _, pairs = evaluated(case, method, 1)
    rows = pairs.gap_rows()
    still = np.zeros(len(case.q))
    still[case.coordinates.positions] = 1.0
    for axis in np.eye(3):
        moved, turned = np.outer(still, axis), np.cross(axis, case.q)
        assert np.abs(rows @ moved.ravel()).max() < 1e-12
        assert np.abs(rows @ turned.ravel()).max() < 1e-12 * np.abs(rows).sum(axis=1).max()


@pytest.mark.parametrize("method", ["sts", "nts"])
def test_the_force_on_q_is_that_of_the_pairs_along_unit_normals(method):
    """Where nothing fades: what is left is what edges do near their ends."""
    _, gradient, pairs = evaluated(Turned, method, 2)
    np.testing.assert_allclose(np.linalg.norm(pairs.normals, axis=1), 1.0, rtol=1e-12)
    assert pairs.forces.min() > 0.0
    expected = -pairs.factors.T @ (pairs.forces[:, None] * pairs.normals)
    np.testing.assert_allclose(gradient, expected, atol=1e-13 * np.abs(gradient).max())


@pytest.mark.parametrize("case, method", CASES, ids=IDS)
def test_numbers_of_pairs_are_those_that_press(case, method):
    case, _, pairs = evaluated(case, method, 0)
    counted = case.term.statistics()
    points = counted.contacts_sts + counted.contacts_nts
    assert (counted.contacts_sts > 0) == (method != "nts") and (counted.contacts_nts > 0) == (method != "sts")
    assert points + counted.contacts_edge <= len(pairs.forces)
    assert 0.0 < counted.max_penetration < 2.0 * THICKNESS
    if method != "mixed":
        assert points == len(pairs.forces) and counted.contacts_edge == 0


# Pressure ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case, method", CASES, ids=IDS)
def test_pairs_press_where_they_say(case, method):
    """The two flat points of a pair, moved with the sheet, are what its gap lies between; facets are plane there."""
    case, _, pairs = evaluated(case, method, 2)
    flat = case.term.flat_points()
    assert flat.shape == (len(pairs.forces), 2, 2)
    places = []
    for side in (0, 1):
        areas = area_coordinates(case.mesh, pairs.elements[:, side], flat[:, side])
        assert areas.min() > -1e-9
        places.append(tabulate(case.mesh, pairs.elements[:, side], areas).interpolation(case.coordinates) @ case.q)
    moved = pairs.factors @ case.q
    differences = np.minimum(*(np.abs(moved - s * (places[0] - places[1])).max(axis=1) for s in (1, -1)))
    exact = differences < 1e-14
    assert exact.all() or (method == "mixed" and exact.mean() > 0.5 and differences.max() < 0.1 * THICKNESS)


@pytest.mark.parametrize("case, method", CASES, ids=IDS)
@pytest.mark.parametrize("drawn", [1, 2, 3, 4, 5])
def test_no_force_is_lost_in_the_pressure(case, method, drawn):
    case, _, pairs = evaluated(case, method, 1)
    surface = build_submesh(case.mesh, drawn)
    field = PressureField(case.mesh, surface, case.term.submesh.divisions)
    pressure = field(pairs.forces, pairs.elements, case.term.flat_points())
    assert pressure.min() >= 0.0
    assert integral(surface, pressure) == pytest.approx(2.0 * pairs.forces.sum(), rel=1e-12)


def integral(surface, values, where=slice(None)):
    """Integral over the flat sheet of a linear field on the drawn triangles."""
    return float(np.sum((surface.triangle_areas * values[surface.triangles].mean(axis=1))[where]))


def test_matching_sheets_show_the_pressure_between_them_everywhere():
    sheets = TwoSheets(grid(3, 2, (0.3, 0.2)), grid(3, 2, (0.3, 0.2)))
    contact = sheets.contact()
    g = 1.3e-4
    contact.gradient(sheets.at(THICKNESS - g))
    pairs = contact.active_pairs()
    field = PressureField(sheets.mesh, build_submesh(sheets.mesh, 2), contact.submesh.divisions)
    np.testing.assert_allclose(field(pairs.forces, pairs.elements, contact.flat_points()), EPS_S * g, rtol=1e-9)


@pytest.mark.parametrize("refine", [1, 2])
def test_a_pressed_stack_shows_the_prescribed_pressure(refine):
    """Meshes that do not match: the force of each sheet is exact, single points are off by the error of the sums."""
    base = wo.load_scene("scenes/verification/pressed_stack.toml")
    tables = base.model_dump(exclude_none=True, exclude={"verification"})
    tables["pattern"]["refine"] = refine
    result = wo.simulate(wo.Scene(**tables | {"output": {"fps": 1.0, "fields": ["contact_pressure"]}}))
    assert not result.frames[0].fields["contact_pressure"].any()
    pressure = result.frames[-1].fields["contact_pressure"]
    above = result.surface.flat[result.surface.triangles].mean(axis=1)[:, 0] > 0.35
    for sheet in (above, ~above):
        assert integral(result.surface, pressure, sheet) == pytest.approx(1.0 * 0.09, rel=1e-5)
    scatter = np.abs(pressure - 1.0).max()
    print(f"refine {refine}: pressure within {scatter:.1%} of what is prescribed")
    assert scatter < {1: 0.15, 2: 0.06}[refine]


def impact(fields, fps=5e5 / 3.0):
    base = wo.load_scene("two_sheets").model_dump(exclude_none=True)
    return wo.Scene(
        **base | {"output": {"fps": fps, "fields": fields}, "analysis": base["analysis"] | {"duration": 1e-4}}
    )


def test_asking_for_the_pressure_changes_nothing_else():
    """Frames lie between steps: contact is evaluated there, and the run goes on with the same bits."""
    plain, asked = run(impact(["s1"])), run(impact(["contact_pressure"]))
    assert len(asked.frames) > 10
    assert np.array_equal(plain.q, asked.q) and np.array_equal(plain.v, asked.v)
    for name, column in plain.history.items():
        assert np.array_equal(column, asked.history[name]), name
    assert plain.summary["max_penetration"] == asked.summary["max_penetration"] > 0.0
    pressures = [frame.fields["contact_pressure"].max() for frame in asked.frames]
    assert pressures[0] == 0.0 and pressures[-1] > 1e3


def test_frames_hold_the_pressure_of_their_own_time():
    """Between steps as at them: twice the number of frames gives the same ones at the times that both have."""
    coarse, fine = run(impact(["contact_pressure"])), run(impact(["contact_pressure"], 1e6 / 3.0))
    assert len(fine.frames) >= 2 * len(coarse.frames) - 1 > 10
    for one, other in zip(coarse.frames, fine.frames[::2], strict=False):
        assert one.time == pytest.approx(other.time, abs=1e-12)
        np.testing.assert_allclose(
            one.fields["contact_pressure"], other.fields["contact_pressure"], rtol=1e-6, atol=1e-3
        )


def test_layers_that_move_apart_show_no_pressure():
    """Not between steps either, while they get back a thickness that is larger than their distance was."""
    tables = impact(["contact_pressure"]).model_dump(exclude_none=True)
    tables["contact"]["thickness"] = 1e-3
    for load in tables["load"]:
        load["value"] = [0.0, 0.0, -load["value"][2]]
    tables["integrator"]["step"] = 7e-6
    result = wo.simulate(wo.Scene(**tables))
    assert len(result.frames) > 10 and result.history["contact_energy"].max() == 0.0
    assert max(frame.fields["contact_pressure"].max() for frame in result.frames) == 0.0


def test_a_sheet_that_touches_nothing_shows_no_pressure():
    """Also where all kinds of contact are looked for and none is found."""
    tables = wo.load_scene("single_fold").model_dump(exclude_none=True)
    tables |= {"contact": {"method": "mixed"}, "output": {"fps": "steps", "fields": ["contact_pressure"]}}
    result = wo.simulate(wo.Scene(**tables), until=1e-4)
    assert len(result.frames) > 1
    assert not any(frame.fields["contact_pressure"].any() for frame in result.frames)


def test_pressure_in_the_animation(tmp_path):
    """A primvar like any other; its colours reach from zero to what is pressed, however small that part is."""
    result = wo.simulate(impact(["contact_pressure"]), observers=[RunDirectory(tmp_path)])
    stage = Usd.Stage.Open(str(tmp_path / "animation.usdc"))
    sheet = UsdGeom.Mesh.Get(stage, "/World/sheet")
    primvar = UsdGeom.PrimvarsAPI(sheet).GetPrimvar("contact_pressure")
    last = result.frames[-1].fields["contact_pressure"]
    np.testing.assert_allclose(primvar.Get(float(len(result.frames) - 1)), last, rtol=1e-6)
    shown = sheet.GetDisplayColorPrimvar().GetAttr().GetCustomData()
    assert shown["field"] == "contact_pressure" and shown["low"] == 0.0
    assert 0.5 * last.max() < shown["high"] <= 1.001 * max(f.fields["contact_pressure"].max() for f in result.frames)


def test_pressure_without_contact_is_an_error():
    tables = impact(["contact_pressure"]).model_dump(exclude_none=True)
    del tables["contact"]
    with pytest.raises(InputError, match=r"output\.fields.*contact_pressure.*\[contact\]"):
        wo.Scene(**tables)
