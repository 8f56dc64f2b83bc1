"""Forces, one module each."""

from __future__ import annotations

from physcore.forces.central import CentralForce
from physcore.forces.coulomb import Coulomb
from physcore.forces.custom import CustomForce
from physcore.forces.dihedral import Dihedral
from physcore.forces.drag import Drag
from physcore.forces.electromagnetic_field import ElectromagneticField
from physcore.forces.fields import (
    READY_FIELDS,
    CurrentLoop,
    MagneticBottle,
    MagneticDipole,
    PaulTrap,
    QuadrupoleTrap,
    ReadyField,
    TravellingWave,
    UniformField,
)
from physcore.forces.gravitation import Gravitation
from physcore.forces.gravity import Gravity
from physcore.forces.lennard_jones import LennardJones
from physcore.forces.soft_spheres import SoftSpheres
from physcore.forces.wind import Wind
from physcore.scene.items import Force

FORCES: tuple[type[Force], ...] = (
    Gravity,
    Drag,
    CentralForce,
    CustomForce,
    SoftSpheres,
    LennardJones,
    Gravitation,
    Coulomb,
    ElectromagneticField,
    Dihedral,
    Wind,
)
"""All force classes. Those registered here can be saved and are tested."""

__all__ = [
    "FORCES",
    "READY_FIELDS",
    "CentralForce",
    "Coulomb",
    "CurrentLoop",
    "CustomForce",
    "Dihedral",
    "Drag",
    "ElectromagneticField",
    "Force",
    "Gravitation",
    "Gravity",
    "LennardJones",
    "MagneticBottle",
    "MagneticDipole",
    "PaulTrap",
    "QuadrupoleTrap",
    "ReadyField",
    "SoftSpheres",
    "TravellingWave",
    "UniformField",
    "Wind",
]
