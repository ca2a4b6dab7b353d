"""Springs along creases: exact derivatives, fold angles in the sense of FOLD, hinges that turn as springs say."""

import json

import numpy as np
import pytest
from scipy.sparse import identity

import warp_origami as wo
from membrane_cases import rotation
from runs import States, run, system_of
from warp_origami.errors import InputError
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.fold_angles import fold_angles
from warp_origami.model.mesh import CREASE, build_mesh
from warp_origami.terms.crease import CreaseSprings

WIDTH, ARM = 0.4, 0.3
STIFFNESS = 2e-3
STRETCH = 1.001


def two_plates(angle, letter="U"):
    """A square and a rectangle folded by `angle` at their common side, which is along y; q and the spring there."""
    vertices = np.array([[-0.4, 0], [0, 0], [ARM, 0], [ARM, WIDTH], [0, WIDTH], [-0.4, WIDTH]])
    triangles = [[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]]
    mesh = build_mesh(vertices, triangles, np.array([[1, 4]]), np.array([letter]))
    coordinates = number_coordinates(mesh)
    # both sides are folded about the crease by half the angle: no coordinate of the crease's elements is special
    points = np.column_stack([np.abs(vertices[:, 0]) * np.cos(angle / 2), vertices[:, 1], np.zeros(6)])
    points[:, 0] *= np.sign(vertices[:, 0])
    points[:, 2] = np.abs(vertices[:, 0]) * np.sin(angle / 2)
    springs = CreaseSprings(mesh, coordinates, np.flatnonzero(mesh.edge_kinds == CREASE), [STIFFNESS], [0.3])
    return mesh, springs, affine_coordinates(mesh, coordinates, points), points


def sheet(**tables):
    return wo.Scene(
        name="sheet",
        analysis={"kind": "dynamic", "duration": 1.0},
        pattern={"kind": "sheet", "width": 1.0, "height": 0.7, "nx": 3, "ny": 2, "creases_x": [1, 2], "creases_y": [1]},
        material={"density": 1420.0, "youngs_modulus": 1e4, "poisson_ratio": 0.3, "thickness": 1e-3, "model": "linear"},
        **tables,
    )


@pytest.fixture(scope="module")
def bent():
    """A sheet with curved creases that meet, and its springs."""
    system = system_of(sheet(crease=[{"stiffness": 3.0, "rest_angle": 0.4}]))
    rng = np.random.default_rng(0)
    q = system.q0 + 0.1 * rng.normal(size=system.q0.shape) * system.row_lengths[:, None] ** 0.5
    return system, q, system.constraints.null_space @ rng.normal(size=system.constraints.null_space.shape[1])


def test_force_is_minus_the_gradient_of_the_energy(bent):
    system, q, d = bent
    h, d = 1e-6, d.reshape(q.shape)
    energies = [system.creases.gradient(q + sign * h * d)[0] for sign in (1, -1)]
    _, gradient = system.creases.gradient(q)
    assert (energies[0] - energies[1]) / (2 * h) == pytest.approx(np.sum(gradient * d), rel=1e-8)


def test_tangent_is_the_derivative_of_the_force(bent):
    system, q, d = bent
    h, step = 1e-6, d.reshape(q.shape)
    change = (system.evaluate(q + h * step).gradient - system.evaluate(q - h * step).gradient).ravel() / (2 * h)
    sparsity = system.sparsity(identity(q.size, format="csr"))
    tangent = sparsity.matrix(sparsity.values(system.linearize(q).blocks))
    np.testing.assert_allclose(tangent @ d, change, atol=1e-8 * np.abs(change).max())


def test_without_its_geometric_part_the_tangent_has_no_negative_eigenvalue(bent):
    q = bent[1]
    flat = system_of(sheet(crease=[{"stiffness": 3.0, "rest_angle": 0.4}]))
    flat.membrane.linearize(q)
    storage = flat.membrane.storage
    storage.array.zero_()
    flat.creases.add_tangent(q, storage, flat.membrane.blocks.size, geometric=False)
    sparsity = flat.sparsity(identity(q.size, format="csr"))
    values = np.linalg.eigvalsh(sparsity.matrix(sparsity.values(storage.array)).toarray())
    assert values.min() > -1e-12 * values.max()
    assert values.max() > 1.0


def test_rigid_motion_changes_nothing(bent):
    system, q, _ = bent
    turn = rotation([1, 2, 3], 0.8)
    moved = q @ turn.T + np.outer(system.translation, [1.0, -2.0, 3.0])
    energy, gradient = system.creases.gradient(q)
    turned_energy, turned = system.creases.gradient(moved)
    assert turned_energy == pytest.approx(energy, rel=1e-13)
    np.testing.assert_allclose(turned, gradient @ turn.T, atol=1e-12 * np.abs(gradient).max())
    np.testing.assert_allclose(np.cross(q, gradient).sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(gradient[system.translation > 0].sum(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("angle", [-3.1, -1.5, -1e-9, 0.0, 1e-9, 0.7, 3.1])
def test_angles_are_those_of_fold(angle):
    mesh, springs, q, points = two_plates(angle)
    crease = mesh.edge_kinds == CREASE
    np.testing.assert_allclose(springs.angles(q), angle, atol=1e-14)
    np.testing.assert_allclose(fold_angles(mesh, points)[crease], angle, atol=1e-14)
    assert springs.gradient(q)[0] == pytest.approx(0.5 * STIFFNESS * WIDTH * (angle - 0.3) ** 2, rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_angles_are_followed_beyond_half_a_turn(sign):
    _, springs, q, _ = two_plates(0.0)
    for angle in np.linspace(0.0, 1.3 * np.pi, 8):
        _, _, q, _ = two_plates(sign * angle)
        np.testing.assert_allclose(springs.angles(q), sign * angle, atol=1e-13)
        springs.accept(q)


@pytest.mark.parametrize(("letter", "sign"), [("M", -1.0), ("V", 1.0)])
def test_a_fold_that_starts_closed_has_the_sign_of_its_letter(letter, sign):
    for angle in (np.pi, -np.pi, np.nextafter(np.pi, 0)):
        _, springs, q, _ = two_plates(angle, letter)
        np.testing.assert_allclose(springs.angles(q), sign * np.pi, atol=1e-12)


def test_between_taut_plates_the_spring_holds_the_pull_times_its_lever_arm():
    """Held along one edge and pulled at the other: k b (theta_0 - theta) = F d, d from the crease to the line of F."""
    material = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.0, "thickness": 1e-5, "model": "linear"}
    scene = wo.Scene(
        name="pulled",
        analysis={"kind": "static", "load_steps": 2},
        pattern={"kind": "sheet", "width": 2.0, "height": WIDTH, "nx": 2, "ny": 2, "diagonal": "alternate"}
        | {"creases_x": [1]},
        material=material,
        support=[{"at": {"box": [[0.0, 0.0], [0.0, WIDTH]]}}],
        load=[{"kind": "force", "value": [6.0, 0.0, 8.0], "at": {"box": [[2.0, 0.0], [2.0, WIDTH]]}}],
        crease=[{"stiffness": 0.5, "rest_angle": 0.8}],
    )
    states = Final()
    wo.simulate(scene, observers=[states])
    system = system_of(scene)
    place = {x: states.q[system.coordinates.positions[system.mesh.vertices[:, 0] == x]].mean(axis=0) for x in (1, 2)}
    end, arm = (np.cross(place[x], [0.6, 0.0, 0.8])[1] for x in (2, 1))

    assert abs(end) < 3e-4  # the mean of its vertices is not quite where the edge is pulled
    angle = system.creases.angles(states.q).mean()
    assert 0.5 * WIDTH * (0.8 - angle) == pytest.approx(10.0 * abs(arm), rel=3e-3)
    assert 0.01 < angle < 0.7
    assert abs(arm) > 5e-3


class Final(States):
    """Keeps the last q of a static run."""

    def checkpoint(self, arrays):
        self.q = arrays["q"].copy()


def hinge(analysis=None, **tables):
    """A rigid plate on a hinge along the y axis, which a spring joins to a plate that is taut."""
    return wo.Scene(
        name="hinge",
        analysis=analysis or {"kind": "dynamic", "duration": 1.0},
        pattern={"kind": "sheet", "width": 2.0, "height": WIDTH, "origin": [-1.0, 0.0], "nx": 2, "creases_x": [1]}
        | {"initial": {"stretch": [STRETCH, 1.0]}},
        material={"density": 142.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.0, "thickness": 1e-5},
        support=[{"at": {"box": [[-1.0, 0.0], [-1.0, WIDTH]]}}],
        hub={"at": {"box": [[0.0, 0.0], [1.0, WIDTH]]}, "axis": [0, 1, 0], "centre": [0, WIDTH / 2, 0], "mount": "axis"}
        | {"mass": 1.0, "axial_inertia": 1e-4},
        probe=[{"name": "edge", "at": [1.0, 0.0]}],
        output={"fps": 1.0},
        **tables,
    )


PLATE = 142.0 * 1e-5 * WIDTH
"""Mass of the plate, kg, whose edge is STRETCH m from the hinge."""


def test_a_fold_opens_under_its_spring_and_swings_as_an_oscillator():
    """theta = theta_0 (1 - cos(w t)), w^2 = k b / I."""
    inertia = 1e-4 + PLATE * STRETCH**2 / 3.0
    stiffness = 4.0 * inertia / WIDTH  # 2 rad/s
    scene = hinge(
        crease=[{"stiffness": stiffness, "rest_angle": 0.5}],
        integrator={"step": 5e-3, "spectral_radius": 0.8},
    )
    got = run(scene)
    x, _, z = got.probes["edge"][-1, :3]
    assert np.arctan2(z, x) == pytest.approx(0.5 * (1.0 - np.cos(2.0)), rel=2e-3)


def test_a_plate_on_a_spring_has_the_frequency_of_an_oscillator():
    stiffness = 4.0 * (1e-4 + PLATE * STRETCH**2 / 3.0) / WIDTH
    modes = hinge({"kind": "modal", "count": 2, "load_steps": 1}, crease=[{"stiffness": stiffness}])
    assert wo.simulate(modes).summary["frequencies"][0] == pytest.approx(2.0 / (2.0 * np.pi), rel=1e-3)


def test_both_forms_of_the_constraints_give_the_same_motion():
    def motion(form):
        scene = sheet(
            crease=[{"stiffness": 1e-3, "rest_angle": 1.0}],
            integrator={"step": 0.01, "constraints": form},
            support=[{"at": {"box": [[0, 0], [0, 0.7]]}}],
        )
        return run(scene, until=0.1)

    one = motion("eliminate")
    np.testing.assert_allclose(motion("multipliers").q[-1], one.q[-1], atol=1e-8)
    assert np.abs(one.q[-1][:, 2]).max() > 1e-3
    stored = one.history["strain_energy"][0]
    assert stored == pytest.approx(0.5 * 1e-3 * (2 * 0.7 + 1.0), rel=1e-12)  # all creases start flat
    assert one.history["kinetic_energy"].max() > 0.1 * stored
    assert np.abs(one.history["energy_error"]).max() < 0.02 * stored


def test_a_scene_without_springs_compiles_none():
    modules = system_of(sheet()).kernel_modules
    assert not any("crease" in name for name in modules)
    assert not any("crease" in name for name in system_of(sheet(crease=[{"stiffness": 0.0}])).kernel_modules)
    with_springs = system_of(sheet(crease=[{"stiffness": 1.0}]))
    assert "crease springs" in with_springs.terms
    assert any("crease" in name for name in with_springs.kernel_modules)


def test_letters_and_places_choose_creases_and_the_stowed_state_gives_rest_angles():
    pattern = {"kind": "sheet", "nx": 3, "ny": 1, "creases_x": [1, 2], "opening": 1.0}
    material = {"density": 1.0, "youngs_modulus": 1.0, "poisson_ratio": 0.0, "thickness": 1.0}
    base = {"name": "fan", "analysis": {"kind": "static"}, "pattern": pattern, "material": material}
    system = system_of(wo.Scene(**base, crease=[{"stiffness": 1.0, "rest_angle": "stowed"}]))
    angles = system.creases.angles(system.q0)
    assert np.sort(angles[:, 0]) == pytest.approx([1.0 - np.pi, np.pi - 1.0])
    assert system.creases.gradient(system.q0)[0] < 1e-20
    system = system_of(wo.Scene(**base, crease=[{"stiffness": 1.0, "assignment": "M"}]))
    assert system.creases.angles(system.q0)[:, 1] == pytest.approx([1.0 - np.pi])
    right = {"box": [[0.5, 0.0], [1.0, 1.0]]}
    assert len(system_of(wo.Scene(**base, crease=[{"stiffness": 1.0, "at": right}])).creases.rows) == 1
    with pytest.raises(InputError, match=r"crease\.0"):
        system_of(wo.Scene(**base, crease=[{"stiffness": 1.0, "assignment": "U"}]))
    flat = base | {"pattern": {"kind": "sheet", "nx": 2, "creases_x": [1]}}
    with pytest.raises(InputError, match=r"crease\.0\.rest_angle"):
        system_of(wo.Scene(**flat, crease=[{"stiffness": 1.0, "rest_angle": "stowed"}]))


@pytest.mark.parametrize(("letter", "angle"), [("M", -180.0), ("V", 180.0), ("M", -120.0)])
def test_rest_angles_of_a_fold_file_are_its_fold_angles(tmp_path, letter, angle):
    """edges_foldAngle, in degrees; flat-folded mountains and valleys are told apart by their letters."""
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]]
    fold = {
        "file_spec": 1.2,
        "frame_classes": ["creasePattern"],
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
        "edges_vertices": edges,
        "edges_assignment": ["B"] * 6 + [letter],
        "edges_foldAngle": [None] * 6 + [angle],
        "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
    }
    (tmp_path / "two.fold").write_text(json.dumps(fold), encoding="utf-8")
    scene = wo.Scene(
        name="two",
        analysis={"kind": "static"},
        pattern={"kind": "fold", "file": str(tmp_path / "two.fold"), "refine": 2},
        material={"density": 1.0, "youngs_modulus": 1.0, "poisson_ratio": 0.0, "thickness": 1.0},
        crease=[{"stiffness": 1.0, "rest_angle": "stowed"}],
    )
    system = system_of(scene)
    np.testing.assert_allclose(system.creases.angles(system.q0), np.radians(angle), atol=1e-12)
    assert system.creases.gradient(system.q0)[0] < 1e-20
