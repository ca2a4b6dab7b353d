"""Self-contact of the sheet by penalty: surface-to-surface, node-to-surface and mixed, paper section 3."""

from .contact import Contact, ContactSettings, ContactStatistics
from .summary import ContactSummary
from .thickness import CREASE_RATIO

__all__ = ["CREASE_RATIO", "Contact", "ContactSettings", "ContactStatistics", "ContactSummary"]
