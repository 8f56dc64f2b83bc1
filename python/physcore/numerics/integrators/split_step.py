"""Split steps of a wave function."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from physcore.checks import count
from physcore.errors import SceneError
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class SplitStep(Integrator):
    """Split steps of wave functions, order 2 or 4, unitary: the default for them.

        line = pc.Grid((256,), spacing=0.1)
        psi = pc.Schrodinger(line, pc.wave_packet(line, center=12.0, momentum=2.0, width=1.5))
        recording = pc.simulate(pc.Scene(psi), duration=1.0, integrator=pc.SplitStep())

        ψ ← exp(−iV dt/2ħ) exp(−iT dt/ħ) exp(−iV dt/2ħ) ψ

    T acts on the modes of the grid: plane waves, sines or cosines, as the edges are. Free motion is exact; with a
    potential, modes resonate with it where dt reaches 2πħ/E_max for the largest kinetic energy E_max of the grid: the
    norm then stays perfect, and ⟨H⟩ is off by up to 80 %. That is the limit of dt, and "auto" stays below it.

    Args:
        order: 2, or 4 with six transforms a step instead of one, and errors some 1000 times smaller where dt is small.

    Source: G. Strang, SIAM J. Numer. Anal. 5, 506 (1968); S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142, 313
    (2002); J. A. C. Weideman, B. M. Herbst, SIAM J. Numer. Anal. 23, 485 (1986) for the resonance.

    Raises:
        SceneError: the order is another.
    """

    solves: ClassVar[tuple[Equation, ...]] = ("schrodinger",)
    symplectic: ClassVar[bool] = True

    order: Literal[2, 4] = 2  # type: ignore[misc]
    """Its order."""

    def __post_init__(self) -> None:
        if count(self.order, "SplitStep.order") not in (2, 4):
            raise SceneError(f"SplitStep.order: must be 2 or 4, got {self.order}")
