"""Node-to-surface contact, paper (44): slave points are nodes of the sub-mesh at mesh vertices, creases and free edges.

U = sum_I 1/2 eps_n g_I^2    over nodes I and layers, g_I < 0
"""

import warp as wp

from .closest_point import Surface
from .penalty import Contacts, Pairs, write_contact
from .precision import real, vec3


@wp.kernel(enable_backward=False)
def nts_contacts(
    positions: wp.array(dtype=vec3),
    stiffness: real,
    reach: real,
    first: int,
    surface: Surface,
    pairs: Pairs,
    # out
    contacts: Contacts,
):
    """Contact of nodes, one thread per pair; stiffness is eps_n, N/m."""
    pair = first + wp.tid()
    write_contact(pair, positions[pairs.points[pair]], stiffness, reach, surface, pairs, contacts)
