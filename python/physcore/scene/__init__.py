"""Description of a scene, without its numerics: bodies, base classes of forces and boundaries, and the scene."""
