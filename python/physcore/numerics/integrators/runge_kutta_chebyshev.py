"""The stabilized Runge–Kutta–Chebyshev method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class RungeKuttaChebyshev(Integrator):
    """The stabilized Runge–Kutta–Chebyshev method, order 2, for diffusion: s evaluations reach 0.65 s² as far as one.

        grid = pc.Grid((64, 64), spacing=0.01)
        dish = pc.ReactionDiffusion(grid, pc.GrayScott(0.035, 0.0625), {"u": 2e-5, "v": 1e-5}, {"u": 1.0, "v": 0.0})
        recording = pc.simulate(pc.Scene(dish), duration=10.0, integrator=pc.RungeKuttaChebyshev())

        Y₁ = y + μ̃₁ dt f(y),   Yⱼ = (1 − μⱼ − νⱼ) y + μⱼ Yⱼ₋₁ + νⱼ Yⱼ₋₂ + μ̃ⱼ dt f(Yⱼ₋₁) + γ̃ⱼ dt f(y),   y ← Yₛ

    The coefficients come from Chebyshev polynomials. Stable for λ dt < 0.65 s² on pure decay at the rate λ: where
    diffusion limits the step and accuracy does not, a long step costs its square root. The number s of stages is the
    smallest that the step and the largest rate of diffusion ask for, at least 2 and at most 128, with a rest of the
    interval for the reaction, whose rates must stay below 2/dt. It pays for steps of more than about five times the
    limit of ExplicitEuler, h²/(2 D) in 1D, h²/(4 D) in 2D and h²/(6 D) in 3D; `plan.notes` says what steps those are.
    With AdaptiveStep(tolerance=…) the step follows an estimate of its error, ⅘ (yₙ − yₙ₊₁) + ⅖ dt (f(yₙ) + f(yₙ₊₁)).

    Source: B. P. Sommeijer, L. F. Shampine, J. G. Verwer, J. Comput. Appl. Math. 88, 315 (1998).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = False
    embedded: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("first order",)
