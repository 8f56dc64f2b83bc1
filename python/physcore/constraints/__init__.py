"""Constraints between bodies, one module each."""

from __future__ import annotations

from physcore.constraints.self_contact import SelfContact
from physcore.constraints.wire import Wire
from physcore.scene.items import Constraint

CONSTRAINTS: tuple[type[Constraint], ...] = (SelfContact, Wire)
"""All constraint classes. Those registered here can be saved and are tested."""

__all__ = ["CONSTRAINTS", "Constraint", "SelfContact", "Wire"]
