"""Node-to-surface contact, paper (44): slave points are all nodes of the sub-mesh.

U = sum_I U(g_I, eps_n)    over nodes I and layers, g_I < 0
"""

import warp as wp

from .point_gap import Contacts, Masters, Motion, Pairs, write_contact
from .precision import real, vec3


@wp.kernel(enable_backward=False)
def nts_contacts(
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
    """Gaps of nodes, one thread per pair."""
    pair = begin + wp.tid()
    write_contact(pair, positions[pairs.points[pair]], reach, seen, masters, pairs, motion, contacts)
