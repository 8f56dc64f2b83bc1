"""Split-step method for wave functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from physcore.checks import count
from physcore.errors import SceneError
from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class SplitStep(Integrator):
    """Split-step method for wave functions, order 2 or 4, unitary: the default for wave functions.

        line = pc.Grid((256,), spacing=0.1)
        psi = pc.Schrodinger(line, pc.wave_packet(line, center=12.0, momentum=2.0, width=1.5))
        recording = pc.simulate(pc.Scene(psi), duration=1.0, integrator=pc.SplitStep())

        ψ ← exp(−iV dt/2ħ) exp(−iT dt/ħ) exp(−iV dt/2ħ) ψ

    T acts on the modes of the grid: plane waves, sines or cosines, depending on the edges. Free motion is exact. With a
    potential, modes resonate with the steps if dt reaches 2πħ/E_max, with the largest kinetic energy E_max of the grid.
    The norm is then still exact, but ⟨H⟩ has errors up to 80 %. This is the limit of dt, and "auto" is below it.

    Args:
        order: 2, or 4 with six transforms per step instead of one; at small dt its errors are about 1000 times smaller.

    Source: G. Strang, SIAM J. Numer. Anal. 5, 506 (1968); S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142, 313
    (2002); J. A. C. Weideman, B. M. Herbst, SIAM J. Numer. Anal. 23, 485 (1986) for the resonance.

    Raises:
        SceneError: the order is neither 2 nor 4.
    """

    symplectic: ClassVar[bool] = True

    order: Literal[2, 4] = 2  # type: ignore[misc]
    """Order of the method."""

    def __post_init__(self) -> None:
        if count(self.order, "SplitStep.order") not in (2, 4):
            raise SceneError(f"SplitStep.order: must be 2 or 4, got {self.order}")
