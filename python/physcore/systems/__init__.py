"""Systems other than bodies, one module each: states with their own laws of motion."""

from __future__ import annotations

from physcore.scene.system import System
from physcore.systems.point_vortices import PointVortices
from physcore.systems.reaction_diffusion import ReactionDiffusion
from physcore.systems.schrodinger import Schrodinger
from physcore.systems.tracers import Tracers
from physcore.systems.wave import Wave

SYSTEMS: tuple[type[System], ...] = (Wave, ReactionDiffusion, Schrodinger, Tracers, PointVortices)
"""All classes of systems. Those registered here can be saved and are tested."""

__all__ = ["SYSTEMS", "System"]
