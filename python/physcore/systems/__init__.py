"""Systems beside matter, one file each: states with laws of motion of their own."""

from __future__ import annotations

from physcore.scene.items import System
from physcore.systems.point_vortices import PointVortices
from physcore.systems.reaction_diffusion import ReactionDiffusion
from physcore.systems.schrodinger import Schrodinger
from physcore.systems.tracers import Tracers
from physcore.systems.wave import Wave

SYSTEMS: tuple[type[System], ...] = (Wave, ReactionDiffusion, Schrodinger, Tracers, PointVortices)
"""Every system beside matter; what is registered here can be saved, and is tested."""

__all__ = ["SYSTEMS", "System"]
