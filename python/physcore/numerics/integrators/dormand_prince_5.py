"""Dormand–Prince pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class DormandPrince5(Integrator):
    """Dormand–Prince 5(4), order 5, six force evaluations, with an error estimate of each step.

        recording = pc.simulate(scene, 0.5, integrator=pc.DormandPrince5(), dt=pc.AdaptiveStep(tolerance=1e-6))

        kᵢ = f(y + dt Σ aᵢⱼ kⱼ),  i = 1 … 6,   y = (x, v)
        y ← y + (35 k₁/384 + 500 k₃/1113 + 125 k₄/192 − 2187 k₅/6784 + 11 k₆/84) dt,   k₇ = f(y)
        error = (71 k₁/57600 − 71 k₃/16695 + 71 k₄/1920 − 17253 k₅/339200 + 22 k₆/525 − k₇/40) dt

    This is the pair of ode45 and RK45; aᵢⱼ as in the source. k₇ is the k₁ of the next step. The method suits motion
    that friction or drag brings to rest. With AdaptiveStep(tolerance=…) the time step follows the error estimate. An
    error of 1e-6 takes less than a third of the evaluations of BogackiShampine3. Each further digit takes 1.6 times as
    many evaluations, compared with 2.2 times. The order remains 5 with forces that depend on velocity. The method is
    not symplectic: it loses energy slowly and without limit. Stable for ω dt < 0.997 without damping; up to 1.4 an
    oscillation grows by less than 0.002 per step. Stable for λ dt < 3.306 for pure decay. If stability limits the step,
    BogackiShampine3 takes larger steps.

    Source: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6, 19 (1980).
    """

    order: ClassVar[int] = 5
    symplectic: ClassVar[bool] = False
    resolving: ClassVar[float] = 0.3
    embedded: ClassVar[bool] = True
