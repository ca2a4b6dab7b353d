"""Two sheets that slide on each other: scenes whose motion is known."""

import json

import numpy as np

import warp_origami as wo
from contact_meshes import grid, joined
from warp_origami.model.connectivity import list_edges

LOWER, UPPER = {"box": [[-1.0, -1.0], [0.9, 1.0]]}, {"box": [[1.1, -1.0], [3.0, 1.0]]}
AREAL_MASS = 1420.0 * 5e-4
SIDE = 0.2
MASS = AREAL_MASS * SIDE**2


def write_sheets(folder, lower, upper, height):
    """A FOLD file of two sheets (vertices and triangles each), the upper one laid over the lower at a height, m."""
    flat, triangles = joined(lower, (upper[0] + [2.0, 0.0], upper[1]))
    edges, beside = list_edges(triangles, len(flat))
    stowed = np.pad(np.concatenate([lower[0], upper[0]]), ((0, 0), (0, 1)))
    stowed[len(lower[0]) :, 2] = height
    content = {
        "frame_unit": "m",
        "vertices_coords": flat.tolist(),
        "faces_vertices": triangles.tolist(),
        "edges_vertices": edges.tolist(),
        "edges_assignment": ["B" if second < 0 else "F" for second in beside[:, 1]],
        "file_frames": [
            {"frame_classes": ["foldedForm"], "frame_inherit": True, "vertices_coords": stowed.tolist()},
        ],
    }
    path = folder / "sheets.fold"
    path.write_text(json.dumps(content))
    return str(path)


def sliding(folder, duration, lower, upper, contact, height=5e-4 * (1.0 + 1e-9), **tables):
    """A scene of two stiff sheets 0.5 mm thick; what touches them is in `tables`."""
    return wo.Scene(
        name="sliding",
        analysis={"kind": "dynamic", "duration": duration},
        pattern={"kind": "fold", "file": write_sheets(folder, lower, upper, height)},
        material={
            "density": 1420.0,
            "youngs_modulus": 2.5e9,
            "poisson_ratio": 0.34,
            "thickness": 5e-4,
            "model": "linear",
        },
        contact={"method": "sts", "sts_stiffness": 1e6, "nts_stiffness": 1e3} | contact,
        output={"fps": 1.0 / duration, "fields": []},
        probe=[{"name": "upper", "at": [2.0, 0.0]}],
        **tables,
    )


def thrown(value, at=UPPER):
    """An initial velocity, m/s."""
    return {"kind": "initial_velocity", "value": value, "at": at}


def pressed(folder, duration, contact, turn=0.0, ramp=8e-3, load=(), integrator=None):
    """A square plate of side SIDE pressed on a held sheet, which is turned, by prescribed motion of 20 um along z.

    Both are single cells held in shape across their plane; the plate is free to slide.
    """
    return sliding(
        folder,
        duration,
        grid(1, 1, (0.6, 0.6), angle=turn),
        grid(1, 1, (SIDE, SIDE)),
        contact,
        support=[{"name": "held", "at": LOWER, "fix": "xyz"}],
        driver=[
            {
                "name": "press",
                "at": UPPER,
                "axes": "z",
                "translate": [0.0, 0.0, -2e-5],
                "profile": {"kind": "smooth", "end": ramp},
            }
        ],
        load=list(load),
        integrator=integrator or {},
    )
