"""The speed at which a panel plays, if none is asked for."""

from __future__ import annotations

SHORT, LONG = 1e-6, 0.1
"""Range of time steps that are played in real time [s], or in units of time of the scene."""
STEPS = 4.0
"""Steps per picture at other time steps."""


def nominal_speed(dt: float, fps: float) -> float:
    """Seconds of the simulation per second: 1, or a number of one digit that gives about STEPS steps per picture."""
    return 1.0 if SHORT <= dt <= LONG else float(f"{STEPS * dt * fps:.0e}")
