"""Integrators, one module each."""

from __future__ import annotations

from physcore.numerics.integrators.backward_euler import BackwardEuler
from physcore.numerics.integrators.base import Integrator
from physcore.numerics.integrators.bdf2 import BDF2
from physcore.numerics.integrators.blanes_moan_4 import BlanesMoan4
from physcore.numerics.integrators.blanes_moan_6 import BlanesMoan6
from physcore.numerics.integrators.bogacki_shampine_3 import BogackiShampine3
from physcore.numerics.integrators.boris import Boris
from physcore.numerics.integrators.crank_nicolson import CrankNicolson
from physcore.numerics.integrators.dormand_prince_5 import DormandPrince5
from physcore.numerics.integrators.explicit_euler import ExplicitEuler
from physcore.numerics.integrators.gauss_radau_15 import GaussRadau15
from physcore.numerics.integrators.implicit_midpoint import ImplicitMidpoint
from physcore.numerics.integrators.mclachlan_2 import McLachlan2
from physcore.numerics.integrators.pefrl import PEFRL
from physcore.numerics.integrators.projective_dynamics import ProjectiveDynamics
from physcore.numerics.integrators.rattle import RATTLE
from physcore.numerics.integrators.runge_kutta_4 import RungeKutta4
from physcore.numerics.integrators.runge_kutta_chebyshev import RungeKuttaChebyshev
from physcore.numerics.integrators.semi_implicit_euler import SemiImplicitEuler
from physcore.numerics.integrators.split_step import SplitStep
from physcore.numerics.integrators.staggered import Staggered
from physcore.numerics.integrators.velocity_verlet import VelocityVerlet
from physcore.numerics.integrators.xpbd import XPBD

INTEGRATORS: tuple[type[Integrator], ...] = (
    ExplicitEuler,
    SemiImplicitEuler,
    VelocityVerlet,
    McLachlan2,
    RungeKutta4,
    PEFRL,
    BlanesMoan4,
    BlanesMoan6,
    BogackiShampine3,
    DormandPrince5,
    RungeKuttaChebyshev,
    SplitStep,
    CrankNicolson,
    Staggered,
    Boris,
    GaussRadau15,
    RATTLE,
    XPBD,
    ProjectiveDynamics,
    BackwardEuler,
    ImplicitMidpoint,
    BDF2,
)
"""All integrators. Those registered here can be saved, and their order is tested."""

INTEGRATORS_BY_NAME = {kind.__name__: kind for kind in INTEGRATORS}
"""All integrators by name."""


def made(value: object) -> object:
    """The integrator with this name and its default parameters; any other value unchanged."""
    kind = INTEGRATORS_BY_NAME.get(value) if isinstance(value, str) else None
    return value if kind is None else kind()


__all__ = [
    "BDF2",
    "INTEGRATORS",
    "PEFRL",
    "RATTLE",
    "XPBD",
    "BackwardEuler",
    "BlanesMoan4",
    "BlanesMoan6",
    "BogackiShampine3",
    "Boris",
    "CrankNicolson",
    "DormandPrince5",
    "ExplicitEuler",
    "GaussRadau15",
    "ImplicitMidpoint",
    "Integrator",
    "McLachlan2",
    "ProjectiveDynamics",
    "RungeKutta4",
    "RungeKuttaChebyshev",
    "SemiImplicitEuler",
    "SplitStep",
    "Staggered",
    "VelocityVerlet",
]
