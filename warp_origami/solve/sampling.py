"""What is read off the state for output: probes, reactions, frames of the animation with their fields."""

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.model.locate import area_coordinates
from warp_origami.model.submesh import Submesh, build_submesh, drawn_divisions
from warp_origami.system import System
from warp_origami.terms.contact import PressureField
from warp_origami.terms.shapes import tabulate

from .records import Frame


class Probes:
    """Values at the scene's probes: position, velocity, and stress averaged over touching elements by area."""

    def __init__(self, system: System):
        mesh = system.mesh
        self.names = [probe.name for probe in system.scene.probe]
        found = system.probe_places
        self.first = np.cumsum([0] + [len(elements) for elements, _ in found])
        if not found:
            return
        elements = np.concatenate([e for e, _ in found])
        table = tabulate(mesh, elements, np.concatenate([a for _, a in found]))
        self.interpolation = table.interpolation(system.coordinates)[self.first[:-1]]
        self.sampler = system.membrane.sampler(table)
        self.weights = mesh.areas[elements]

    def __call__(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """name -> values of PROBE_COLUMNS."""
        if not self.names:
            return {}
        stress = self.sampler(q)
        columns = [
            np.add.reduceat(values * self.weights, self.first[:-1]) / np.add.reduceat(self.weights, self.first[:-1])
            for values in (stress.von_mises, stress.s1, stress.s2)
        ]
        table = np.column_stack([self.interpolation @ q, self.interpolation @ v, *columns])
        return dict(zip(self.names, table, strict=True))


class Reactions:
    """Resultant force and moment about the origin of every named support and driver."""

    def __init__(self, system: System):
        constraints = system.constraints
        named = [(k, p.name) for k, p in enumerate(constraints.prescribers) if p.name is not None]
        self.positions = np.flatnonzero(system.translation)
        owner = np.full(len(constraints.sources), -1)
        prescribed = constraints.sources >= 0
        owner[prescribed] = constraints.rows.prescribers[constraints.sources[prescribed]]
        self.maps = []
        for k, name in named:
            mine = np.flatnonzero(owner == k)
            self.maps.append((name, mine, constraints.equations[mine].T.tocsr()))

    def __call__(self, forces: np.ndarray, q: np.ndarray) -> dict[str, np.ndarray]:
        """name -> (fx, fy, fz, mx, my, mz) on the sheet, from the (m,) generalized forces of the equations."""
        values = {}
        for name, mine, spread in self.maps:
            generalized = (spread @ forces[mine]).reshape(-1, 3)
            force = generalized[self.positions].sum(axis=0)
            moment = np.cross(q, generalized).sum(axis=0)  # every row of q turns with a rigid rotation
            values[name] = np.concatenate([force, moment])
        return values


class Surface:
    """The drawn sub-mesh: its points and fields at a given q."""

    def __init__(self, system: System):
        mesh, coordinates = system.mesh, system.coordinates
        self.fields = [name for name in system.scene.output.fields]
        self.submesh: Submesh = build_submesh(mesh, drawn_divisions(len(mesh.triangles)))
        table = tabulate(mesh, self.submesh.elements, self.submesh.areas)
        self.interpolation = table.interpolation(coordinates)
        self.nodes = coordinates.positions
        corners = np.column_stack([np.repeat(self.submesh.triangle_elements, 3), self.submesh.triangles.ravel()])
        corners = np.unique(corners, axis=0)
        elements, points = corners.T
        self.sampler = system.membrane.sampler(
            tabulate(mesh, elements, area_coordinates(mesh, elements, self.submesh.flat[points]))
        )
        weights = csr_matrix(
            (mesh.areas[elements], (points, np.arange(len(points)))), shape=(len(self.submesh.flat), len(points))
        )
        total = np.asarray(weights.sum(axis=1)).ravel()
        self.mean = csr_matrix(weights.multiply(1.0 / np.where(total > 0.0, total, 1.0)[:, None]))
        self.contact = system.contact
        self.clock = system.clock
        self.pressure = (
            PressureField(mesh, self.submesh, self.contact.submesh.divisions)
            if "contact_pressure" in self.fields
            else None
        )

    def frame(self, time: float, q: np.ndarray) -> Frame:
        """Points, element corners and fields at q (n, 3).

        Contact, where asked for, is evaluated at q with the sides of the last accepted state.
        """
        stress = self.sampler(q)
        fields = {}
        for name in self.fields:
            if name == "contact_pressure":
                fields[name] = self._contact_pressure(q)
                continue
            fields[name] = self.mean @ getattr(stress, name).astype(float)
            if name == "state":
                fields[name] = np.rint(fields[name])
        nodes = np.zeros((len(self.nodes), 3))
        used = self.nodes >= 0
        nodes[used] = q[self.nodes[used]]
        return Frame(time, self.interpolation @ q, nodes, fields)

    def _contact_pressure(self, q: np.ndarray) -> np.ndarray:
        """Pa, at the drawn points."""
        with self.clock.phase("contact"):
            self.contact.gradient(q)
            pairs = self.contact.active_pairs()
            return self.pressure(pairs.forces, pairs.elements, self.contact.flat_points())
