"""Backward differentiation formula of order 2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.implicit import Implicit


@dataclass(frozen=True)
class BDF2(Implicit):
    """Backward differentiation formula of order 2, implicit: for stiff systems, with less damping than BackwardEuler.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.BDF2(), dt=1 / 60)

        3x'/2 − 2x + x₋/2 = dt v',  3v'/2 − 2v + v₋/2 = dt F(x', v')/m

    The formula uses the last two states. The first step, and each step after a change of step size or a contact, is one
    of backward Euler. Unresolved oscillations vanish at once, and slow ones lose little energy. This numerical damping
    is an error of the method, not dissipation. It appears as a drift of the energy balance.

    Steps are solved as those of BackwardEuler are, and the same forces are supported.

    Args:
        tolerance: largest residual force relative to the largest force in the step, above 0.

    Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed., 1993, section
    III.1; D. Baraff, A. Witkin, SIGGRAPH 1998, 43.

    Raises:
        SceneError: `tolerance` is not above 0.
    """

    order: ClassVar[int] = 2
