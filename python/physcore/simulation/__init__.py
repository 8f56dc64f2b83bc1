"""State and clock: the engine's world, the stepper, frames and recordings, and their provenance."""
