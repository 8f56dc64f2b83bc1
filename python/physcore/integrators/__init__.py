"""Integrators, one file each."""

from __future__ import annotations

from physcore.integrators.base import Integrator
from physcore.integrators.explicit_euler import ExplicitEuler
from physcore.integrators.pefrl import PEFRL
from physcore.integrators.runge_kutta_4 import RungeKutta4
from physcore.integrators.semi_implicit_euler import SemiImplicitEuler
from physcore.integrators.velocity_verlet import VelocityVerlet

INTEGRATORS: tuple[type[Integrator], ...] = (
    ExplicitEuler,
    SemiImplicitEuler,
    VelocityVerlet,
    RungeKutta4,
    PEFRL,
)
"""Every integrator; what is registered here can be saved, and is tested for its order."""

__all__ = [
    "INTEGRATORS",
    "PEFRL",
    "ExplicitEuler",
    "Integrator",
    "RungeKutta4",
    "SemiImplicitEuler",
    "VelocityVerlet",
]
