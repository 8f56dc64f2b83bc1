"""How a scene is computed: integrators, the choices beside the scene, and the arithmetic of time steps."""
