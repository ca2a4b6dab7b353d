"""Pattern generators, and the one way from the pattern table of a scene to a pattern."""

from ...errors import InputError
from ..pattern import Pattern
from .sheet import sheet

__all__ = ["sheet"]
