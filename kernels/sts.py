"""Surface-to-surface contact, paper (36), (39): slave points are integration points of the sub-triangles.

    U = sum_I 1/2 (eps_s / 2) w_I A_I g_I^2    over integration points I and layers, g_I < 0

w_I A_I is area of the flat reference sheet; (39) as printed counts the area twice (sqrt(det b) is already 2 A). Half
of eps_s, because each of two surfaces is slave to the other: together they are pressed apart by eps_s |g| per area.
"""

import warp as wp

from .penalty import Contacts, Masters, Pairs, write_contact
from .precision import real, vec3


@wp.kernel(enable_backward=False)
def sts_contacts(
    positions: wp.array(dtype=vec3),
    stiffness: wp.array(dtype=real),
    reach: real,
    first: int,
    masters: Masters,
    pairs: Pairs,
    # out
    contacts: Contacts,
):
    """Contact of integration points, one thread per pair; stiffness (N/m) is eps_s w A / 2 of the pair's point."""
    pair = first + wp.tid()
    point = pairs.points[pair]
    write_contact(pair, positions[point], stiffness[point], reach, masters, pairs, contacts)
