"""Velocity Verlet, the default."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.integrators.base import Integrator


@dataclass(frozen=True)
class VelocityVerlet(Integrator):
    """Velocity Verlet, order 2, one force evaluation: the default.

        x ← x + v dt + a dt²/2,   v ← v + (a + a_new) dt/2

    Symplectic and reversible: its energy error stays bounded. Stable for ω dt < 2 without damping. A force that depends
    on velocity is evaluated at the predicted velocity v + a dt, which keeps order 2.

    Source: W. C. Swope, H. C. Andersen, P. H. Berens, K. R. Wilson, J. Chem. Phys. 76, 637 (1982).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = True
