"""What is known of a pattern, in words: its stowed state, its vertices, the way between stowed and flat."""

import numpy as np

from .crossing import find_crossing
from .flat_foldability import vertex_folds
from .folding_path import FoldingPath, folding_path
from .mesh import CREASE
from .opening import unordered_layers
from .pattern import Pattern

LARGEST = 150
"""Vertices of the largest pattern whose folding path is looked for here: it takes seconds."""

MOST_ELEMENTS = 4000
"""Elements up to which crossings are looked for: layers that lie close make pairs by the square of their number."""


def describe_pattern(pattern: Pattern) -> list[tuple[str, str]]:
    """Labels and lines for what a pattern has: of one without creases its size alone."""
    mesh = pattern.mesh
    lines = [("sheet", " x ".join(f"{length:.4g}" for length in np.ptp(mesh.vertices, axis=0)) + " m")]
    if not np.any(mesh.edge_kinds == CREASE):
        return lines
    folds = vertex_folds(mesh)
    if len(folds.vertices):
        count = int(folds.flat_foldable.sum())
        lines.append(("flat-foldable", f"{count} of {len(folds.vertices)} inner vertices (Kawasaki, Maekawa)"))
    if pattern.stowed is None:
        return [*lines, ("stowed state", "none: a run starts flat")]
    lines.append(("stowed state", _describe_stowed(pattern)))
    if len(mesh.vertices) > LARGEST:
        lines.append(("folding path", f"not looked for in a pattern of more than {LARGEST} vertices"))
        return lines
    plane = folding_path(mesh, pattern.stowed)
    if plane is None:
        lines.append(("folding path", "none: the stowed state is flat"))
    elif plane.rigid:
        lines.append(("folding path", f"rigid: strain {plane.strain.max():.1g} at most{_crossed(plane)}"))
    else:
        bent = folding_path(mesh, pattern.stowed, states=41, plane=False)
        line = f"not rigid: strain {_strains(plane)} with plane panels"
        if bent.mean_strain.max() < plane.mean_strain.max():
            line += f"; {_strains(bent)} with panels that bend along sides of elements"
        lines.append(("folding path", line + " (upper bounds)"))
    return lines


def _describe_stowed(pattern: Pattern) -> str:
    mesh, stowed = pattern.mesh, pattern.stowed
    a, b = mesh.edges.T
    flat = np.linalg.norm(mesh.vertices[b] - mesh.vertices[a], axis=1)
    strain = np.abs(np.linalg.norm(stowed[b] - stowed[a], axis=1) / flat - 1.0).max()
    size = " x ".join(f"{length:.3g}" for length in np.ptp(stowed, axis=0))
    parts = [f"{size} m", f"strain {strain:.1g}"]
    if len(pattern.face_orders):
        parts.append(f"order of {len(pattern.face_orders)} pairs of layers")
    if len(mesh.triangles) > MOST_ELEMENTS:
        return ", ".join([*parts, f"crossings not looked for in more than {MOST_ELEMENTS} elements"])
    crossing = find_crossing(stowed, mesh.edges, mesh.triangles)
    parts.insert(2, "no crossing" if crossing is None else "panels cross")
    unknown = unordered_layers(mesh, pattern.pattern_faces, pattern.face_orders, stowed)
    if unknown:
        f, g = unknown[0]
        pairs = f"{len(unknown)} pairs of faces, such as {f} and {g}"
        parts.append(f"layers that lie on each other in unknown order ({pairs}): contact needs their faceOrders")
    return ", ".join(parts)


def _strains(path: FoldingPath) -> str:
    mean, most = (f"{100.0 * strain.max():.2g} %" for strain in (path.mean_strain, path.strain))
    return f"{mean} (root mean square; {most} at most){_crossed(path)}"


def _crossed(path: FoldingPath) -> str:
    where = path.progress[path.crossing]
    if not len(where):
        return ""
    return f" (panels cross between {100 * where.min():.0f} and {100 * where.max():.0f} % of the way)"
