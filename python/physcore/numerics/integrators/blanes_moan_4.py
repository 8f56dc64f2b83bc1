"""Blanes and Moan's method of order 4."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class BlanesMoan4(Integrator):
    """Blanes and Moan's SRKN₆ᵇ, order 4, symplectic, six force evaluations: for energy errors of 1e-4 to 1e-6.

        recording = pc.simulate(scene, duration=0.5, integrator=pc.BlanesMoan4())

        v ← v + b₁ a(x) dt;  x ← x + a₁ v dt;  v ← v + b₂ a(x) dt;  …;  x ← x + a₆ v dt;  v ← v + b₇ a(x) dt
        a₁ = 0.245298957184271,   a₂ = 0.604872665711080,  a₃ = ½ − a₁ − a₂
        b₁ = 0.0829844064174052,  b₂ = 0.396309801498368,  b₃ = −0.0390563049223486,  b₄ = 1 − 2(b₁ + b₂ + b₃)
        and backwards from there: a₄ = a₃ …, b₅ = b₃ …

    The last force of a step is the first one of the next. For the same energy error the method needs half as many
    evaluations as PEFRL. For the same error of positions it needs half as many on orbits, and as many in spring
    networks, where BlanesMoan6 needs fewer. Forces that depend on velocity reduce the order to 2, because every
    splitting above order 2 has negative substeps. Stable for ω dt < 3.163 without damping.

    Source: S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142, 313 (2002), table 3.
    """

    order: ClassVar[int] = 4
    symplectic: ClassVar[bool] = True
    resolving: ClassVar[float] = 0.42
