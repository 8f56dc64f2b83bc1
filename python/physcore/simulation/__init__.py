"""Simulation: the engine's world, the stepper, frames, recordings and their provenance."""
