"""Velocity Verlet with rods."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from physcore.checks import count
from physcore.errors import SceneError
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class RATTLE(Integrator):
    """Velocity Verlet with rods, order 2 or 4: the default where springs are rods.

        links = [(k, k + 1) for k in range(9)]
        chain = pc.SpringNetwork([[0.1 * k, 0.0] for k in range(10)], links, stiffness=math.inf, mass=0.01, fixed=[0])
        recording = pc.simulate(pc.Scene(chain, pc.Gravity()), duration=0.5, integrator=pc.RATTLE())

        chain = pc.SpringNetwork(positions, pairs, stiffness=math.inf, fixed=[0])
        pc.simulate(pc.Scene(chain, pc.Gravity((0.0, -9.81))), 10.0)

        v½ = v + dt/2 (a − M⁻¹ Jᵀ(x) λ),  x ← x + dt v½ with λ so that each rod keeps its length,
        v ← v½ + dt/2 (a(x) − M⁻¹ Jᵀ(x) μ) with μ so that no velocity is left along a rod

    Any network of rods, alone or with springs and other forces: chains, loops, trusses. The equations of all rods are
    solved together, to rounding. Where rods are redundant, those tensions are taken whose sum of squares is least;
    `recording[network].tensions` has them. Symplectic and reversible, so that the energy error stays bounded. At the
    start velocities along rods are taken away.

    A rod must turn by less than a radian in a step, and chains under tension swing fast across; dt="auto" follows
    both, as AdaptiveStep(). Without rods it is VelocityVerlet. Not for fluids.

    With order 2, also for boundaries without friction: impulses of contacts are found together with those of the rods,
    so that lengths hold and nobody is outside; a particle leaves with Newton's restitution, and what that takes is
    dissipated by "contacts". Of order 1 then, as contacts within a step are resolved together.

    Args:
        order: 2, or 4 by a composition of five such steps, where no force depends on velocity.

    Source: H. C. Andersen, J. Comput. Phys. 52, 24 (1983); E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical
    Integration", 2nd ed., 2006, section VII.1.4; M. Suzuki, Phys. Lett. A 146, 319 (1990) for order 4.

    Raises:
        SceneError: the order is another.
    """

    symplectic: ClassVar[bool] = True
    holds_rods: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("bodies",)

    order: Literal[2, 4] = 2  # type: ignore[misc]
    """Its order."""

    def __post_init__(self) -> None:
        if count(self.order, "RATTLE.order") not in (2, 4):
            raise SceneError(f"RATTLE.order: must be 2 or 4, got {self.order}")
