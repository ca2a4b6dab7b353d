"""Draws the pictures of docs/patterns.md: crease diagrams and stowed states.

python docs/draw_patterns.py
"""

from pathlib import Path

import matplotlib.image
import numpy as np
from render import camera, draw

from warp_origami.model.mesh import CREASE
from warp_origami.output.crease_diagram import crease_diagram
from warp_origami.scene.patterns import load_pattern

FOLDER = Path(__file__).parent / "patterns"
PATTERNS = {
    "leaf_in": [],
    "leaf_out": [],
    "miura": [],
    "z_fold": [],
    "cross_fold": ["strips=4", "columns=1"],
    "square_twist": ["nx=2", "ny=2"],
}


def stowed_picture(pattern) -> np.ndarray:
    """The stowed state as seen from above and the side."""
    mesh = pattern.mesh
    return draw(pattern.stowed, mesh.triangles, mesh.edges[mesh.edge_kinds == CREASE], camera(pattern.stowed))


def main() -> None:
    """Writes one SVG for each pattern and one PNG with all stowed states, three in a row."""
    FOLDER.mkdir(exist_ok=True)
    pictures = []
    for name, overrides in PATTERNS.items():
        _, pattern = load_pattern(name, overrides)
        title = " ".join([name, *overrides])
        (FOLDER / f"{name}.svg").write_text(crease_diagram(pattern.mesh, title), encoding="utf-8")
        pictures.append(stowed_picture(pattern))
    rows = [np.concatenate(pictures[k : k + 3], axis=1) for k in range(0, len(pictures), 3)]
    picture = np.concatenate(rows).clip(0.0, 1.0)
    matplotlib.image.imsave(FOLDER / "stowed.png", np.round(picture * 31.0) / 31.0)


if __name__ == "__main__":
    main()
