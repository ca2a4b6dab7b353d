"""Solar radiation pressure: the flat plate's closed formula on both sides, exact tangent, no potential, scene."""

import numpy as np
import pytest
from scipy.sparse import identity

import warp_origami as wo
from membrane_cases import distorted_sheet, field_coordinates, linear_field, rotation
from runs import run, system_of
from warp_origami.errors import InputError
from warp_origami.terms.sunlight import Side, Sunlight

JPL = Side(reflectivity=0.88, specular=0.94, emissivity=0.05, lambertian=0.79)
DARK = Side(reflectivity=0.3, specular=0.2, emissivity=0.55, lambertian=0.55)
PRESSURE = 4.56e-6


def plate_force(normal, light, lit, other, area):
    """McInnes (2.57), (2.58): normal and tangential force over P, the normal on the side away from the sun."""
    cosine = normal @ light
    along = light - cosine * normal
    sine = np.linalg.norm(along)
    along = along / sine if sine > 0 else along
    r, s = lit.reflectivity, lit.specular
    heat = 0.0
    if lit.emissivity + other.emissivity > 0:
        balance = lit.emissivity * lit.lambertian - other.emissivity * other.lambertian
        heat = (1 - r) * balance / (lit.emissivity + other.emissivity)
    f_n = (1 + r * s) * cosine**2 + lit.lambertian * (1 - s) * r * cosine + heat * cosine
    f_t = (1 - r * s) * cosine * sine
    return area * (f_n * normal + f_t * along)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, 1.9, 3.0])
@pytest.mark.parametrize(("front", "back"), [(Side(), Side()), (JPL, DARK)], ids=["mirror", "real"])
def test_a_flat_plate_feels_the_closed_formula_on_either_side(angle, front, back):
    mesh, coordinates = distorted_sheet(crease=1)
    turn = rotation([1, 2, 3], 0.7)
    gradient = turn @ np.diag([1.3, 0.8, 1.0])
    q = field_coordinates(mesh, coordinates, linear_field(gradient[:, :2], (0.1, -0.2, 0.3)))
    normal = turn[:, 2]
    light = rotation(turn[:, 0], angle) @ -normal
    term = Sunlight(mesh, coordinates, np.arange(len(mesh.triangles)), 2.0 * light, front, back)
    force = term.force(q)
    lit_front = normal @ light < 0
    sides = (front, back) if lit_front else (back, front)
    expected = plate_force(-normal if lit_front else normal, light, *sides, area=0.36 * 1.3 * 0.8)
    total = force[coordinates.positions].sum(axis=0)
    np.testing.assert_allclose(total, expected, atol=1e-14)
    middle = gradient[:, :2] @ [0.3, 0.3] + [0.1, -0.2, 0.3]
    np.testing.assert_allclose(np.cross(q, force).sum(axis=0), np.cross(middle, expected), atol=1e-14)


def test_a_mirror_facing_the_sun_feels_twice_the_pressure_and_a_black_one_once():
    mesh, coordinates = distorted_sheet()
    q = field_coordinates(mesh, coordinates, linear_field(np.eye(3)[:, :2]))
    for side, factor in ((Side(), 2.0), (Side(reflectivity=0.0), 1.0), (Side(1.0, 0.0), 1.0 + 2.0 / 3.0)):
        term = Sunlight(mesh, coordinates, np.arange(len(mesh.triangles)), np.array([0, 0, -1.0]), side, side)
        total = term.force(q)[coordinates.positions].sum(axis=0)
        np.testing.assert_allclose(total, [0.0, 0.0, -0.36 * factor], atol=1e-14)


def sail(pressure=1.0, **tables):
    optics = {name: vars(side) for name, side in (("front", JPL), ("back", DARK))}
    light = {"kind": "solar", "direction": [0.3, 0.1, -1.0], "value": pressure, **optics}
    return wo.Scene(
        name="sail",
        analysis={"kind": "dynamic", "duration": 1.0},
        pattern={"kind": "sheet", "width": 1.0, "height": 0.7, "nx": 3, "ny": 2, "creases_x": [1], "creases_y": [1]},
        material={"density": 1420.0, "youngs_modulus": 1e3, "poisson_ratio": 0.3, "thickness": 1e-3, "model": "linear"},
        load=[light],
        **tables,
    )


def test_tangent_is_the_derivative_of_the_force():
    """Symmetric part in the element tangents, skew part apart; the sheet is so crumpled that both sides are lit."""
    system = system_of(sail())
    rng = np.random.default_rng(4)
    q = system.q0 + 0.4 * rng.normal(size=system.q0.shape) * system.row_lengths[:, None] ** 0.5
    d = rng.normal(size=q.size)
    external = system.external.at(0.5)

    def balance(h):
        x = q + h * d.reshape(q.shape)
        return (system.evaluate(x).gradient - system.external_force(x, external)).ravel()

    linearization = system.linearize(q, external)
    sparsity = system.sparsity(identity(q.size, format="csr"))
    tangent = sparsity.matrix(sparsity.values(linearization.blocks)) + linearization.skew
    change = (balance(1e-7) - balance(-1e-7)) / 2e-7
    np.testing.assert_allclose(tangent @ d, change, atol=2e-7 * np.abs(change).max())
    assert np.abs(linearization.skew.data).max() > 1e-3
    assert abs(linearization.skew + linearization.skew.T).max() < 1e-14


def test_it_turns_with_light_and_sheet():
    mesh, coordinates = distorted_sheet(crease=1)
    rng = np.random.default_rng(1)
    q = field_coordinates(mesh, coordinates, linear_field(np.eye(3)[:, :2]))
    q += 0.2 * rng.normal(size=q.shape)
    light, turn = np.array([0.3, 0.2, -1.0]), rotation([3, 1, 2], 1.1)
    forces = [
        Sunlight(mesh, coordinates, np.arange(18), direction, JPL, DARK).force(state)
        for direction, state in ((light, q), (turn @ light, q @ turn.T + 0.0))
    ]
    np.testing.assert_allclose(forces[1], forces[0] @ turn.T, atol=1e-14 * np.abs(forces[0]).max() * 10)


def test_a_free_sail_is_accelerated_as_a_whole():
    """2 P / (rho h) for a mirror across the light; with half the profile, half."""
    light = {"kind": "solar", "direction": [0.0, 0.0, 1.0], "profile": {"table": [[0.0, 0.5], [1.0, 0.5]]}}
    scene = wo.Scene(
        name="sail",
        analysis={"kind": "dynamic", "duration": 10.0},
        pattern={"kind": "sheet", "width": 10.0, "height": 10.0, "nx": 2, "ny": 2},
        material={"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.3, "thickness": 7.5e-6},
        load=[light],
        output={"fps": 1.0},
    )
    got = run(scene)
    system = system_of(scene)
    height = got.q[-1][system.coordinates.positions, 2]
    np.testing.assert_allclose(height, 0.5 * PRESSURE / (1420.0 * 7.5e-6) * 10.0**2, rtol=1e-6)
    assert got.history["external_work"][-1] == pytest.approx(got.history["kinetic_energy"][-1], rel=1e-3)
    assert "solar radiation pressure" in got.summary["terms"]
    assert any("sunlight" in name for name in got.summary["kernel_modules"])


def test_a_held_sail_bulges_under_light_in_statics():
    scene = sail(1e-3, support=[{"at": {"boundary": True}}])
    values = scene.model_dump(exclude_none=True) | {"analysis": {"kind": "static", "load_steps": 2}}
    values["probe"] = [{"name": "middle", "at": [0.5, 0.35]}]
    values["load"][0].pop("profile")
    result = wo.simulate(wo.Scene(**values))
    assert result.probes["middle"][-1, 2] < -1e-3


def test_wrong_light_is_refused():
    with pytest.raises(InputError, match=r"load\.0\.direction"):
        sail_with(direction=[0.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"load\.0\.front\.reflectivity"):
        sail_with(front={"reflectivity": 1.2})
    assert sail_with(front={"reflectivity": 0.5}).load[0].back.reflectivity == 0.5
    assert sail_with().load[0].value == PRESSURE


def sail_with(**light):
    return wo.Scene(
        name="sail",
        analysis={"kind": "static"},
        pattern={"kind": "sheet"},
        material={"density": 1.0, "youngs_modulus": 1.0, "poisson_ratio": 0.3, "thickness": 1.0},
        load=[{"kind": "solar", "direction": [0.0, 0.0, -1.0]} | light],
    )
