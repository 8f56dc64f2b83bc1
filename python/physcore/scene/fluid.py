"""Fluids: bodies whose particles are lumps of matter that fills space."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import FloatArray, Vector, flag, is_word, number, shown, span, word
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.kernels import KERNELS, Kernel, WendlandC2
from physcore.scene.overlaps import closer_than
from physcore.scene.shapes import block

FINEST = 1e-50
"""The least spacing [m]: the slopes of kernels go with its inverse up to the fifth power, and are still numbers."""

CLOSEST = 0.5
"""Particles of fluids that start closer together than this fraction of their spacing are a mistake."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Fluid(Body):
    """A weakly compressible fluid, as smoothed particle hydrodynamics (SPH) sees it.

        water = pc.Fluid.block((0.0, 0.0), (0.4, 0.6), spacing=0.05, name="water")
        tank = pc.Box((0.0, 0.0), (1.2, 1.0))
        scene = pc.Scene(water, pc.Gravity(), tank)
        recording = pc.simulate(scene, duration=0.5)
        recording.film("dam_break.png")

    Change these three first: `spacing`, how fine the water is (with half of it a film takes eight times as long in 2D,
    and sixteen times in 3D); `viscosity`, 1e-3 of water, 1 of honey; and `surface_tension`, 0.072 of water, which drops
    need and a tank does not.

    Each particle is a lump of the mass density · spacing^D that moves with the flow; in 2D the mass is that of a meter
    of depth. Pressure grows with density, p = c² ρ₀/7 ((ρ/ρ₀)⁷ − 1), and c is far above the speed of the flow, so that
    the density changes by a percent or so. A fluid starts under the weight of what is above it, as at rest. It fills
    the space up to boundaries, and slips freely along them unless they say no_slip. Fluids of one scene may differ in
    density, viscosity and surface tension, and have everything else in common.

    Surface tension is the energy of particles that lack neighbors of their own fluid: next to a free surface, and next
    to another fluid, where the tension of the interface is the sum of both. Walls and obstacles count as more of the
    same fluid, so that a surface meets them at an angle of 90°. The energy stands in the audit as "surface tension". σ
    is that of a surface that has settled, with the default kernel: particles find their places in the first moments. In
    2D drops then swing as they should to a few percent; narrower kernels and 3D make small drops stiff, so that they
    grow round but hardly swing.

    Args:
        positions: [m], shape (N, D) with D = 2 or 3; `block`, `ball` and `cylinder` make them.
        spacing: the distance between neighboring particles at rest [m], above zero.
        density: ρ₀, at rest [kg/m³], above zero.
        viscosity: the dynamic viscosity μ [Pa·s], at least zero; 1e-3 is water.
        sound_speed: c [m/s], above zero; "auto": ten times the greatest speed to be expected from the scene, and at
            least √(40 σ/(ρ₀ spacing)), with which surface tension changes density by a few percent next to a surface.
        kernel: WendlandC2(), WendlandC4() or CubicSpline(), how particles are smoothed out.
        artificial_viscosity: the coefficient α, at least zero, which damps what the particles cannot resolve. With less
            waves last longer.
        density_diffusion: the coefficient δ, at least zero, which damps noise of the density.
        velocities: [m/s], broadcast to (N, D).
        name: a name by which results can be asked for.
        obstacles: whether it meets the other bodies of the scene; if not, they pass through each other.
        density_from: "continuity": density is carried along and changes with the flow; "summation": it is counted from
            where the particles are, so that it never drifts and energy is that of the particles' places. That is for
            fluids that fill a closed or periodic space, because at a free surface there is nothing to count; it has no
            noise for δ to damp. Any integrator drives a density that is counted; one that is carried along is of order
            1 in time and wants drifts and kicks that all go forwards: VelocityVerlet(), SemiImplicitEuler() or
            McLachlan2().
        surface_tension: σ [N/m], at least zero; 0.072 is water. It acts on what is some particles thick.
        shifting: the coefficient A, at least zero, by which particles are moved beside their velocity from where they
            are crowded to where there is room. 0: not at all; 6 is what the validation is run with. It keeps flows that
            stretch, and negative pressures, from gathering particles in strands with voids between them. It goes with
            density from continuity, and neither with surface tension nor with forces between pairs that act on the
            fluid.

    What shifting is: each step moves a particle by δx = −A h U dt Σ V [1 + (W/W(Δ))⁴/5] ∇W, where U is the difference
    of velocity over 8h, c/10 at most, and δx at most c dt/20; but none at a free surface, and none through a wall. It
    never bounds the time step, but is a third sum beside two. Momentum and the energies of motion and of compression
    are kept exactly, angular momentum only to some 1e-3. What it changes in potential energy counts as work: a wave is
    lifted a little. Fluids that meet are shifted as one, and may mix.

    Raises:
        SceneError: a shape does not fit, a value is not finite or out of range, two particles are closer together than
            half the spacing, or it is shifted with density from summation or with surface tension.

    Source: J. J. Monaghan, J. Comput. Phys. 110, 399 (1994), with the pressure of R. H. Cole, "Underwater Explosions",
    1948; the diffusion of density after G. Fourtakas et al., Comput. Fluids 190, 346 (2019); obstacles as in S. Adami,
    X. Y. Hu, N. A. Adams, J. Comput. Phys. 231, 7057 (2012); surface tension from the energies of S. Nugent, H. A.
    Posch, Phys. Rev. E 62, 4968 (2000), and of J. W. Cahn, J. E. Hilliard, J. Chem. Phys. 28, 258 (1958). Shifting
    after S. J. Lind, R. Xu, P. K. Stansby, B. D. Rogers, J. Comput. Phys. 231, 1499 (2012); A of A. Skillen et al.,
    Comput. Methods Appl. Mech. Eng. 265, 163 (2013), from 1 to 6; the weights of P. N. Sun et al., the same 315, 25
    (2017), and their limit, 348, 912 (2019), but with a U of each place, which is the same to whoever moves or turns
    along.
    """

    spacing: float
    """The distance between neighboring particles at rest [m]."""
    density: float
    """The density at rest [kg/m³]."""
    viscosity: float
    """The dynamic viscosity [Pa·s]."""
    sound_speed: float | Literal["auto"]
    """The speed of sound [m/s], or "auto"."""
    kernel: Kernel
    """How particles are smoothed out."""
    artificial_viscosity: float
    """The coefficient α of the artificial viscosity."""
    density_diffusion: float
    """The coefficient δ of the diffusion of density."""
    obstacles: bool
    """Whether it meets the bodies that are no fluids."""
    density_from: Literal["continuity", "summation"]
    """How density is found."""
    surface_tension: float
    """The surface tension [N/m]."""
    shifting: float
    """The coefficient A of shifting."""

    def __init__(
        self,
        positions: ArrayLike,
        spacing: float,
        density: float = 1000.0,
        viscosity: float = 1e-3,
        sound_speed: float | Literal["auto"] = "auto",
        kernel: Kernel = WendlandC2(),  # noqa: B008 - it cannot change
        artificial_viscosity: float = 0.02,
        density_diffusion: float = 0.1,
        velocities: ArrayLike = 0.0,
        name: str | None = None,
        obstacles: bool = True,
        density_from: Literal["continuity", "summation"] = "continuity",
        surface_tension: float = 0.0,
        shifting: float = 0.0,
    ) -> None:
        step = number(span(spacing, "Fluid.spacing"), "Fluid.spacing", least=FINEST)
        rest = number(density, "Fluid.density", above=0.0)
        self._set_particles(positions, velocities, 1.0, 0.0, 0.0, None, name)
        self._set(
            mass=np.full(len(self), _mass(rest, step, self.dimension)),
            spacing=step,
            density=rest,
            viscosity=number(viscosity, "Fluid.viscosity", least=0.0),
            sound_speed=_sound_speed(sound_speed),
            kernel=_kernel(kernel),
            artificial_viscosity=number(artificial_viscosity, "Fluid.artificial_viscosity", least=0.0),
            density_diffusion=number(density_diffusion, "Fluid.density_diffusion", least=0.0),
            density_from=word(density_from, "Fluid.density_from", ("continuity", "summation")),
            surface_tension=number(surface_tension, "Fluid.surface_tension", least=0.0),
            obstacles=flag(obstacles, "Fluid.obstacles"),
            shifting=number(shifting, "Fluid.shifting", least=0.0),
        )
        if self.shifting > 0.0 and self.density_from == "summation":
            raise SceneError(
                "Fluid.shifting: must be 0 with density_from='summation', which keeps particles apart by itself"
            )
        if self.shifting > 0.0 and self.surface_tension > 0.0:
            raise SceneError("Fluid.shifting: must be 0 with surface_tension, whose energy it would change unseen")
        pair = closer_than(self.positions, CLOSEST * step)
        if pair is not None:
            raise SceneError(f"Fluid.positions: overlapping particles: {describe_pair(self.positions, pair, step)}")

    @classmethod
    def block(cls, lower: Vector, upper: Vector, spacing: float, **options: Any) -> Fluid:
        """A rectangle in 2D, or a cuboid in 3D, full of a fluid, as `physcore.block` fills it.

            water = pc.Fluid.block((0.0, 0.0), (0.5, 1.0), spacing=0.05, name="water")

        Args:
            lower: the corner with the smallest coordinates [m].
            upper: the corner with the largest coordinates [m].
            spacing: the distance between neighboring particles [m].
            options: the other arguments of Fluid.

        Raises:
            SceneError: as for `physcore.block` and Fluid.
        """
        return cls(block(lower, upper, spacing), spacing, **options)


def describe_pair(points: FloatArray, pair: tuple[int, int], spacing: float) -> str:
    """How close two particles are, in words."""
    one, other = pair
    separation = float(np.linalg.norm(points[one] - points[other]))
    return f"{one} and {other} are {separation:.3g} m apart, which is less than half the spacing of {spacing:g} m"


def _mass(density: float, spacing: float, dimension: int) -> float:
    """That of one particle [kg].

    Raises:
        SceneError: it is too large or too small for a number.
    """
    try:
        mass = density * spacing**dimension
    except OverflowError:
        mass = math.inf
    if not 0.0 < mass < math.inf:
        rule = f"density · spacing^{dimension} must be a finite mass above 0"
        raise SceneError(f"Fluid.density: {rule}, got {mass:g} kg with a spacing of {spacing:g} m")
    return mass


def _sound_speed(value: object) -> float | Literal["auto"]:
    if is_word(value, "auto"):
        return "auto"
    if isinstance(value, str):
        raise SceneError(f"Fluid.sound_speed: must be a number of meters per second or 'auto', got {shown(value)}")
    return span(value, "Fluid.sound_speed")


def _kernel(value: object) -> Kernel:
    if isinstance(value, KERNELS):
        return value
    known = ", ".join(f"{kind.__name__}()" for kind in KERNELS)
    missing = f"; write {value.__name__}()" if isinstance(value, type) else ""
    raise SceneError(f"Fluid.kernel: must be one of {known}, got {shown(value)}{missing}")
