"""Self-contact of the sheet: surface-to-surface, node-to-surface and mixed, paper section 3; edges; swept test."""

from .contact import Contact, ContactStatistics
from .pressure_field import PressureField
from .settings import ContactSettings

__all__ = ["Contact", "ContactSettings", "ContactStatistics", "PressureField"]
