"""Gravitation between all particles."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from physcore.checks import number
from physcore.forces.tree import DistantForce, force_error, opening_angle
from physcore.scene.targets import On
from physcore.units.constants import gravitational_constant
from physcore.units.systems import Default


@dataclass(frozen=True)
class Gravitation(DistantForce):
    """Newton's gravitation between all particles.

        sun_and_earth = pc.Particles([[0, 0], [pc.units.AU, 0]], [[0, 0], [0, 29.8e3]],
                                     mass=[pc.units.solar_mass, pc.units.earth_mass])
        scene = pc.Scene(sun_and_earth, pc.Gravitation())

    The force on particle i is F_i = −G m_i Σ_j m_j d/s³ with d = x_i − x_j and s² = |d|² + softening². The potential
    energy of a pair is −G m_i m_j/s. In 2D the law is the same, for orbits in a plane. The sum is exact, over all
    pairs, and its cost grows like the square of the number of particles. Fixed particles attract others. The energy is
    by_term["gravitation"].

    An `opening_angle` θ above zero selects the sum by a tree (Barnes and Hut 1986), whose cost grows like N log N. A
    cell is evaluated as a whole, by its multipole expansion up to quadrupoles, if s < θ d. Here d is the distance of
    its center, and s is the side of the cube around the center that contains its particles. For a cell with n times the
    mass of 32 average particles, θ is replaced by θ n^(−1/15), which balances the errors of cells (Dehnen 2002). The
    error grows approximately like θ^3.5. `plan.force_error` is the error at the start of the scene. Momentum is
    conserved up to this error. The cells change from step to step, so that the energy fluctuates by this error too.

    A mass in `sources` but not in `on` attracts others without feeling a force, as if it were held on its path. The
    work needed for this counts as external work.

    Without softening, close encounters need small time steps. With dt="auto" the step is a hundredth of the shortest
    orbital period at the start. AdaptiveStep adapts it to the present period.

    Args:
        constant: G [m³/(kg·s²)], at least zero; by default the value of CODATA, in the units of the scene.
        softening: softening length ε [m], at least zero (Plummer 1911).
        opening_angle: θ, from 0 to 2. 0.0 is the exact sum. "auto" is an angle up to 2 whose error is at most
            `force_error` and near it, or the exact sum if this needs fewer terms.
        force_error: the requested rms error of the accelerations relative to their rms, for "auto"; from above zero
            to 0.02.
        on: the body or bodies that feel the force; all by default.
        sources: the body or bodies that attract others; all by default.

    Raises:
        SceneError: a value is out of range or not finite. Simulation raises it if the scene has a Periodic domain. A
            run
            raises it if two particles coincide and there is no softening.

    Source: G from CODATA 2018; H. C. Plummer, Mon. Not. R. Astron. Soc. 71, 460 (1911); J. Barnes and P. Hut, Nature
    324,
        446 (1986); W. Dehnen, J. Comput. Phys. 179, 27 (2002).
    """

    constant: float = Default(gravitational_constant, "m³/(kg·s²)")
    softening: float = 0.0
    opening_angle: float | Literal["auto"] = 0.0
    sources: On = field(default=None, kw_only=True)
    force_error: float = field(default=1e-3, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            constant=number(self.constant, "Gravitation.constant", least=0.0),
            softening=number(self.softening, "Gravitation.softening", least=0.0),
            opening_angle=opening_angle(self.opening_angle, "Gravitation.opening_angle"),
            force_error=force_error(self.force_error, "Gravitation.force_error"),
        )
