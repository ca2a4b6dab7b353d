"""What contact will model, in numbers, before anything moves."""

from dataclasses import dataclass

import numpy as np

from warp_origami.model.mesh import Mesh
from warp_origami.model.submesh import Submesh

from .narrow import NarrowPhase
from .points import ContactPoints
from .search import Search
from .thickness import CREASE_RATIO, ThicknessTable


@dataclass(frozen=True)
class ContactSummary:
    """Sizes of the contact problem and what the crease rule changes.

    Attributes:
        divisions: sub-triangles along an element's side.
        sub_triangles: masters.
        sts_points, nts_points: slave points.
        layers: faces.
        edges: creases and free edges that are held apart from each other.
        pairs: pairs of a point and a layer near each other in the start.
        left_out: pairs without thickness: points on a layer that they are not part of (lips of a cut), or layers that
            coincide in the start.
        weakened_by_crease: further pairs whose thickness is limited by the distance to the layer in the flat sheet.
        weakened_by_start: further pairs whose thickness is limited by their distance in the start.
        crease_neighbours: (k, 2) pairs of faces that share a crease.
        vertex_neighbours: (k, 2) pairs of faces that share a vertex but no crease.
    """

    divisions: int
    sub_triangles: int
    sts_points: int
    nts_points: int
    layers: int
    edges: int
    pairs: int
    left_out: int
    weakened_by_crease: int
    weakened_by_start: int
    crease_neighbours: np.ndarray
    vertex_neighbours: np.ndarray

    def lines(self) -> list[tuple[str, str]]:
        """The same in words, for `check`."""

        def listed(pairs):
            return f"{len(pairs)}: " + " ".join(f"{f}-{g}" for f, g in pairs) if len(pairs) else "none"

        return [
            ("contact points", f"{self.sts_points} surface-to-surface, {self.nts_points} node-to-surface"),
            ("contact edges", f"{self.edges} creases and free edges, held apart from each other"),
            ("contact masters", f"{self.sub_triangles} sub-triangles in {self.layers} layers (faces)"),
            ("contact pairs near", f"{self.pairs} of a point and a layer at the start"),
            (
                "crease rule",
                f"the thickness that counts between a point and a layer is at most {CREASE_RATIO:g} of their distance "
                f"in the flat sheet and at first at most their distance at the start: {self.left_out} pairs left out, "
                f"{self.weakened_by_crease} weakened by the first, {self.weakened_by_start} by the second",
            ),
            ("  faces with a crease", listed(self.crease_neighbours)),
            ("  faces with a vertex", listed(self.vertex_neighbours)),
        ]


def summarize(
    mesh: Mesh,
    submesh: Submesh,
    points: ContactPoints,
    table: ThicknessTable,
    search: Search,
    state: NarrowPhase | None,
    edges: int,
) -> ContactSummary:
    """Counts what `Contact` has set up."""
    none = table.values <= 1e-9 * mesh.size
    weak = ~none & (table.values < table.thickness)
    by_crease = _sorted_pairs(mesh.faces[mesh.edge_triangles[mesh.edge_triangles.min(axis=1) >= 0]])
    return ContactSummary(
        divisions=submesh.divisions,
        sub_triangles=len(submesh.triangles),
        sts_points=points.sts_count,
        nts_points=points.slave_count - points.sts_count,
        layers=search.layer_count,
        edges=edges,
        pairs=0 if state is None else len(state.keys),
        left_out=int(none.sum()),
        weakened_by_crease=int((weak & table.by_crease).sum()),
        weakened_by_start=int((weak & ~table.by_crease).sum()),
        crease_neighbours=by_crease,
        vertex_neighbours=_vertex_neighbours(mesh, by_crease),
    )


def _sorted_pairs(pairs: np.ndarray) -> np.ndarray:
    """Each pair of different faces once."""
    return np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)


def _vertex_neighbours(mesh: Mesh, by_crease: np.ndarray) -> np.ndarray:
    """Pairs of faces that share a vertex and are not in `by_crease`."""
    around = np.unique(np.stack([mesh.triangles.ravel(), np.repeat(mesh.faces, 3)], axis=1), axis=0)
    starts = np.flatnonzero(np.diff(around[:, 0], prepend=-1))
    rows = [
        (a, b)
        for group in np.split(around[:, 1], starts[1:])
        for i, a in enumerate(group.tolist())
        for b in group[i + 1 :].tolist()
    ]
    known = set(map(tuple, by_crease.tolist()))
    return np.array(sorted(set(rows) - known), dtype=int).reshape(-1, 2)
