"""Visscher's staggered method for wave functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class Staggered(Integrator):
    """Staggered steps for wave functions, order 2, explicit: the real part R and the imaginary part I in turn.

        line = pc.Grid((256,), spacing=0.1)
        psi = pc.Schrodinger(line, pc.wave_packet(line, center=12.0, momentum=2.0, width=1.5))
        recording = pc.simulate(pc.Scene(psi), duration=1.0, integrator=pc.Staggered())

        I ← I − HR dt/2ħ,   R ← R + HI dt/ħ,   I ← I − HR dt/2ħ

    The Laplacian is the three-point formula. Stable for E dt < 2ħ with the largest eigenvalue E of H. The norm
    oscillates with an amplitude of order dt² and does not drift.

    Source: P. B. Visscher, Computers in Physics 5, 596 (1991).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = True
