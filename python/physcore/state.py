"""Where particles are and how they move, at one moment."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.checks import FloatArray
from physcore.energy import Energy


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Positions and velocities at one time; its arrays are copies."""

    time: float
    """[s]"""
    positions: FloatArray
    """[m], shape (N, D)."""
    velocities: FloatArray
    """[m/s], shape (N, D)."""


@dataclass(frozen=True, eq=False)
class Frame(Snapshot):
    """A snapshot at a frame's time, with the audit of the last step at or before it."""

    energy: Energy
    """The energy budget; `energy.time` is the time of its step."""
    momentum: FloatArray
    """Total momentum [kg·m/s], shape (D,)."""
    angular_momentum: FloatArray
    """Total angular momentum about the origin [kg·m²/s], shape (1,) in 2D and (3,) in 3D."""
