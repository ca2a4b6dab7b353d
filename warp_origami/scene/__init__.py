"""What a user asks for, validated: the scene file and its tables."""

from .document import Scene
from .files import load_scene

__all__ = ["Scene", "load_scene"]
