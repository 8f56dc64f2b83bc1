"""Forces, one file each."""

from __future__ import annotations

from physcore.forces.central import CentralForce
from physcore.forces.custom import CustomForce
from physcore.forces.drag import Drag
from physcore.forces.gravity import Gravity
from physcore.forces.lennard_jones import LennardJones
from physcore.forces.repulsion import Repulsion
from physcore.scene.items import Force

FORCES: tuple[type[Force], ...] = (
    Gravity,
    Drag,
    CentralForce,
    CustomForce,
    Repulsion,
    LennardJones,
)
"""Every force; what is registered here can be saved, and is tested."""

__all__ = ["FORCES", "CentralForce", "CustomForce", "Drag", "Force", "Gravity", "LennardJones", "Repulsion"]
