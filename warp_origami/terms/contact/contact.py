"""Contact of the sheet with itself and with other sheets: points against layers, edges against edges.

    U_c = U_sts + U_nts + U_edge + U_facet + U_cone

The methods: `sts` and `nts` are the paper's, on their own, and may let layers through; `mixed` has both, edges against
edges, the drawn facets and the tangent cones along creases against each other, and no step is to be taken that leads
the drawn sub-triangles or the tangent cones through each other.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from warp_origami.errors import InputError
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.mesh import CREASE, Mesh
from warp_origami.model.submesh import Submesh, build_submesh, default_divisions, drawn_divisions

from .active_pairs import ActivePairs
from .crease_cones import crease_cones
from .edges import EdgeContact
from .facets import FacetContact
from .features import submesh_features
from .law import contact_law
from .settings import METHODS, ContactSettings
from .summary import ContactSummary
from .surfaces import SurfaceContact
from .swept import Passage, SweptTest


@dataclass(frozen=True)
class ContactStatistics:
    """Contacts of the last evaluated state: pairs with a negative gap and the deepest penetration, m."""

    contacts_sts: int = 0
    contacts_nts: int = 0
    contacts_edge: int = 0
    max_penetration: float = 0.0


class Contact:
    """Contact energy of the sheet as a function of q (n, 3); equal q after equal accepted states gives equal bits.

    Args:
        mesh: flat sheet.
        coordinates: numbering of q.
        settings: method, stiffnesses, thickness.
        initial_q: (n, 3) state of the start, free of contact force by construction.
        face_orders: (k, 3) FOLD faceOrders, for layers that coincide in the start.
        pattern_faces: (ne,) pattern face of each element, needed with face_orders.
        device: of Warp.
        divisions: sub-triangles along an element's side; None: default_divisions.
        sts_degree: of the quadrature rule on each sub-triangle; None: 2 (three points) from four divisions on, else 4.
        guarded: `passage` looks at steps of `sts` and `nts` too.

    Attributes:
        name: for summaries.
        kernel_modules: Warp modules compiled for it.
        submesh: the sub-triangles that touch each other.
        coincident_layers: (k, 2) pairs of faces that coincide in the start, share no vertex and have no face order:
            which lies above is not known, contact between them cannot be right.

    Raises:
        InputError: unknown method.
    """

    def __init__(
        self,
        mesh: Mesh,
        coordinates: Coordinates,
        settings: ContactSettings,
        initial_q: np.ndarray,
        face_orders: np.ndarray | None = None,
        pattern_faces: np.ndarray | None = None,
        device: str = "cpu",
        divisions: int | None = None,
        sts_degree: int | None = None,
        guarded: bool = False,
    ) -> None:
        if settings.method not in METHODS:
            raise InputError("contact.method", settings.method, " or ".join(METHODS))
        self.name, self._mesh = f"contact ({settings.method})", mesh
        self.submesh: Submesh = build_submesh(mesh, divisions or default_divisions(len(mesh.triangles)))
        self._surfaces = SurfaceContact(
            mesh, coordinates, self.submesh, settings, initial_q, face_orders, pattern_faces, device, sts_degree
        )
        features, terms = {}, {"surfaces": self._surfaces}
        if guarded or settings.method == "mixed":
            drawn = drawn_divisions(len(mesh.triangles))
            features["facets"] = submesh_features(mesh, coordinates, build_submesh(mesh, drawn))
            if (mesh.edge_kinds == CREASE).any():
                features["cones"] = crease_cones(mesh, coordinates, drawn)
        self._swept = [SweptTest(mesh, kind, device) for kind in features.values()]
        if settings.method == "mixed":
            terms["edges"] = EdgeContact(
                mesh,
                coordinates,
                self.submesh,
                settings.thickness,
                settings.nts_stiffness,
                initial_q,
                device,
                contact_law(settings.method, settings.exact, settings.thickness),
            )
            terms |= {
                name: FacetContact(mesh, kind, settings.thickness, settings.nts_stiffness, initial_q, device)
                for name, kind in features.items()
            }
        self._terms = terms
        parts = [*self._terms.values(), *self._swept]
        self.kernel_modules = tuple(module for part in parts for module in part.kernel_modules)
        self.coincident_layers = self._surfaces.coincident_layers
        self._last: tuple[np.ndarray, float, np.ndarray] | None = None

    @property
    def reach(self) -> float:
        """Distance (m) up to which a point is seen by a layer, on either side."""
        return self._surfaces.reach

    def passage(self, before: np.ndarray, after: np.ndarray) -> Passage | None:
        """The first passage of the drawn sub-triangles, or of tangent cones, through each other on the straight way
        between two states (n, 3); if there is none, a point that the second state leaves on the wrong side of a cubic
        surface.

        None if there is neither, and for `sts` and `nts` unless they are guarded.
        """
        if not self._swept:
            return None
        self._last = None
        passages = [test.first_passage(before, after) for test in self._swept]
        found = [passage for passage in passages if passage is not None]
        return min(found, key=lambda passage: passage.t) if found else self._gone_through(after)

    def is_free_way(self, before: np.ndarray, after: np.ndarray) -> bool:
        """Whether neither drawn sub-triangles nor cones pass through each other on the straight way between states."""
        return all(test.first_passage(before, after) is None for test in self._swept)

    def _gone_through(self, q: np.ndarray) -> Passage | None:
        """A point that is on the wrong side of a layer at q."""
        elements, flat = self._surfaces.through(q)
        if not len(elements):
            return None
        faces = self._mesh.faces[elements[0]]
        return Passage("point-layer", 1.0, *(_tuples(row) for row in (elements[0], faces, flat[0])))

    def accept(self, q: np.ndarray) -> None:
        """Takes q as an accepted state: from now on all stay on the sides of each other where they are in q."""
        self._last = None
        for term in self._terms.values():
            term.accept(q)

    def gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Contact energy (J) and its gradient (n, 3): minus the contact forces (36), (44)."""
        # a search along a line ends where Newton goes on
        if self._last is None or not np.array_equal(self._last[0], q):
            parts = [term.gradient(q) for term in self._terms.values()]
            self._last = np.array(q), sum(energy for energy, _ in parts), sum(gradient for _, gradient in parts)
        _, energy, gradient = self._last
        return energy, gradient.copy()

    def tangent(self, q: np.ndarray) -> tuple[float, np.ndarray, csr_matrix, np.ndarray]:
        """Energy, gradient, G (active, 3 n) and weights (active,): the main part (38), (45) is G^T diag(weights) G.

        Row i of G is the gradient of gap i with respect to q.ravel(), entries of one column to be summed where the
        slave and the master share a coordinate; weights are the stiffnesses, N/m.
        """
        energy, gradient = self.gradient(q)
        pairs = ActivePairs.joined([term.active_pairs() for term in self._terms.values()])
        return energy, gradient, pairs.gap_rows(), pairs.stiffness

    def active_pairs(self) -> ActivePairs:
        """Touching pairs of the last evaluated state; those of cones hold angles, and have no place on the sheet."""
        return ActivePairs.joined([term.active_pairs() for term in self._placed()])

    def flat_points(self) -> np.ndarray:
        """(k, 2, 2) flat positions (m) of the two points of each of active_pairs()."""
        return np.concatenate([term.flat_points() for term in self._placed()])

    def _placed(self) -> list:
        """Terms whose pairs are places of the sheet that touch."""
        return [term for name, term in self._terms.items() if name != "cones"]

    def statistics(self) -> ContactStatistics:
        """Contacts of the last evaluated state."""
        sts, nts, depth = self._surfaces.statistics()
        if "edges" not in self._terms:
            return ContactStatistics(sts, nts, 0, depth)
        edge, edge_depth = self._terms["edges"].statistics()
        vertex_facets, edge_facets = self._terms["facets"].counts()
        return ContactStatistics(sts, nts + vertex_facets, edge + edge_facets, max(depth, edge_depth))

    def summary(self) -> ContactSummary:
        """What will be modelled, for `check`."""
        return self._surfaces.summary(len(self._terms["edges"].curves.vertices) if "edges" in self._terms else 0)

    def state(self) -> dict[str, np.ndarray]:
        """Accepted state for a checkpoint; after `restore` all results continue bitwise."""
        return {f"{name}.{key}": value for name, term in self._terms.items() for key, value in term.state().items()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Takes the accepted state from `state`."""
        self._last = None
        for name, term in self._terms.items():
            prefix = f"{name}."
            term.restore({key.removeprefix(prefix): v for key, v in state.items() if key.startswith(prefix)})


def _tuples(array: np.ndarray) -> tuple:
    """Rows of an array as plain tuples."""
    return tuple(tuple(row) if isinstance(row, list) else row for row in array.tolist())
