"""The electrostatic force between all charges."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

from physcore.checks import number
from physcore.forces.tree import opening_angle
from physcore.scene.items import Force, On
from physcore.units import coulomb_constant


@dataclass(frozen=True)
class Coulomb(Force):
    """Coulomb's force between all charges: like ones repel each other, unlike ones attract each other.

        e, nm = pc.units.elementary_charge, 1e-9
        ions = pc.Particles([[0, 0], [nm, 0]], mass=23 * pc.units.atomic_mass, charge=[e, -e])
        scene = pc.Scene(ions, pc.Coulomb())

    The force on particle i is F_i = k q_i Σ_j q_j d/s³ with d = x_i − x_j and s² = |d|² + softening², and a pair has
    the potential energy k q_i q_j/s. In 2D the law is the same: charges in a plane. The sum is exact, over all pairs,
    and its cost grows like the square of the number of particles. The energy is by_term["coulomb"].

    With an `opening_angle` θ above zero the sum is that of a tree (Barnes and Hut 1986), whose cost grows like N log N:
    a cell whose particles are within a cube of side s about their center, at the distance d, is taken whole where
    s < θ d, by its expansion to quadrupoles. That is θ of small cells; of a cell with n times the charge of 32 average
    particles it is θ n^(−1/15), which balances the errors of cells (Dehnen 2002). The error grows about like θ^3.5;
    plan.force_error is that of the scene as it starts, and momentum is kept to it. The cells change from step to step,
    so that energy wanders by that error too.

    A charge among `sources` that is not among `on` acts and feels nothing, as if it were held on its path: the work
    of that counts as external work.

    dt="auto" is a hundredth of the shortest orbital period of the start, AdaptiveStep follows it.

    Args:
        constant: k = 1/(4π ε₀) [N·m²/C²], at least zero.
        softening: [m], at least zero.
        opening_angle: θ, at least zero; 0.0 is the exact sum, "auto" one up to 2 whose error is at most `force_error`
            and near it, or the exact sum where that needs fewer terms.
        force_error: the wished rms error of the accelerations over their rms, for "auto"; above zero.
        on: the body or bodies that feel it; all by default.
        sources: the body or bodies whose charges act; all by default.

    Raises:
        SceneError: a value is out of range or not finite; when the simulation is made, the scene has a Periodic domain;
            when it runs, two particles coincide and there is no softening.

    Source: k by CODATA 2018; the softening and the tree as those of Gravitation.
    """

    feels_charges: ClassVar[bool] = True

    constant: float = coulomb_constant
    softening: float = 0.0
    opening_angle: float | Literal["auto"] = 0.0
    sources: On = field(default=None, kw_only=True)
    force_error: float = field(default=1e-3, kw_only=True)

    naming: ClassVar[tuple[str, ...]] = ("on", "sources")

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            constant=number(self.constant, "Coulomb.constant", least=0.0),
            softening=number(self.softening, "Coulomb.softening", least=0.0),
            opening_angle=opening_angle(self.opening_angle, "Coulomb.opening_angle"),
            force_error=number(self.force_error, "Coulomb.force_error", above=0.0),
        )
