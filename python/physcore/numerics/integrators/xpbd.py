"""Extended position-based dynamics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import MOST, count
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class XPBD(Integrator):
    """Extended position-based dynamics, order 1: sweeps over the springs, each of which satisfies one at a time.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.XPBD(substeps=20))

    Each step consists of `substeps` equal parts. A part predicts positions by velocities and by all forces but those of
    springs, then moves the ends of each spring in turn by the multiplier Δλ = (−C − α̃ λ)/(w + α̃) with C = l − l₀ and
    the compliance α̃ = 1/(k h²), and takes velocities from the displacements. A single spring is solved exactly, as by
    BackwardEuler(), and one of stiffness=math.inf by Δλ = −C/w, with α̃ = 0: a rod, whose length each sweep approaches.
    Stable at any stiffness, fast, and soft: what a sweep does not reach makes stiff cloth stretch, the
    less the more parts a step has. Parts work better than iterations at equal cost.

    It damps, and is not symplectic: both are errors of the method, and show as drift of the energy balance. For springs
    and fields such as Gravity and Drag, with boundaries; other forces are refused.

    Args:
        substeps: parts of a step, at least 1.
        iterations: sweeps in each of them, at least 1.

    Source: M. Macklin, M. Müller, N. Chentanez, Motion in Games 49 (2016); M. Macklin et al., Symp. Computer Animation
    (2019).

    Raises:
        SceneError: a number is below 1.
    """

    order: ClassVar[int] = 1
    symplectic: ClassVar[bool] = False
    stiff: ClassVar[bool] = True
    holds_rods: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("bodies",)

    substeps: int = 10
    iterations: int = 1

    def __post_init__(self) -> None:
        for name in ("substeps", "iterations"):
            object.__setattr__(self, name, count(getattr(self, name), f"XPBD.{name}", least=1, most=MOST))
