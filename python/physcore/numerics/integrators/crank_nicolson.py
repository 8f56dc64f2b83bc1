"""Crank–Nicolson method for wave functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class CrankNicolson(Integrator):
    """Crank–Nicolson method for wave functions, order 2, implicit and unitary.

        line = pc.Grid((256,), spacing=0.1)
        psi = pc.Schrodinger(line, pc.wave_packet(line, center=12.0, momentum=2.0, width=1.5))
        recording = pc.simulate(pc.Scene(psi), duration=1.0, integrator=pc.CrankNicolson())

        (1 + iH dt/2ħ) ψ_new = (1 − iH dt/2ħ) ψ

    The Laplacian is the three-point formula, of order 2 in the spacing. In 1D, ⟨H⟩ is conserved to rounding at any dt.
    In 2D and 3D a step is a product of such steps along the axes, which conserves ⟨H⟩ to the order dt².

    Source: J. Crank, P. Nicolson, Proc. Camb. Phil. Soc. 43, 50 (1947); A. Goldberg, H. M. Schey, J. L. Schwartz, Am.
    J. Phys. 35, 177 (1967).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = True
