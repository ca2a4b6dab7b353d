"""What is simulated, as plain NumPy arrays: patterns, meshes, coordinates, supports and drivers."""
