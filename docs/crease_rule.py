"""Draws docs/crease_rule.png: what thickness counts near a crease, where two faces count, where edges fade.

    python docs/crease_rule.py

The formulas are those of terms/contact/thickness.py and kernels/edge_edge.py.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from warp_origami.terms.contact import CREASE_RATIO

THICKNESS = 5e-4
STEEP = 0.35
"""c of the cross-sections, so that there is something to see."""
FACE_A, FACE_B, ZONE, PALE, TWICE = "#2b6cb0", "#c05621", "#f6ad55", "#fdebd0", "#805ad5"


def cross_section(axes, between: float, title: str) -> None:
    """Faces A and B at an angle (rad), and around points of B the distance at which A begins to push them."""
    direction = np.array([np.cos(between), np.sin(between)])
    s = np.linspace(0.02, 1.0, 160)
    reach = np.minimum(0.16, STEEP * s)
    for where, radius in zip(s, reach, strict=True):
        axes.add_patch(plt.Circle(where * direction, radius, color=PALE, lw=0))
    for where in (0.15, 0.35, 0.6, 0.85):
        radius = min(0.16, STEEP * where)
        point = where * direction
        axes.add_patch(plt.Circle(point, radius, fill=False, color=FACE_B, lw=0.8))
        axes.plot(*point, "o", color=FACE_B, ms=3)
    axes.plot([0, 1.05], [0, 0], color=FACE_A, lw=2.5, solid_capstyle="round")
    axes.plot([0, 1.05 * direction[0]], [0, 1.05 * direction[1]], color=FACE_B, lw=2.5, solid_capstyle="round")
    axes.plot(0, 0, "ko", ms=5)
    axes.text(0.98, -0.05, "face A", color=FACE_A, ha="right", va="top")
    end = 1.08 * direction
    axes.text(
        end[0], end[1] + 0.17, "face B", color=FACE_B, ha="left" if direction[0] < -0.5 else "center", va="bottom"
    )
    axes.set_title(title)
    axes.set_xlim(-1.2, 1.2)
    axes.set_ylim(-0.35, 1.15)
    axes.set_aspect("equal")
    axes.axis("off")


def thickness_by_distance(axes) -> None:
    """min(h, c s, d) against s."""
    s = np.linspace(0.0, 40e-3, 400)
    full = np.minimum(THICKNESS, CREASE_RATIO * s)
    stowed = np.minimum(full, 8e-3 * s)
    axes.fill_between(1e3 * s, 1e3 * full, color=ZONE, alpha=0.35, lw=0)
    axes.plot(1e3 * s, 1e3 * full, color=FACE_B, lw=2, label=r"$\min(h,\ c\,s)$")
    axes.plot(
        1e3 * s, 1e3 * stowed, color="k", lw=1.2, ls="--", label=r"stowed at $d = 0.008\,s$: at first $\min(h, c s, d)$"
    )
    axes.annotate("", (30, 0.475), (30, 0.26), arrowprops={"arrowstyle": "->", "color": "k"})
    axes.text(29.3, 0.34, "grows as the\nlayers move apart", ha="right", va="center", fontsize=8)
    axes.plot(2 * [1e3 * THICKNESS / CREASE_RATIO], [0.0, 1e3 * THICKNESS], color="0.6", lw=0.8, ls=":")
    axes.text(1e3 * THICKNESS / CREASE_RATIO + 0.4, 0.03, r"$h/c$", color="0.4")
    axes.set_xlabel("distance $s$ in the flat sheet, mm")
    axes.set_ylabel("thickness that counts, mm")
    axes.set_ylim(0, 0.62)
    axes.set_xlim(0, 40)
    axes.legend(loc="upper left", fontsize=8, frameon=False)
    axes.set_title("Effective thickness of a pair")


def points_over_a_crease(axes) -> None:
    """Where points of a layer far away in the flat sheet have a gap to one face, and where to both."""
    x, z = np.meshgrid(np.linspace(-2.2, 2.2, 900), np.linspace(-1.6, 1.6, 700))
    fall = np.radians(14.0)
    faces = [np.array([-np.cos(fall), -np.sin(fall)]), np.array([np.cos(fall), -np.sin(fall)])]
    inside = []
    for face in faces:
        along = np.maximum(x * face[0] + z * face[1], 0.0)
        inside.append(np.hypot(x - along * face[0], z - along * face[1]) < 1.0)
    count = inside[0].astype(int) + inside[1]
    colours = matplotlib.colors.ListedColormap(["white", ZONE, TWICE])
    axes.contourf(x, z, count, levels=[-0.5, 0.5, 1.5, 2.5], cmap=colours, alpha=0.45)
    for face, colour, name in zip(faces, (FACE_A, FACE_B), ("face A", "face B"), strict=True):
        axes.plot([0, 2.2 * face[0]], [0, 2.2 * face[1]], color=colour, lw=2.5)
        axes.text(1.95 * face[0], 1.95 * face[1] - 0.12, name, color=colour, ha="center", va="top")
    axes.plot(0, 0, "ko", ms=5)
    axes.annotate("", (1.45, 0.63), (1.2, -0.3), arrowprops={"arrowstyle": "<->", "color": "k"})
    axes.text(1.42, 0.12, "$h$")
    axes.text(1.85, 0.2, "B only", ha="center", color="#7b341e")
    axes.text(0, 0.62, "both", ha="center", color="#44337a")
    axes.text(-1.5, 0.2, "A only", ha="center", color="#7b341e")
    axes.set_xlim(-2.2, 2.2)
    axes.set_ylim(-1.6, 1.6)
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_title("Points of another layer over a crease")


def fade(x):
    """M(x) of kernels/edge_edge.py."""
    y = np.clip(x, 0.0, 1.0)
    return y**3 * (10.0 - 15.0 * y + 6.0 * y**2)


def fading_edges(axes) -> None:
    """Weight of a crossing along an edge 8 h long, whose last h on both sides fade."""
    s = np.linspace(0.0, 8.0, 801)
    weight = fade(s) * fade(8.0 - s)
    axes.fill_between(s, weight, color=ZONE, alpha=0.35, lw=0)
    axes.plot(s, weight, color=FACE_B, lw=2)
    axes.set_xlabel("place of the crossing along an edge, over $h$")
    axes.set_ylabel("share of the stiffness")
    axes.set_ylim(0, 1.1)
    axes.set_xlim(0, 8)
    inset = axes.inset_axes([0.34, 0.2, 0.38, 0.42])
    angle = np.linspace(0.0, 4.0, 300)
    inset.plot(angle, fade(np.sin(np.radians(angle)) ** 2 / 1e-3), color=FACE_A, lw=1.5)
    inset.set_xlabel("angle of the edges, deg", fontsize=7)
    inset.tick_params(labelsize=7)
    axes.set_title("Edges fade at their ends and near parallel")


def main() -> None:
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10})
    figure, axes = plt.subplots(2, 3, figsize=(11.5, 6.6), constrained_layout=True)
    stop = np.arcsin(STEEP)
    cross_section(axes[0, 0], np.radians(176.0), "Open: A is out of reach of all points of B")
    cross_section(axes[0, 1], np.radians(55.0), "Folded: still")
    cross_section(axes[0, 2], stop, r"At $\sin\vartheta = c$ all points up to $h/c$ touch")
    thickness_by_distance(axes[1, 0])
    points_over_a_crease(axes[1, 1])
    fading_edges(axes[1, 2])
    figure.savefig(Path(__file__).with_suffix(".png"), dpi=110)


if __name__ == "__main__":
    main()
