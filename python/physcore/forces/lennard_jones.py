"""The force between simple atoms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number, span
from physcore.scene.items import Force

CUTOFF = 2.5
"""The cutoff by default, in units of sigma."""


@dataclass(frozen=True)
class LennardJones(Force):
    """Atoms that attract each other from afar and repel each other near by, with a shifted force.

        atoms = pc.Particles(pc.block((0.0, 0.0), (6.0, 6.0), 1.12))
        scene = pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0))

    With u(r) = 4ε [(σ/r)¹² − (σ/r)⁶] and f(r) = −u'(r), two atoms at a distance r < r_c repel each other with

        F(r) = f(r) − f(r_c),     U(r) = u(r) − u(r_c) + (r − r_c) f(r_c),

    so that both force and energy go to zero at the cutoff r_c, and the energy is conserved. Masses and radii play no
    part in it.

    Args:
        epsilon: ε, the depth of the uncut well [J], above zero.
        sigma: σ, the distance at which the uncut potential is zero [m], above zero.
        cutoff: r_c [m], above zero; None: 2.5 σ. The cutoff 2^(1/6) σ leaves the repulsion alone.
        on: the body or bodies that it acts on, among themselves and between them; all but fluids by default.

    Raises:
        SceneError: a value is not above zero, or not finite.

    Source: M. P. Allen, D. J. Tildesley, "Computer Simulation of Liquids", 1987, chapters 1 and 5; S. Toxvaerd,
    J. C. Dyre, "Communication: Shifted forces in molecular dynamics", J. Chem. Phys. 134, 081102 (2011).
    """

    epsilon: float
    sigma: float
    cutoff: float | None = None

    spares_fluids: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        sigma = span(self.sigma, "LennardJones.sigma")
        cutoff = CUTOFF * sigma if self.cutoff is None else self.cutoff
        self._set(
            epsilon=number(self.epsilon, "LennardJones.epsilon", above=0.0),
            sigma=sigma,
            cutoff=span(cutoff, "LennardJones.cutoff"),
        )
