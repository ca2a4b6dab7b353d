"""From a scene's tables to terms of the equations of motion."""
