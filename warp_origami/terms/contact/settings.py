"""What contact needs to know from a scene."""

from typing import Protocol

METHODS = ("mixed", "sts", "nts")


class ContactSettings(Protocol):
    """Method (one of METHODS), penalties of surfaces (N/m^3) and of nodes and edges (N/m), thickness (m),
    and whether that is a hard distance."""

    method: str
    sts_stiffness: float
    nts_stiffness: float
    thickness: float
    exact: bool
