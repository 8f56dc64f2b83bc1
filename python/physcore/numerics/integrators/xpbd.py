"""Extended position-based dynamics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import count
from physcore.numerics.integrators.base import MOST_ITERATIONS, Integrator


@dataclass(frozen=True)
class XPBD(Integrator):
    """Extended position-based dynamics (XPBD), order 1: sweeps over the springs, which are solved one at a time.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.XPBD(substeps=20))

    Each step consists of `substeps` equal parts. A part first predicts positions from the velocities and all forces
    except those of springs. It then moves the ends of each spring in turn, by the multiplier Δλ = (−C − α̃ λ)/(w + α̃).
    Here C = l − l₀, and α̃ = 1/(k h²) is the compliance. Finally, velocities follow from the displacements. A single
    spring is solved exactly, as by BackwardEuler(). A rod (stiffness=math.inf) has α̃ = 0 and Δλ = −C/w; each sweep
    brings it nearer to its length. The method is fast, and stable at any stiffness. Incomplete convergence makes stiff
    cloth too soft, less so with more parts per step. At equal cost, more parts are better than more iterations.

    The method has numerical damping, and is not symplectic. Both errors appear as a drift of the energy balance.
    Supported are springs, external fields such as Gravity and Drag, and boundaries; other forces are refused.

    Args:
        substeps: number of parts of a step, at least 1.
        iterations: number of sweeps per part, at least 1.

    Source: M. Macklin, M. Müller, N. Chentanez, Motion in Games 49 (2016); M. Macklin et al., Symp. Computer Animation
    (2019).

    Raises:
        SceneError: a number is below 1.
    """

    order: ClassVar[int] = 1
    symplectic: ClassVar[bool] = False
    stiff: ClassVar[bool] = True
    continuous: ClassVar[bool] = False
    holds_rods: ClassVar[bool] = True

    substeps: int = 10
    iterations: int = 1

    def __post_init__(self) -> None:
        for name in ("substeps", "iterations"):
            object.__setattr__(self, name, count(getattr(self, name), f"XPBD.{name}", least=1, most=MOST_ITERATIONS))
