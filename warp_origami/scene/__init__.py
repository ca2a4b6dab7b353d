"""What a user asks for, validated: the scene file and its tables."""

from .document import Scene
from .files import bundled_scenes, load_scene

__all__ = ["Scene", "bundled_scenes", "load_scene"]
