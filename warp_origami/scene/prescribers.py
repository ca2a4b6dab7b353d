"""Supports and drivers of a scene as what the model prescribes."""

import numpy as np

from warp_origami.model.mesh import Mesh
from warp_origami.model.prescribed import Motion, Prescriber
from warp_origami.model.selectors import select

from .document import Scene


def scene_prescribers(scene: Scene, mesh: Mesh) -> list[Prescriber]:
    """Supports, then drivers, in the order of the scene; raises InputError for a selection that holds nothing."""
    prescribers = []
    for kind, entries in (("support", scene.support), ("driver", scene.driver)):
        for k, entry in enumerate(entries):
            key = f"{kind}.{k}"
            components = tuple("xyz".index(c) for c in (entry.fix if kind == "support" else entry.axes))
            selection = select(entry.at, mesh, f"{key}.at")
            motion = _motion(entry) if kind == "driver" else None
            prescribers.append(Prescriber(entry.name, key, selection, components, motion))
    return prescribers


def _motion(driver) -> Motion:
    rotate = driver.rotate
    axis = np.array([0.0, 0.0, 1.0]) if rotate is None else np.asarray(rotate.axis) / np.linalg.norm(rotate.axis)
    return Motion(
        profile=driver.profile.factor(),
        translate=np.zeros(3) if driver.translate is None else np.asarray(driver.translate, dtype=float),
        axis=axis,
        centre=np.zeros(3) if rotate is None else np.asarray(rotate.centre, dtype=float),
        angle=0.0 if rotate is None else rotate.angle,
        overstretch=driver.overstretch if driver.translate_to is not None else None,
    )
