"""Surface-to-surface contact, paper (36), (39), and node-to-surface contact, paper (44): gaps of slave points.

    U_sts = sum_I U(g_I, k_I),   k_I = (eps_s / 2) w_I A_I     over integration points I of the sub-triangles and layers
    U_nts = sum_I U(g_I, eps_n)                                over nodes I of the sub-mesh and layers;  g_I < 0

w_I A_I is area of the flat reference sheet; (39) as printed counts the area twice (sqrt(det b) is already 2 A). Half
of eps_s, because each of two surfaces is slave to the other: together they are pressed apart by eps_s |g| per area.
Both have the same gap.
"""

import warp as wp

from .point_gap import Contacts, Masters, Motion, Pairs, farthest_of_interest, out_of_reach, write_contact
from .precision import real, vec3


@wp.kernel(enable_backward=False)
def point_contacts(
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
    """Gaps of slave points within `reach` (m), distances up to `seen` (m), one thread per pair."""
    pair = begin + wp.tid()
    point = pairs.points[pair]
    layer = pairs.layers[pair]
    x = positions[point]
    # most pairs end here; on the CPU the functions below cost more to call, with all their arrays, than all of this
    change = wp.length(x - motion.slaves[point] - motion.shifts[layer]) + motion.spreads[layer]
    presses = pairs.thickness[pair] + motion.error[0]
    farthest = farthest_of_interest(pairs.sides[pair], reach, seen, presses, pairs.least[pair], change)
    if farthest < real(0.0):
        out_of_reach(pair, contacts.gaps, contacts.distances, contacts.facets)
    else:
        write_contact(pair, x, reach, farthest, masters, pairs, contacts)
