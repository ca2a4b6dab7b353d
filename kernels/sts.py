"""Surface-to-surface contact, paper (36), (39): slave points are integration points of the sub-triangles.

    U = sum_I U(g_I, k_I),   k_I = (eps_s / 2) w_I A_I    over integration points I and layers, g_I < 0

w_I A_I is area of the flat reference sheet; (39) as printed counts the area twice (sqrt(det b) is already 2 A). Half
of eps_s, because each of two surfaces is slave to the other: together they are pressed apart by eps_s |g| per area.
"""

import warp as wp

from .point_gap import Contacts, Masters, Motion, Pairs, write_contact
from .precision import real, vec3


@wp.kernel(enable_backward=False)
def sts_contacts(
    positions: wp.array(dtype=vec3),
    reach: real,
    seen: real,
    masters: Masters,
    pairs: Pairs,
    motion: Motion,
    begin: int,
    # out
    contacts: Contacts,
):
    """Gaps of integration points, one thread per pair."""
    pair = begin + wp.tid()
    write_contact(pair, positions[pairs.points[pair]], reach, seen, masters, pairs, motion, contacts)
