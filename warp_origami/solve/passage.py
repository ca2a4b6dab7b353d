"""Whether the sheet would pass through itself on the way from one accepted state to the next."""

import numpy as np

from warp_origami.system import System

from .result import Failure


def passage(system: System, before: np.ndarray, after: np.ndarray) -> Failure | None:
    """A failure if the sheet passes through itself on the straight way between two states (n, 3), or points are on the
    wrong side of a layer in the second, `after`, where contact is evaluated last."""
    if system.contact is None:
        return None
    with system.clock.phase("contact"):
        found = system.contact.passage(before, after)
    if found is None:
        return None
    one, other = found.kind.split("-")
    (x, y), (u, v) = found.flat
    return Failure(
        f"layers would pass through each other: {_article(one)} of face {found.faces[0]} at ({x:.4g}, {y:.4g}) and "
        f"{_article(other)} of face {found.faces[1]} at ({u:.4g}, {v:.4g}) of the flat sheet",
        'a larger contact.sts_stiffness and nts_stiffness, or "auto"; a finer mesh; smaller loads or slower motion',
    )


def _article(feature: str) -> str:
    return f"an {feature}" if feature[0] in "aeiou" else f"a {feature}"
