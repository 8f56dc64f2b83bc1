"""Implicit midpoint rule."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.implicit import Implicit


@dataclass(frozen=True)
class ImplicitMidpoint(Implicit):
    """Implicit midpoint rule, order 2, symplectic: for stiff systems without damping.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.ImplicitMidpoint(), dt=2e-3)

        x' − x = dt (v + v')/2,  v' − v = dt F((x + x')/2, (v + v')/2)/m

    The method has no numerical damping. Unresolved oscillations continue with a wrong period, and advance by half a
    period per step as ω dt grows. The method is reversible, and conserves momentum and angular momentum. On linear
    forces it is stable at any step. On nonlinear ones, such as springs that turn, steps with ω dt far above 1 may gain
    energy: a damped stiff net at ω dt = 20 does. BackwardEuler and BDF2 do not.

    Steps are solved as those of BackwardEuler are, and the same forces are supported.

    Args:
        tolerance: largest residual force relative to the largest force in the step, above 0.

    Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed., 1993, section
    II.7; D. Baraff, A. Witkin, SIGGRAPH 1998, 43.

    Raises:
        SceneError: `tolerance` is not above 0.
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = True
