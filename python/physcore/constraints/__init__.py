"""Constraints between bodies, one file each."""

from __future__ import annotations

from physcore.constraints.self_contact import SelfContact
from physcore.scene.items import Constraint

CONSTRAINTS: tuple[type[Constraint], ...] = (SelfContact,)
"""Every constraint; what is registered here can be saved, and is tested."""

__all__ = ["CONSTRAINTS", "Constraint", "SelfContact"]
