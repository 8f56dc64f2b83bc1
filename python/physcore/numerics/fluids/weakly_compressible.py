"""Weakly compressible fluids: smoothed particle hydrodynamics with an equation of state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from physcore.arithmetic import lengths
from physcore.checks import is_word, number, shown, span, word
from physcore.errors import MachWarning, SceneError, SceneWarning, warn
from physcore.numerics.fluids.base import FluidMethod
from physcore.scene.fluid import Fluid
from physcore.scene.kernels import KERNELS, Kernel, WendlandC2
from physcore.units.systems import UnitSystem

COMPRESSED = 0.01
"""The relative change of density that is meant."""


def _or_auto(check: Callable[[object, str], float], what: str) -> Callable[[object, str], float | Literal["auto"]]:
    """A check that lets "auto" pass."""

    def checked(value: object, path: str) -> float | Literal["auto"]:
        if is_word(value, "auto"):
            return "auto"
        if isinstance(value, str):
            raise SceneError(f"{path}: must be {what} or 'auto', got {shown(value)}")
        return check(value, path)

    return checked


def _coefficient(value: object, path: str) -> float:
    return number(value, path, least=0.0)


def _kernel(value: object, path: str) -> Kernel:
    if isinstance(value, KERNELS):
        return value
    known = ", ".join(f"{kind.__name__}()" for kind in KERNELS)
    missing = f"; write {value.__name__}()" if isinstance(value, type) else ""
    raise SceneError(f"{path}: must be one of {known}, got {shown(value)}{missing}")


def _density_from(value: object, path: str) -> str:
    return word(value, path, ("continuity", "summation"))


CHECKS: dict[str, Callable[[object, str], object]] = {
    "sound_speed": _or_auto(span, "a number of meters per second"),
    "kernel": _kernel,
    "artificial_viscosity": _or_auto(_coefficient, "a number"),
    "density_diffusion": _coefficient,
    "density_from": _density_from,
    "shifting": _or_auto(_coefficient, "a number"),
}
"""The check of each argument, by its name; each takes a value and its path."""


@dataclass(frozen=True)
class WeaklyCompressible(FluidMethod):
    """Smoothed particle hydrodynamics (SPH) of a fluid whose pressure grows with its density.

        method = pc.WeaklyCompressible(sound_speed=40.0, artificial_viscosity=0.05)
        water, tank = pc.Fluid.block((0.0, 0.0), (0.4, 0.6), spacing=0.05), pc.Box((0.0, 0.0), (1.2, 1.0))
        recording = pc.simulate(pc.Scene(water, pc.Gravity(), tank), 0.1, fluids=method)

    p = c² ρ₀/7 ((ρ/ρ₀)⁷ − 1), and c is far above the speed of the flow, so that the density changes by a percent or so.
    The time step goes with 1/c.

    Viscosity: α adds αhc/2(D + 2) to the kinematic viscosity ν of the fluid, αhc/8 in 2D, where h is the smoothing
    length. "auto" adds only what ν lacks of that of α = 0.02, the least with which splashes stay calm: 0 where the
    particles resolve the viscosity that is given, so that it is the one that acts. Where they do not, as for water,
    `Simulation.plan` states the viscosity and the Reynolds number that come of it, which only finer particles raise.
    Viscous forces act along the line between two particles, (2μ/σ²) VᵢVⱼ F (v·d) d, where d is that line, F = W'/r and
    σ² the variance of W along an axis: they go with the symmetric part of the velocity gradient, so that free surfaces
    bear no shear, angular momentum is conserved, and a drop that rotates as a whole goes on. A single fluid that starts
    without a free surface, among no other bodies, has 2μ VᵢVⱼ F v instead, which is the same flow there, in fewer steps
    where the viscosity limits them.

    Walls: fluids slip along boundaries, unless those say no_slip. Take no_slip=True where the boundary layer is some
    particles thick: slow, viscous or small flows. Where it is thinner than a particle, as below waves and dam breaks of
    water, slip is nearer to it; sticking walls would hold back a layer as thick as a particle. The front of a dam break
    is the exception, a layer that is nothing but boundary layer: along slipping walls it is ahead of experiments by
    more than a tenth of its way. Water beneath a ceiling, be it a boundary or an obstacle, is let go from its free
    surface on: single drops at once, a layer of several particles when it breaks, some tenths of a second later.

    Shifting moves particles, in each step and beside their velocity, from where they are crowded to where is room:
    δx = −A h U dt Σ V [1 + (W/W(Δ))⁴/5] ∇W, where U is the difference of velocity over 8h, c/10 at most, and δx at most
    c dt/20; but none at a free surface, and none through a wall. It keeps flows that stretch, and negative pressures,
    from gathering particles in strands with voids between them; vortices without it die far too early. It never bounds
    the time step, but is a third sum beside two. Momentum and the energies of motion and of compression are kept
    exactly, angular momentum only to some 1e-3. What it changes in potential energy counts as work: a wave is lifted a
    little. Fluids that meet are shifted as one, and may mix.

    Args:
        sound_speed: c [m/s], above zero; "auto": ten times the greatest speed to be expected: the initial one, that of
            a fall to the lowest wall or in a CentralForce, 1.75 times that at which a fluid strikes this wall, for its
            jets, or that at which friction at no-slip walls and obstacles holds up what gravity drives along a
            periodic axis; at least √(40 σ/(ρ₀ spacing)), with which tension changes density by a few percent next to a
            surface, and 10 √(νU/L) where a flow U of the size L creeps.
        kernel: WendlandC2(), WendlandC4() or CubicSpline(), how particles are smoothed out.
        artificial_viscosity: the coefficient α, at least zero, or "auto", as above.
        density_diffusion: the coefficient δ, at least zero, which damps noise of the density.
        density_from: "continuity": density is carried along and changes with the flow; "summation": it is counted from
            where the particles are, so that it never drifts and energy is that of the particles' places. That is for
            fluids that fill a closed or periodic space, because at a free surface there is nothing to count; it has no
            noise for δ to damp. Any integrator drives a density that is counted; one that is carried along is of order
            1 in time and wants drifts and kicks that all go forwards: VelocityVerlet(), SemiImplicitEuler() or
            McLachlan2().
        shifting: the coefficient A, at least zero; 0: not at all; "auto": 6 where it is safe, which is a single fluid
            that is alone, without forces and boundaries, or starts without a free surface, and 0 elsewhere. It goes
            with density from continuity, and neither with surface tension nor with forces between pairs that act on
            the fluid.

    Raises:
        SceneError: a value is out of range, or it is shifted with density from summation; later, with a scene, it is
            shifted with surface tension.

    Warns:
        MachWarning: sound is slower than the flow at the start.
        SceneWarning: c² is below 100 νU/L, so that friction compresses the fluid by more than a percent.

    Source: J. J. Monaghan, J. Comput. Phys. 110, 399 (1994), with the pressure of R. H. Cole, "Underwater Explosions",
    1948; αhc/2(D + 2) of J. J. Monaghan, Rep. Prog. Phys. 68, 1703 (2005); the diffusion of density after G. Fourtakas
    et al., Comput. Fluids 190, 346 (2019); obstacles as in S. Adami, X. Y. Hu, N. A. Adams, J. Comput. Phys. 231, 7057
    (2012); the rule for creeping flow of J. P. Morris, P. J. Fox, Y. Zhu, the same 136, 214 (1997). Shifting after
    S. J. Lind, R. Xu, P. K. Stansby, B. D. Rogers, the same 231, 1499 (2012); A of A. Skillen et al., Comput. Methods
    Appl. Mech. Eng. 265, 163 (2013), from 1 to 6; the weights of P. N. Sun et al., the same 315, 25 (2017), and their
    limit, 348, 912 (2019), but with a U of each place, which is the same to whoever moves or turns along. Viscosity at
    free surfaces as of A. Colagrossi et al., Phys. Rev. E 84, 026705 (2011), with F for their F/d²; its forces along v
    are those of J. P. Morris et al., as above.
    """

    sound_speed: float | Literal["auto"] = "auto"
    kernel: Kernel = WendlandC2()  # noqa: RUF009 - it cannot change
    artificial_viscosity: float | Literal["auto"] = "auto"
    density_diffusion: float = 0.1
    density_from: Literal["continuity", "summation"] = "continuity"
    shifting: float | Literal["auto"] = "auto"

    def __post_init__(self) -> None:
        kind = type(self).__name__
        for entry in fields(self):
            value = CHECKS[entry.name](getattr(self, entry.name), f"{kind}.{entry.name}")
            object.__setattr__(self, entry.name, value)
        if self.shifting != "auto" and self.shifting > 0.0 and self.density_from == "summation":
            raise SceneError(
                f"{kind}.shifting: must be 0 with density_from='summation', which keeps particles apart by itself"
            )

    def check(self, fluid: Fluid, path: str, units: UnitSystem) -> None:
        """As of FluidMethod."""
        if self.sound_speed == "auto" or len(fluid) == 0:
            return
        fastest, speed = float(lengths(fluid.velocities).max()), f"{self.sound_speed:g}{units.suffix('m/s')}"
        if fastest >= self.sound_speed:
            warn(
                f"{path}.sound_speed: {speed} are less than the speed of the flow, {fastest:.3g}{units.suffix('m/s')} "
                "at the start: such a fluid is a gas; 'auto' is ten times the greatest speed to be expected",
                MachWarning,
            )
        size = float(np.ptp(fluid.positions, axis=0).min()) + fluid.spacing
        needed = float(np.sqrt(fluid.viscosity / fluid.density * fastest / (COMPRESSED * size)))
        if self.sound_speed < needed:
            warn(
                f"{path}.sound_speed: {speed} are too few for this viscosity, whose friction changes "
                f"the density by more than a percent: take {needed:.3g} or 'auto'",
                SceneWarning,
            )
