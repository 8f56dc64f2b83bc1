"""Systems beside matter, one file each: states with laws of motion of their own."""

from __future__ import annotations

from physcore.scene.items import System
from physcore.systems.wave import Wave

SYSTEMS: tuple[type[System], ...] = (Wave,)
"""Every system beside matter; what is registered here can be saved, and is tested."""

__all__ = ["SYSTEMS", "System"]
