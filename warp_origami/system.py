"""The equations of motion (57): the terms that a scene needs, its constraints and its initial state.

    M q'' + alpha M q' + beta K q' + grad U(q) + grad U_contact(q) - f(q, t) = -C^T lambda,   C q = d(t)

Here and in compose/ a scene's tables become terms; what a scene does not ask for is not built, compiled or launched.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import warp as wp
from scipy.sparse import csr_matrix, identity, kron

from .clock import PhaseClock
from .compose.bodies import make_hub, make_mass, make_springs
from .compose.contact import contact_settings, make_contact, make_friction
from .compose.loads import load_name, make_loads
from .errors import InputError
from .model.constraints import build_constraints, closed_at_folds
from .model.coordinates import Coordinates, affine_coordinates, number_coordinates
from .model.generators import build_pattern
from .model.hub import ROWS as HUB_ROWS
from .model.hub import hold_hub
from .model.linear_elements import build_linear_constraints
from .model.locate import locate
from .model.mesh import CREASE, Mesh
from .model.opening import opened
from .model.prescribed import prescribed_rows
from .scene import Scene
from .scene.fastened import hub_motion, scene_hub
from .scene.prescribers import scene_prescribers
from .scene.start import initial_velocity
from .terms import padded_pattern
from .terms.contact.friction import Friction
from .terms.device import choose_device
from .terms.external import ExternalForce
from .terms.membrane import Membrane
from .terms.sparsity import ReducedSparsity

LINEAR_DEGREE = 1
"""Degree of the quadrature that is exact where strains are constant."""


@dataclass(frozen=True)
class Evaluation:
    """Energies and their gradient at one q.

    Attributes:
        strain_energy, contact_energy: J; that of springs along creases counts as strain energy.
        gradient: (n, 3) of their sum; N in rows of positions, N m in rows of gradients.
    """

    strain_energy: float
    contact_energy: float
    gradient: np.ndarray


@dataclass(frozen=True)
class Linearization:
    """Energy, gradient and the parts of the tangent, before constraints.

    Attributes:
        energy: J, of strain and contact.
        gradient: (n, 3) as in Evaluation.
        blocks: Warp array of 3x3 blocks, overwritten by the next linearization: (ne, 45) element tangents of the
            membrane and the symmetric part of those of pressure; behind them those of springs and hub, if any.
        contact_rows: (active, 3n) gap gradients, None without contact.
        contact_weights: (active,) stiffness of each, N/m.
        skew: (3n, 3n) skew part of the tangent, None without follower pressure.
    """

    energy: float
    gradient: np.ndarray
    blocks: wp.array
    contact_rows: csr_matrix | None = None
    contact_weights: np.ndarray | None = None
    skew: csr_matrix | None = None


class System:
    """Everything that does not change during a run, and the evaluation of forces at a given q.

    Attributes:
        scene, pattern, mesh, coordinates, constraints: what is modelled.
        mass: (n, n) scalar mass matrix, alike in x, y, z; of the sheet, added masses and the hub.
        hub: what is fixed to it and how it starts; None for a scene without.
        q0, v0: (n, 3) initial state, consistent with the constraints.
        external: gravity, pressure and forces.
        row_lengths: (n,) displacement that a unit change of a row of q causes: 1 for positions, a fraction of the size
            of the elements for gradients, m.
        membrane, creases, rigid_hub, contact, friction: terms; all but the first are None for a scene without them.
        contact_settings: the scene's table of contact with numbers for every "auto"; None without contact.
        probe_places: of each probe, the elements that touch it (k,) and its area coordinates in them (k, 3).
        device: where the kernels run.
        clock: wall time by phase.
    """

    def __init__(self, scene: Scene, device: str | None, clock: PhaseClock):
        """Raises InputError for a scene that cannot be modelled."""
        self.scene, self.clock = scene, clock
        with clock.phase("setup"):
            self.pattern = build_pattern(
                scene.pattern.kind, scene.pattern.parameters(), scene.directory, scene.pattern.refine
            )
            linear = scene.integrator.elements == "linear"
            self.mesh = replace(self.pattern.mesh, linear=linear)
            self.device = choose_device(device)
            self.coordinates = number_coordinates(self.mesh).with_bodies(0 if scene.hub is None else HUB_ROWS)
            flat = affine_coordinates(self.mesh, self.coordinates, _lifted(self.mesh.vertices))
            self.q0 = self._initial_coordinates(flat)
            prescribers = scene_prescribers(scene, self.mesh)
            rows = prescribed_rows(self.mesh, self.coordinates, prescribers, self.q0, flat)
            self.hub = scene_hub(scene, self.mesh, self.coordinates, self.q0, prescribers)
            self.row_lengths = _row_lengths(self.mesh, self.coordinates)
            if self.hub is not None:
                self.q0[self.hub.rows] = self.hub.state
                self.row_lengths[self.hub.rows[1:]] = self.hub.radius
                motion = hub_motion(scene, self.hub)
                prescribers, rows = hold_hub(self.hub, scene.hub.mount, motion, prescribers, rows)
            build = build_linear_constraints if linear else build_constraints
            self.constraints = build(self.mesh, self.coordinates, prescribers, rows, self.hub)
            self.q0 = closed_at_folds(self.constraints, self.q0)
        with clock.phase("compile"):
            self.mass = make_mass(scene, self.mesh, self.coordinates, self.hub)
            self.creases = make_springs(scene, self.pattern, self.mesh, self.coordinates, self.device)
            self.rigid_hub = make_hub(scene, self.hub, self.mass)
            room = sum(term.block_count for term in self._joining)
            degree = LINEAR_DEGREE if linear else scene.integrator.quadrature
            self.membrane = Membrane(self.mesh, self.coordinates, scene.material, degree, self.device, room)
            sheet = (self.mesh, self.coordinates)
            self.v0 = initial_velocity(scene, *sheet, self.constraints, self.hub, self.q0)
            self.contact_settings = self.contact = None
            if scene.contact is not None:
                self.contact_settings = contact_settings(scene, *sheet, self.constraints, self.v0, self.hub)
                self.contact = make_contact(scene, self.contact_settings, self.pattern, *sheet, self.q0, self.device)
            self.friction = make_friction(scene, *sheet)
        with clock.phase("setup"):
            self.probe_places = [
                locate(self.mesh, np.asarray(probe.at, dtype=float), f"probe.{k}.at")
                for k, probe in enumerate(scene.probe)
            ]
            weight = self.mass @ self.translation
            self.external = make_loads(scene, *sheet, weight, self.q0, self.device)

    @cached_property
    def full_mass(self) -> csr_matrix:
        """(3n, 3n) mass matrix on q.ravel()."""
        return kron(self.mass, identity(3), format="csr")

    @cached_property
    def reduced_sparsity(self) -> ReducedSparsity:
        """Structure of T^T K T, which Newton, modes and the count of negative eigenvalues share."""
        return self.sparsity(self.constraints.null_space)

    @property
    def _joining(self) -> list:
        """Terms that join other rows of q than elements do."""
        return [term for term in (self.creases, self.rigid_hub) if term is not None]

    def sparsity(self, transform: csr_matrix) -> ReducedSparsity:
        """Structure of T^T K T for a transform T, (3n, m)."""
        further = [term.rows for term in self._joining]
        return ReducedSparsity(self.coordinates.elements, self.coordinates.count, transform, self.device, further)

    def evaluate(self, q: np.ndarray, contact: bool = True) -> Evaluation:
        """Energies and gradient at q (n, 3), with contact or as if layers passed through each other."""
        with self.clock.phase("assembly"):
            energy, gradient = self.membrane.gradient(q)
            for term in self._joining:
                more, part = term.gradient(q)
                energy, gradient = energy + more, gradient + part
        if self.contact is None or not contact:
            return Evaluation(energy, 0.0, gradient)
        with self.clock.phase("contact"):
            contact_energy, contact_gradient = self.contact.gradient(q)
        return Evaluation(energy, contact_energy, gradient + contact_gradient)

    def linearize(
        self,
        q: np.ndarray,
        external: ExternalForce | None = None,
        mixed: bool = False,
        geometric: bool = True,
        contact: bool = True,
        hub: bool = True,
    ) -> Linearization:
        """Gradient of the energies at q (n, 3), and the tangent of that gradient less the external force, if given;
        `mixed` and `geometric` as in Membrane.linearize, `contact` as in evaluate; `hub`: the tangent has the part that
        keeps the hub rigid."""
        with self.clock.phase("assembly"):
            energy, gradient = self.membrane.linearize(q, mixed, geometric)
            blocks, skew = self.membrane.blocks, None
            if external is not None and external.pressures:
                external.add_stiffness(q, blocks)
                skew = external.skew_stiffness(q)
            if self._joining:
                blocks, first = self.membrane.storage.array, self.membrane.blocks.size
            for term in self._joining:
                more, part = term.gradient(q)
                energy, gradient = energy + more, gradient + part
                if term is self.rigid_hub and not hub:
                    self.membrane.storage.write_at(first, np.zeros((term.block_count, 3, 3)))
                else:
                    term.add_tangent(q, self.membrane.storage, first, geometric)
                first += term.block_count
        if self.contact is None or not contact:
            return Linearization(energy, gradient, blocks, skew=skew)
        with self.clock.phase("contact"):
            contact_energy, contact_gradient, rows, weights = self.contact.tangent(q)
        return Linearization(energy + contact_energy, gradient + contact_gradient, blocks, rows, weights, skew)

    def take_strains(self, q: np.ndarray) -> None:
        """As in Membrane."""
        with self.clock.phase("assembly"):
            self.membrane.take_strains(q)

    def advance_strains(self, q: np.ndarray, step: np.ndarray, length: float) -> None:
        """As in Membrane."""
        with self.clock.phase("assembly"):
            self.membrane.advance_strains(q, step, length)

    def friction_at(self, q: np.ndarray) -> Friction | None:
        """Friction of what touches at q (n, 3), which must be what was last evaluated; None for a scene without."""
        if self.friction is None:
            return None
        with self.clock.phase("contact"):
            return self.friction.between(self.contact.active_pairs(), q)

    def touches(self, q: np.ndarray) -> bool:
        """Whether layers press on each other at q (n, 3)."""
        if self.contact is None:
            return False
        with self.clock.phase("contact"):
            return self.contact.gradient(q)[0] > 0.0

    def accept(self, q: np.ndarray) -> None:
        """Tells the terms with memory (sides of contact pairs, turns of fold angles) that q is an accepted state."""
        if self.creases is not None:
            self.creases.accept(q)
        if self.contact is not None:
            with self.clock.phase("contact"):
                self.contact.accept(q)

    def external_force(self, q: np.ndarray, external: ExternalForce) -> np.ndarray:
        """(n, 3) external force at q."""
        with self.clock.phase("assembly"):
            return external(q)

    def displacement(self, step: np.ndarray) -> float:
        """Largest displacement that a row of a change of q, (n, 3) or (3n,), causes, m."""
        return float(np.max(self.row_lengths * np.linalg.norm(step.reshape(-1, 3), axis=1)))

    @property
    def total_mass(self) -> float:
        """kg, of sheet, added masses and hub."""
        return float(self.translation @ self.mass @ self.translation)

    def kinetic_energy(self, v: np.ndarray) -> float:
        """J."""
        return 0.5 * float(np.sum(v * (self.mass @ v)))

    @property
    def terms(self) -> list[str]:
        """Names of what is modelled."""
        material = self.scene.material
        names = [self.membrane.name]
        names += [self.creases.name] if self.creases is not None else []
        if self.scene.analysis.kind == "dynamic":
            names += ["inertia"]
            names += ["mass damping"] if material.mass_damping > 0.0 else []
            names += ["stiffness damping"] if material.stiffness_damping > 0.0 else []
        names += ["inertia (modes)"] if self.scene.analysis.kind == "modal" else []
        names += [self.contact.name] if self.contact is not None else []
        names += [self.friction.name] if self.friction is not None else []
        names += [load_name(load) for load in self.scene.load]
        names += ["fold lines"] if np.any(self.mesh.edge_kinds == CREASE) else []
        names += ["added masses"] if self.scene.mass else []
        names += [f"{self.rigid_hub.name} ({self.scene.hub.mount})"] if self.rigid_hub is not None else []
        names += ["supports"] if self.scene.support else []
        names += ["drivers"] if self.scene.driver else []
        return names

    @property
    def kernel_modules(self) -> list[str]:
        """Warp modules that the scene compiles."""
        terms = [self.membrane, *(p.term for p in self.external.pressures)]
        terms += [self.creases] if self.creases is not None else []
        terms += [self.contact] if self.contact is not None else []
        modules = [module for term in terms for module in term.kernel_modules]
        modules += [padded_pattern.KERNEL_MODULE] if self.contact is not None else []
        return list(dict.fromkeys(modules))

    def _initial_coordinates(self, flat: np.ndarray) -> np.ndarray:
        initial = self.scene.pattern.initial
        stowed = self.pattern.stowed
        if initial is None:
            initial = "flat" if stowed is None else "stowed"
        if initial == "stowed":
            if stowed is None:
                raise InputError("pattern.initial", '"stowed"', 'a pattern with a stowed state, or "flat"')
            if self.scene.contact is not None:
                stowed = opened(self.mesh, self.pattern.pattern_faces, self.pattern.face_orders, stowed)
            return affine_coordinates(self.mesh, self.coordinates, stowed)
        if initial == "flat":
            return flat
        return affine_coordinates(
            self.mesh, self.coordinates, _lifted(self.mesh.vertices * np.asarray(initial.stretch))
        )

    @cached_property
    def translation(self) -> np.ndarray:
        """(n,) what a unit translation of everything adds to q: 1 in rows of positions, 0 in those of gradients."""
        rows = self.coordinates.positions[self.coordinates.positions >= 0]
        translation = np.zeros(self.coordinates.count)
        translation[rows if self.hub is None else np.append(rows, self.hub.first)] = 1.0
        return translation


def _lifted(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points, np.zeros(len(points))])


def _row_lengths(mesh: Mesh, coordinates: Coordinates) -> np.ndarray:
    side = np.sqrt(mesh.areas.mean())
    lengths = np.full(coordinates.count, 4.0 / 27.0 * side)  # the cubic Hermite function of a slope peaks at 4/27
    lengths[coordinates.positions[coordinates.positions >= 0]] = 1.0
    return lengths
