"""Points of the sheet that contact looks at: nodes of the sub-mesh and slave points, all linear in q.

Slave points are integration points, all nodes of the sub-mesh and, in mixed contact, more points along creases: halfway
between the nodes there, and once more between those and a vertex. Next to a vertex faces that share it pass through
each other first, by a crease, and neither its nodes nor edges that share a vertex hold it there.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, vstack

from warp_origami.model.connectivity import sheet_labels
from warp_origami.model.coordinates import Coordinates
from warp_origami.model.locate import area_coordinates
from warp_origami.model.mesh import CREASE, Mesh
from warp_origami.model.submesh import Submesh

from ..quadrature import rule
from ..shapes import tabulate


@dataclass(frozen=True)
class ContactPoints:
    """Nodes (masters) and slave points; a slave is an integration point (the first sts_count), a node or on a crease.

    Attributes:
        node_count: nodes of the sub-mesh.
        sts_count: integration points among the slaves.
        interpolation: (node_count + slaves, n) matrix: positions of nodes, then slaves, are this times q.
        flat: (node_count + slaves, 2) flat positions, m.
        areas: (sts_count,) reference area that each integration point stands for, m^2.
        owner_starts, owners: faces that slave i belongs to are owners[owner_starts[i] : owner_starts[i + 1]].
        owner_elements: an element of that face at the slave, aligned with owners.
        sheets: (nf,) sheet (connected part of the mesh) of each face.
    """

    node_count: int
    sts_count: int
    interpolation: csr_matrix
    flat: np.ndarray
    areas: np.ndarray
    owner_starts: np.ndarray
    owners: np.ndarray
    owner_elements: np.ndarray
    sheets: np.ndarray

    @property
    def slave_count(self) -> int:
        """Integration points and nodes that are slaves."""
        return self.interpolation.shape[0] - self.node_count

    def slave_shapes(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows of q (slaves, 9) that move each slave point, and their shape functions there."""
        slaves = self.interpolation[self.node_count :]
        return slaves.indices.reshape(-1, 9), slaves.data.reshape(-1, 9)


def build_points(mesh: Mesh, coordinates: Coordinates, submesh: Submesh, method: str, degree: int) -> ContactPoints:
    """Slave points of `method` (mixed, sts, nts) with the quadrature rule of `degree` on every sub-triangle."""
    nodes = tabulate(mesh, submesh.elements, submesh.areas).interpolation(coordinates)
    blocks, flats = [nodes], [submesh.flat]
    areas = np.zeros(0)
    owner_starts, owners, owner_elements = [np.zeros(1, dtype=int)], [], []
    if method in ("sts", "mixed"):
        rule_areas, rule_weights = rule(degree)
        elements = np.repeat(submesh.triangle_elements, len(rule_areas))
        flat = np.einsum("ik,tkd->tid", rule_areas, submesh.flat[submesh.triangles]).reshape(-1, 2)
        blocks.append(tabulate(mesh, elements, area_coordinates(mesh, elements, flat)).interpolation(coordinates))
        flats.append(flat)
        areas = (submesh.triangle_areas[:, None] * rule_weights).ravel()
        owners.append(mesh.faces[elements])
        owner_elements.append(elements)
        owner_starts.append(np.arange(1, len(flat) + 1))
    if method in ("nts", "mixed"):
        # all of them: nodes along creases and free edges are what keeps folds apart (with the pattern's vertices alone
        # they cross), and faces that bulge between integration points are touched by nodes inside them first
        blocks.append(nodes)
        flats.append(submesh.flat)
        starts, faces, elements = _faces_of_nodes(submesh)
        owner_starts.append(starts[1:] + len(areas))
        owners.append(faces)
        owner_elements.append(elements)
    if method == "mixed":
        elements, at = _crease_points(mesh, submesh.divisions)
        blocks.append(tabulate(mesh, elements[:, 0], at).interpolation(coordinates))
        flats.append(np.einsum("kc,kcd->kd", at, mesh.vertices[mesh.triangles[elements[:, 0]]]))
        owner_starts.append(owner_starts[-1][-1] + 2 * np.arange(1, len(at) + 1))
        owners.append(mesh.faces[elements].ravel())
        owner_elements.append(elements.ravel())
    return ContactPoints(
        node_count=len(submesh.flat),
        sts_count=len(areas),
        interpolation=csr_matrix(vstack(blocks)),
        flat=np.concatenate(flats),
        areas=areas,
        owner_starts=np.concatenate(owner_starts).astype(np.int32),
        owners=np.concatenate(owners).astype(np.int32),
        owner_elements=np.concatenate(owner_elements).astype(np.int32),
        sheets=_sheets(mesh),
    )


def _crease_points(mesh: Mesh, divisions: int) -> tuple[np.ndarray, np.ndarray]:
    """The two elements (k, 2) at points between the nodes of creases, and area coordinates (k, 3) in the first."""
    edges = np.flatnonzero(mesh.edge_kinds == CREASE)
    first = mesh.edge_triangles[edges, 0]
    along = np.concatenate([[0.25], np.arange(divisions) + 0.5, [divisions - 0.25]]) / divisions
    corner = np.argmax(mesh.element_edges[first] == edges[:, None], axis=1)  # edge m goes from corner m to m + 1
    at = np.zeros((len(edges), len(along), 3))
    row = np.arange(len(edges))
    at[row, :, corner], at[row, :, (corner + 1) % 3] = 1.0 - along, along
    return np.repeat(mesh.edge_triangles[edges], len(along), axis=0), at.reshape(-1, 3)


def _faces_of_nodes(submesh: Submesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compressed rows of the faces around each node, and an element of each face there."""
    nodes = submesh.triangles.ravel()
    faces, elements = np.repeat(submesh.triangle_faces, 3), np.repeat(submesh.triangle_elements, 3)
    _, first = np.unique(nodes * (submesh.triangle_faces.max() + 1) + faces, return_index=True)
    starts = np.concatenate([[0], np.cumsum(np.bincount(nodes[first], minlength=len(submesh.flat)))])
    return starts, faces[first], elements[first]


def _sheets(mesh: Mesh) -> np.ndarray:
    """Connected part of the mesh that each face belongs to."""
    sheets = np.zeros(mesh.faces.max() + 1, dtype=int)
    sheets[mesh.faces] = sheet_labels(mesh.edges, len(mesh.vertices))[mesh.triangles[:, 0]]
    return sheets
