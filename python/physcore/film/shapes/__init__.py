"""Geometry of the shapes of rigid bodies for drawing: polygons in 2D, meshes in 3D."""
