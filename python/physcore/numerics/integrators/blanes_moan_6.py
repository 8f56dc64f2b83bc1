"""Blanes and Moan's method of order 6."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class BlanesMoan6(Integrator):
    """Blanes and Moan's SRKN₁₁ᵇ, order 6, symplectic, eleven force evaluations: for positions, and the smallest errors.

        recording = pc.simulate(scene, duration=0.5, integrator=pc.BlanesMoan6())

        v ← v + b₁ a(x) dt;  x ← x + a₁ v dt;  v ← v + b₂ a(x) dt;  …;  x ← x + a₁₁ v dt;  v ← v + b₁₂ a(x) dt
        a₁ =  0.123229775946271,  a₂ =  0.290553797799558,   b₁ =  0.0414649985182624,  b₂ =  0.198128671918067
        a₃ = −0.127049212625417,  a₄ = −0.246331761062075,   b₃ = −0.0400061921041533,  b₄ =  0.0752539843015807
        a₅ =  0.357208872795928,  a₆ = 1 − 2(a₁ + … + a₅),   b₅ = −0.0115113874206879,  b₆ = ½ − (b₁ + … + b₅)
        and backwards from there: a₇ = a₅ …, b₇ = b₆ …

    The last force of a step is the first one of the next. On orbits and vibrating networks, an accuracy of 1e-3 takes
    half the evaluations of PEFRL. An accuracy of 1e-9 takes a fourth to a ninth, and requires double precision. Forces
    that depend on velocity reduce the order to 2, because every splitting above order 2 has negative substeps. Stable
    for ω dt < 3.141 without damping.

    Source: S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142, 313 (2002), table 3.
    """

    order: ClassVar[int] = 6
    symplectic: ClassVar[bool] = True
    resolving: ClassVar[float] = 0.9
