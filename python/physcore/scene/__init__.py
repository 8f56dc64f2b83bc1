"""What is there, and nothing about how it is computed: bodies, the bases of forces and boundaries, and the scene."""
