"""Velocity Verlet with rods (RATTLE)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from physcore.checks import count
from physcore.errors import SceneError
from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class RATTLE(Integrator):
    """Velocity Verlet with rods, order 2 or 4: the default for networks with rods.

        links = [(k, k + 1) for k in range(9)]
        chain = pc.SpringNetwork([[0.1 * k, 0.0] for k in range(10)], links, stiffness=math.inf, mass=0.01, fixed=[0])
        recording = pc.simulate(pc.Scene(chain, pc.Gravity()), duration=0.5, integrator=pc.RATTLE())

        v½ = v + dt/2 (a − M⁻¹ Jᵀ(x) λ),  x ← x + dt v½ with λ so that each rod keeps its length,
        v ← v½ + dt/2 (a(x) − M⁻¹ Jᵀ(x) μ) with μ so that no velocity is left along a rod

    Any network of rods is supported, alone or with springs and other forces: chains, loops, trusses. The equations of
    all rods are solved together, to rounding. With redundant rods, the tensions are those with the least sum of
    squares; `recording[network].tensions` has them. The method is symplectic and reversible, so that the energy error
    is bounded. Initial velocities along rods are removed.

    A rod must rotate by less than a radian per step, and chains under tension have fast transverse oscillations.
    dt="auto" and AdaptiveStep() respect both limits. Without rods and wires it is VelocityVerlet. Fluids are not
    supported.

    Order 2 also supports boundaries without friction. The impulses of contacts and rods are solved together, so that
    lengths are kept and no particle is outside. Contacts have Newton's restitution; their energy loss is dissipated by
    "contacts". The order is then 1, because contacts within a step are resolved together.

    Args:
        order: 2, or 4 by a composition of five such steps, if no force depends on velocity.

    Source: H. C. Andersen, J. Comput. Phys. 52, 24 (1983); E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical
    Integration", 2nd ed., 2006, section VII.1.4; M. Suzuki, Phys. Lett. A 146, 319 (1990) for order 4.

    Raises:
        SceneError: the order is neither 2 nor 4.
    """

    symplectic: ClassVar[bool] = True
    holds_rods: ClassVar[bool] = True

    order: Literal[2, 4] = 2  # type: ignore[misc]
    """Order of the method."""

    def __post_init__(self) -> None:
        if count(self.order, "RATTLE.order") not in (2, 4):
            raise SceneError(f"RATTLE.order: must be 2 or 4, got {self.order}")
