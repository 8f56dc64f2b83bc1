"""Constraints between bodies, one module each."""

from __future__ import annotations

from physcore.constraints.anchor import Anchor
from physcore.constraints.joints import BallJoint, Hinge, Prismatic, Weld
from physcore.constraints.links import Rod, SpringJoint
from physcore.constraints.motor import Motor
from physcore.constraints.self_contact import SelfContact
from physcore.constraints.wire import Wire
from physcore.scene.items import Constraint

CONSTRAINTS: tuple[type[Constraint], ...] = (
    SelfContact,
    Wire,
    Hinge,
    BallJoint,
    Weld,
    Prismatic,
    Rod,
    SpringJoint,
    Motor,
    Anchor,
)
"""All constraint classes. Those registered here can be saved and are tested."""

__all__ = [
    "CONSTRAINTS",
    "Anchor",
    "BallJoint",
    "Constraint",
    "Hinge",
    "Motor",
    "Prismatic",
    "Rod",
    "SelfContact",
    "SpringJoint",
    "Weld",
    "Wire",
]
