"""Scenes of free sheets that fly at each other."""

import json

import numpy as np

import warp_origami as wo

FILM = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4}
AREAL_MASS = 0.71


def square(cells, side, centre=(0.0, 0.0)):
    """Vertices (n, 2) and square faces of a sheet of cells x cells, m."""
    x = np.linspace(-0.5, 0.5, cells + 1) * side
    vertices = np.stack([a.ravel() for a in np.meshgrid(x, x)], axis=1) + centre
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    return vertices, np.stack([corner, corner + 1, corner + cells + 2, corner + cells + 1], axis=1)


def write_sheets(path, sheets):
    """FOLD file of sheets (vertices, faces, folded (n, 3)), drawn side by side; returns the box of each."""
    vertices, faces, folded, boxes = [], [], [], []
    for flat, squares, placed in sheets:
        faces += (squares + len(vertices)).tolist()
        shift = [boxes[-1][1][0] + 0.1 if boxes else 0.0, 0.0]
        flat = flat - flat.min(axis=0) + shift
        boxes.append([(flat.min(axis=0) - 0.01).tolist(), (flat.max(axis=0) + 0.01).tolist()])
        vertices += flat.tolist()
        folded += np.asarray(placed).tolist()
    write_fold(path, vertices, faces, folded)
    return boxes


def write_fold(path, vertices, faces, folded):
    """A FOLD file of sheets without creases, folded to given places; faces of four corners."""
    counts = {}
    for face in faces:
        for k in range(4):
            edge = tuple(sorted((face[k - 1], face[k])))
            counts[edge] = counts.get(edge, 0) + 1
    frame = {"frame_classes": ["foldedForm"], "frame_inherit": True, "frame_parent": 0, "vertices_coords": folded}
    content = {
        "frame_classes": ["creasePattern"],
        "vertices_coords": vertices,
        "faces_vertices": faces,
        "edges_vertices": list(counts),
        "edges_assignment": ["B" if count == 1 else "F" for count in counts.values()],
        "file_frames": [frame],
    }
    path.write_text(json.dumps(content))


def scene_of(path, duration, contact, boxes, velocities, **tables):
    """Sheets in `boxes` with initial velocities along z, m/s; None: held."""
    pairs = list(zip(boxes, velocities, strict=True))
    return wo.Scene(
        name="sheets",
        analysis={"kind": "dynamic", "duration": duration},
        pattern={"kind": "fold", "file": str(path)},
        material=FILM,
        contact=contact,
        load=[{"kind": "initial_velocity", "value": [0, 0, v], "at": {"box": b}} for b, v in pairs if v is not None],
        support=[{"at": {"box": box}} for box, v in pairs if v is None],
        output={"fps": 1.0 / duration, "fields": []},
        **tables,
    )


def facing(folder, contact, duration, speed=1.0, cells=(2, 3), angle=0.0, gap=5.5e-4, **tables):
    """Two sheets of 0.3 m, the upper one turned by an angle, that meet flat."""
    (low, low_faces), (high, high_faces) = square(cells[0], 0.3), square(cells[1], 0.3)
    c, s = np.cos(angle), np.sin(angle)
    turned = high @ np.array([[c, s], [-s, c]])
    placed = [np.pad(low, ((0, 0), (0, 1))), np.column_stack([turned, np.full(len(high), gap)])]
    path = folder / "facing.fold"
    boxes = write_sheets(path, [(low, low_faces, placed[0]), (high, high_faces, placed[1])])
    return scene_of(path, duration, contact, boxes, (0.5 * speed, -0.5 * speed), **tables)


def corner_over_sheet(folder, contact, duration, speed, gap=6e-4, **tables):
    """A square of 0.1 m that falls on a free sheet of 0.2 m with its corner, standing upright."""
    (low, low_faces), (high, high_faces) = square(3, 0.2, (0.1, 0.1)), square(2, 0.1, (0.05, 0.05))
    across, up = (high[:, 0] - high[:, 1]) / np.sqrt(2.0), high.sum(axis=1) / np.sqrt(2.0)
    upright = np.column_stack([0.093 + np.cos(0.795) * across, 0.081 + np.sin(0.795) * across, gap + up])
    path = folder / "corner.fold"
    boxes = write_sheets(path, [(low, low_faces, np.pad(low, ((0, 0), (0, 1)))), (high, high_faces, upright)])
    return scene_of(path, duration, contact, boxes, (0.0, -speed), **tables)
