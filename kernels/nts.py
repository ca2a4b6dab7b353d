"""Node-to-surface contact, paper (44): slave points are all nodes of the sub-mesh.

U = sum_I 1/2 eps_n g_I^2    over nodes I and layers, g_I < 0
"""

import warp as wp

from .penalty import Contacts, Masters, Pairs, write_contact
from .precision import real, vec3


@wp.kernel(enable_backward=False)
def nts_contacts(
    positions: wp.array(dtype=vec3),
    stiffness: real,
    reach: real,
    first: int,
    masters: Masters,
    pairs: Pairs,
    # out
    contacts: Contacts,
):
    """Contact of nodes, one thread per pair; stiffness is eps_n, N/m."""
    pair = first + wp.tid()
    write_contact(pair, positions[pairs.points[pair]], stiffness, reach, masters, pairs, contacts)
