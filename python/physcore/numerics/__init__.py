"""Numerical methods: integrators, options, and the arithmetic of time steps."""
