"""Lennard-Jones force between simple atoms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number, span
from physcore.scene.items import Force

CUTOFF = 2.5
"""Default cutoff, in units of sigma."""


@dataclass(frozen=True)
class LennardJones(Force):
    """Lennard-Jones force with a cutoff, as a shifted force. Atoms attract at long range and repel at short range.

        atoms = pc.Particles(pc.block((0.0, 0.0), (6.0, 6.0), 1.12))
        scene = pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0))

    With u(r) = 4ε [(σ/r)¹² − (σ/r)⁶] and f(r) = −u'(r), the repulsive force and the potential energy of two atoms at a
    distance r < r_c are

        F(r) = f(r) − f(r_c),     U(r) = u(r) − u(r_c) + (r − r_c) f(r_c).

    Both vanish at the cutoff r_c, so that the energy is conserved. Masses and radii have no effect on the force.

    Args:
        epsilon: ε, the depth of the uncut well [J], above zero.
        sigma: σ, the distance at which the uncut potential is zero [m], above zero.
        cutoff: r_c [m], above zero; None: 2.5 σ. With the cutoff 2^(1/6) σ the force is purely repulsive.
        on: the body or bodies that the force acts on, within and between them; all except fluids by default.

    Raises:
        SceneError: a value is not above zero, or not finite.

    Source: M. P. Allen, D. J. Tildesley, "Computer Simulation of Liquids", 1987, chapters 1 and 5; S. Toxvaerd, J. C.
    Dyre, "Communication: Shifted forces in molecular dynamics", J. Chem. Phys. 134, 081102 (2011).
    """

    epsilon: float
    sigma: float
    cutoff: float | None = None

    spares_fluids: ClassVar[bool] = True
    spares_rigid_bodies: ClassVar[bool] = True
    is_shown: ClassVar[bool] = False
    has_kink: ClassVar[bool] = True
    binds: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        sigma = span(self.sigma, "LennardJones.sigma")
        cutoff = CUTOFF * sigma if self.cutoff is None else self.cutoff
        self._set(
            epsilon=number(self.epsilon, "LennardJones.epsilon", above=0.0),
            sigma=sigma,
            cutoff=span(cutoff, "LennardJones.cutoff"),
        )
