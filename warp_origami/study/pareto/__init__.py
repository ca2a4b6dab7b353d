"""Speed against error of a scene over its settings."""
