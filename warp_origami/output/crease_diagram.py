"""A crease pattern as an SVG drawing: lines by colour and by dashes, vertex names, legend, scale bar."""

import xml.etree.ElementTree as ET
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from warp_origami.model.mesh import BOUNDARY, CREASE, Mesh

DRAWING = 720.0
"""Longer side of the pattern in the drawing, px."""

MARGIN, LEGEND, FOOT = 56.0, 202.0, 64.0
"""Around the pattern, right of it and below it, px."""

STRAIGHT = 1e-9
"""Sine of the angle between sides of elements that are one line."""


@dataclass(frozen=True)
class Style:
    """How lines of one kind are drawn; widths and dashes in px."""

    name: str
    colour: str
    width: float
    dashes: str | None


STYLES = {
    "smooth": Style("flat (F, J): no crease", "#8f8f8f", 0.8, "1 3"),
    "U": Style("crease, unassigned (U)", "#7a3fb0", 1.8, "2 3"),
    "M": Style("mountain (M)", "#c4122f", 2.0, "11 4 2 4"),
    "V": Style("valley (V)", "#1452c8", 2.0, "7 5"),
    "B": Style("boundary (B)", "#111111", 2.6, None),
    "C": Style("cut (C)", "#0a8a3a", 2.6, "14 4"),
}


def crease_diagram(mesh: Mesh, title: str) -> str:
    """SVG of the flat pattern. Lengths are those of the pattern; a vertex is called by its number in the pattern.

    Args:
        mesh: not refined, so that the sides of elements drawn are those of the pattern.
        title: above the drawing.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    scale = DRAWING / float((high - low).max())
    width, height = scale * (high - low)
    places = np.stack(
        [MARGIN + scale * (mesh.vertices[:, 0] - low[0]), MARGIN + scale * (high[1] - mesh.vertices[:, 1])], 1
    )
    size = [width + 2.0 * MARGIN + LEGEND, max(height, 240.0) + MARGIN + FOOT]
    svg = ET.Element(
        "svg",
        {
            "xmlns": "http://www.w3.org/2000/svg",
            "viewBox": f"0 0 {_px(size[0])} {_px(size[1])}",
            "width": _px(size[0]),
            "height": _px(size[1]),
            "font-family": "Helvetica, Arial, sans-serif",
        },
    )
    ET.SubElement(svg, "title").text = f"{title}: crease pattern"
    ET.SubElement(svg, "rect", {"width": "100%", "height": "100%", "fill": "#ffffff"})
    _text(svg, MARGIN, 30.0, title, 18, weight="bold")
    chains = _chains(mesh)
    for kind, style in STYLES.items():
        if chains[kind]:
            group = ET.SubElement(svg, "g", {"class": kind, "fill": "none", **_stroke(style)})
            for chain in chains[kind]:
                points = " ".join(f"{_px(x)},{_px(y)}" for x, y in places[chain])
                ET.SubElement(group, "polyline", {"points": points})
    _vertex_names(svg, mesh, places)
    _legend(svg, chains, width + MARGIN + 36.0)
    _scale_bar(svg, scale, MARGIN, max(height, 240.0) + MARGIN + 30.0, width)
    extent = f"{_length(high[0] - low[0])} x {_length(high[1] - low[1])}"
    counts = f"{len(np.unique(mesh.sources))} vertices, {int(mesh.faces.max()) + 1} faces"
    _text(svg, width + MARGIN + 36.0, MARGIN + 24.0 * len(STYLES) + 36.0, extent, 12)
    _text(svg, width + MARGIN + 36.0, MARGIN + 24.0 * len(STYLES) + 54.0, counts, 12)
    ET.indent(svg, " ")
    return ET.tostring(svg, encoding="unicode") + "\n"


def _kinds(mesh: Mesh) -> dict[str, np.ndarray]:
    """Edges of each kind; of the two sides of a cut one."""
    boundary = np.flatnonzero(mesh.edge_kinds == BOUNDARY)
    middles = mesh.vertices[mesh.edges[boundary]].mean(axis=1)
    pairs = cKDTree(middles).query_pairs(1e-9 * mesh.size, output_type="ndarray").reshape(-1, 2)
    kinds = {
        letter: np.flatnonzero((mesh.edge_assignments == letter) & (mesh.edge_kinds == CREASE)) for letter in "MVU"
    }
    kinds["smooth"] = np.flatnonzero(mesh.edge_assignments == "F")
    kinds["B"] = np.delete(boundary, pairs.ravel())
    kinds["C"] = boundary[pairs[:, 0]]
    return kinds


def _chains(mesh: Mesh) -> dict[str, list[list[int]]]:
    """Ends of each line of each kind: sides that go on straight are one line, so that dashes go on too."""
    return {kind: _joined(mesh, edges) for kind, edges in _kinds(mesh).items()}


def _joined(mesh: Mesh, edges: np.ndarray) -> list[list[int]]:
    at: dict[int, list[int]] = {}
    for e in edges.tolist():
        for v in mesh.edges[e].tolist():
            at.setdefault(v, []).append(e)
    left, chains = set(edges.tolist()), []
    for e in edges.tolist():
        if e not in left:
            continue
        left.discard(e)
        chain = mesh.edges[e].tolist()
        for _ in range(2):
            while (following := _next(mesh, chain, at, left)) is not None:
                left.discard(following)
                chain.append(int(mesh.edges[following].sum()) - chain[-1])
            chain.reverse()
        chains.append([chain[0], chain[-1]])
    return chains


def _next(mesh: Mesh, chain: list[int], at: dict[int, list[int]], left: set[int]) -> int | None:
    """Edge that goes on straight at the end of a chain."""
    ahead = mesh.vertices[chain[-1]] - mesh.vertices[chain[-2]]
    for e in at[chain[-1]]:
        if e in left:
            step = mesh.vertices[int(mesh.edges[e].sum()) - chain[-1]] - mesh.vertices[chain[-1]]
            turn = ahead[0] * step[1] - ahead[1] * step[0]
            if ahead @ step > 0.0 and abs(turn) <= STRAIGHT * np.linalg.norm(ahead) * np.linalg.norm(step):
                return e
    return None


def _vertex_names(svg: ET.Element, mesh: Mesh, places: np.ndarray) -> None:
    """Numbers of the pattern beside its vertices, small enough not to meet."""
    named = np.unique(mesh.sources, return_index=True)[1]
    distance = cKDTree(places[named]).query(places[named], k=2)[0][:, 1] if len(named) > 1 else np.array([DRAWING])
    digits = len(str(int(mesh.sources[named].max())))
    size = float(np.clip(0.75 * np.percentile(distance, 20) / (0.6 * digits), 2.0, 12.0))
    group = ET.SubElement(
        svg,
        "g",
        {
            "class": "names",
            "font-size": _px(size),
            "fill": "#222222",
            "stroke": "#ffffff",
            "stroke-width": _px(0.25 * size),
            "paint-order": "stroke",
        },
    )
    for v in named:
        x, y = places[v]
        ET.SubElement(group, "text", {"x": _px(x + 0.3 * size), "y": _px(y - 0.3 * size)}).text = str(mesh.sources[v])


def _legend(svg: ET.Element, chains: dict[str, list], left: float) -> None:
    for k, kind in enumerate(("M", "V", "U", "B", "C", "smooth")):
        style, y = STYLES[kind], MARGIN + 12.0 + 24.0 * k
        there = bool(chains[kind])
        group = ET.SubElement(svg, "g", {} if there else {"opacity": "0.35"})
        line = {"x1": _px(left), "x2": _px(left + 42.0), "y1": _px(y), "y2": _px(y)}
        ET.SubElement(group, "line", line | _stroke(style))
        _text(group, left + 50.0, y + 4.0, style.name if there else f"{style.name.split(' (')[0]}: none", 12)


def _scale_bar(svg: ET.Element, scale: float, x: float, y: float, width: float) -> None:
    rough = 0.25 * width / scale
    decade = 10.0 ** np.floor(np.log10(rough))
    length = max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= rough)
    end = x + length * scale
    path = f"M{_px(x)} {_px(y - 5)}V{_px(y + 5)}M{_px(x)} {_px(y)}H{_px(end)}M{_px(end)} {_px(y - 5)}V{_px(y + 5)}"
    ET.SubElement(svg, "path", {"d": path, "stroke": "#111111", "stroke-width": "1.6", "fill": "none"})
    _text(svg, end + 8.0, y + 4.0, _length(length), 12)


def _length(metres: float) -> str:
    """A length with a unit that makes it easy to read."""
    for factor, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "um")):
        if metres * factor >= 0.9995:
            return f"{metres * factor:.4g} {unit}"
    return f"{metres:.4g} m"


def _stroke(style: Style) -> dict[str, str]:
    found = {"stroke": style.colour, "stroke-width": _px(style.width), "stroke-linejoin": "round"}
    return found | ({"stroke-dasharray": style.dashes} if style.dashes else {"stroke-linecap": "round"})


def _text(parent: ET.Element, x: float, y: float, text: str, size: int, weight: str = "normal") -> None:
    attributes = {"x": _px(x), "y": _px(y), "font-size": str(size), "font-weight": weight, "fill": "#111111"}
    ET.SubElement(parent, "text", attributes).text = text


def _px(value: float) -> str:
    return f"{float(value):.2f}".rstrip("0").rstrip(".")
