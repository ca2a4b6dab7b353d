"""The verification suite: scenes with exact values over their meshes."""
