"""Self-contact of the sheet by penalty: surface-to-surface, node-to-surface and mixed, paper section 3."""

from .contact import Contact, ContactSettings, ContactStatistics
from .summary import ContactSummary

__all__ = ["Contact", "ContactSettings", "ContactStatistics", "ContactSummary"]
