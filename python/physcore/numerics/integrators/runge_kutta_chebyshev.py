"""Stabilized Runge–Kutta–Chebyshev method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class RungeKuttaChebyshev(Integrator):
    """Stabilized Runge–Kutta–Chebyshev method, order 2, for diffusion: s evaluations allow 0.65 s² times the step of
    one.

        grid = pc.Grid((64, 64), spacing=0.01)
        dish = pc.ReactionDiffusion(grid, pc.GrayScott(0.035, 0.0625), {"u": 2e-5, "v": 1e-5}, {"u": 1.0, "v": 0.0})
        recording = pc.simulate(pc.Scene(dish), duration=10.0, integrator=pc.RungeKuttaChebyshev())

        Y₁ = y + μ̃₁ dt f(y),   Yⱼ = (1 − μⱼ − νⱼ) y + μⱼ Yⱼ₋₁ + νⱼ Yⱼ₋₂ + μ̃ⱼ dt f(Yⱼ₋₁) + γ̃ⱼ dt f(y),   y ← Yₛ

    The coefficients come from Chebyshev polynomials. The method is stable for λ dt < 0.65 s² for pure decay at the rate
    λ. If diffusion limits the step, the cost of a step thus grows like the square root of its length. The number s of
    stages is the smallest that the step and the largest rate of diffusion require, from 2 to 128. A part of the
    interval is reserved for the reaction, whose rates must be below 2/dt. The method is worthwhile for steps longer
    than about five times the limit of ExplicitEuler. This limit is h²/(2 D) in 1D, h²/(4 D) in 2D and h²/(6 D) in 3D;
    `plan.notes` gives the steps. With AdaptiveStep(tolerance=…) the step follows the error estimate ⅘ (yₙ − yₙ₊₁) + ⅖
    dt (f(yₙ) + f(yₙ₊₁)).

    Source: B. P. Sommeijer, L. F. Shampine, J. G. Verwer, J. Comput. Appl. Math. 88, 315 (1998).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = False
    embedded: ClassVar[bool] = True
