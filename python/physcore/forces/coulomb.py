"""Electrostatic force between charges."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

from physcore.checks import number
from physcore.forces.tree import DistantForce, force_error, opening_angle
from physcore.scene.targets import On
from physcore.units.constants import coulomb_constant
from physcore.units.systems import Default


@dataclass(frozen=True)
class Coulomb(DistantForce):
    """Coulomb's force between all charges: like charges repel, unlike charges attract each other.

        e, nm = pc.units.elementary_charge, 1e-9
        ions = pc.Particles([[0, 0], [nm, 0]], mass=23 * pc.units.atomic_mass, charge=[e, -e])
        scene = pc.Scene(ions, pc.Coulomb())

    The force on particle i is F_i = k q_i Σ_j q_j d/s³ with d = x_i − x_j and s² = |d|² + softening². The potential
    energy of a pair is k q_i q_j/s. In 2D the law is the same, for charges in a plane. The sum is exact, over all
    pairs, and its cost grows like the square of the number of particles. The energy is by_term["coulomb"].

    An `opening_angle` θ above zero selects the sum by a tree (Barnes and Hut 1986), whose cost grows like N log N. A
    cell is evaluated as a whole, by its multipole expansion up to quadrupoles, if s < θ d. Here d is the distance of
    its center, and s is the side of the cube around the center that contains its particles. For a cell with n times the
    charge of 32 average particles, θ is replaced by θ n^(−1/15), which balances the errors of cells (Dehnen 2002). The
    error grows approximately like θ^3.5. `plan.force_error` is the error at the start of the scene. Momentum is
    conserved up to this error. The cells change from step to step, so that the energy fluctuates by this error too.

    A charge in `sources` but not in `on` exerts the force without feeling it, as if it were held on its path. The work
    needed for this counts as external work.

    With dt="auto" the time step is a hundredth of the shortest orbital period at the start. AdaptiveStep adapts it to
    the present period.

    Args:
        constant: k = 1/(4π ε₀) [N·m²/C²], at least zero; by default the value of CODATA, in the units of the scene.
        softening: softening length [m], at least zero.
        opening_angle: θ, from 0 to 2. 0.0 is the exact sum. "auto" is an angle up to 2 whose error is at most
            `force_error` and near it, or the exact sum if this needs fewer terms.
        force_error: the requested rms error of the accelerations relative to their rms, for "auto"; from above zero
            to 0.02.
        on: the body or bodies that feel the force; all by default.
        sources: the body or bodies whose charges exert the force; all by default.

    Raises:
        SceneError: a value is out of range or not finite. Simulation raises it if the scene has a Periodic domain. A
            run
            raises it if two particles coincide and there is no softening.

    Source: k from CODATA 2018; softening and tree as in Gravitation.
    """

    feels_charges: ClassVar[bool] = True
    needs_charges: ClassVar[bool] = True

    constant: float = Default(coulomb_constant, "N·m²/C²")
    softening: float = 0.0
    opening_angle: float | Literal["auto"] = 0.0
    sources: On = field(default=None, kw_only=True)
    force_error: float = field(default=1e-3, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            constant=number(self.constant, "Coulomb.constant", least=0.0),
            softening=number(self.softening, "Coulomb.softening", least=0.0),
            opening_angle=opening_angle(self.opening_angle, "Coulomb.opening_angle"),
            force_error=force_error(self.force_error, "Coulomb.force_error"),
        )
