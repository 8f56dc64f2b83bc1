"""Fluids: bodies whose particles are lumps of matter that fills space."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import lengths
from physcore.checks import FloatArray, Vector, flag, number, span
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.fields import Element
from physcore.scene.overlaps import closer_than
from physcore.scene.shapes import block
from physcore.units.systems import Default

FINEST = 1e-50
"""The least spacing [m]: the slopes of kernels go with its inverse up to the fifth power, and are still numbers."""

CLOSEST = 0.5
"""Particles of fluids that start closer together than this fraction of their spacing are a mistake."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Fluid(Body):
    """A fluid: what is there. How it is computed is `fluids=` beside the scene.

        water = pc.Fluid.block((0.0, 0.0), (0.4, 0.6), spacing=0.05, name="water")
        tank = pc.Box((0.0, 0.0), (1.2, 1.0))
        scene = pc.Scene(water, pc.Gravity(), tank)
        recording = pc.simulate(scene, duration=0.5)
        recording.film("dam_break.png")

    Change these three first: `spacing`, how fine the water is (with half of it a film takes eight times as long in 2D,
    and sixteen times in 3D); `viscosity`, 1e-3 of water, 1 of honey; and `surface_tension`, 0.072 of water, which drops
    need and a tank does not.

    Each particle is a lump of the mass density · spacing^D that moves with the flow; in 2D the mass is that of a meter
    of depth. A fluid starts under the weight of what is above it, as at rest. It fills the space up to boundaries, and
    slips freely along them unless they say no_slip; `WeaklyCompressible` says when to take which. Fluids of one scene
    may differ in density, viscosity and surface tension, and have everything else in common.

    Results: `recording[water].pressures` and `.densities` of the particles, where they are asked for by `channels`;
    `recording[tank].force` on each boundary and on each other body, and the pressure at a point with `Probe`.

    Surface tension is the energy of particles that lack neighbors of their own fluid: next to a free surface, and next
    to another fluid, where the tension of the interface is the sum of both. Walls and obstacles count as more of the
    same fluid, so that a surface meets them at an angle of 90°. The energy stands in the audit as "surface tension". σ
    is that of a surface that has settled, with the default kernel: particles find their places in the first moments.
    Drops then swing with Rayleigh's frequency, to 15 %, and have Laplace's pressure, to 15 %. They lose up to a fifth
    of their amplitude per period in 2D and up to half of it in 3D, more than viscosity alone takes. With other kernels
    σ is off by up to a third, and those narrower than a smoothing of 0.75 are refused.

    Args:
        positions: [m], shape (N, D) with D = 2 or 3; `block`, `ball` and `cylinder` make them.
        spacing: the distance between neighboring particles at rest [m], above zero.
        density: ρ₀, at rest [kg/m³], above zero; to be given in a scene with other units.
        viscosity: the dynamic viscosity μ [Pa·s], at least zero; 1e-3 is water. To be given in a scene with other
            units.
        velocities: [m/s], broadcast to (N, D).
        name: a name by which results can be asked for.
        obstacles: whether it meets the other bodies of the scene; if not, they pass through each other.
        surface_tension: σ [N/m], at least zero; 0.072 is water. It acts on what is some particles thick.

    Raises:
        SceneError: a shape does not fit, a value is not finite or out of range, or two particles are closer together
            than half the spacing.

    Source: surface tension from the energies of S. Nugent, H. A. Posch, Phys. Rev. E 62, 4968 (2000), and of
    J. W. Cahn, J. E. Hilliard, J. Chem. Phys. 28, 258 (1958), kept apart by a local density as in P. B. Warren, Phys.
    Rev. E 68, 066702 (2003).
    """

    is_fluid: ClassVar[bool] = True
    is_loose: ClassVar[bool] = False

    spacing: float
    """The distance between neighboring particles at rest [m]."""
    density: float
    """The density at rest [kg/m³]."""
    viscosity: float
    """The dynamic viscosity [Pa·s]."""
    obstacles: bool
    """Whether it meets the bodies that are no fluids."""
    surface_tension: float
    """The surface tension [N/m]."""

    def __init__(
        self,
        positions: ArrayLike,
        spacing: float,
        density: float = Default(1000.0, "kg/m³"),
        viscosity: float = Default(1e-3, "Pa·s"),
        velocities: ArrayLike = 0.0,
        name: str | None = None,
        obstacles: bool = True,
        surface_tension: float = 0.0,
    ) -> None:
        step = number(span(spacing, "Fluid.spacing"), "Fluid.spacing", least=FINEST)
        rest = number(density, "Fluid.density", above=0.0)
        self._set_particles(positions, velocities, 1.0, 0.0, 0.0, None, name)
        self._set(
            mass=np.full(len(self), _mass(rest, step, self.dimension)),
            spacing=step,
            density=rest,
            viscosity=number(viscosity, "Fluid.viscosity", least=0.0),
            surface_tension=number(surface_tension, "Fluid.surface_tension", least=0.0),
            obstacles=flag(obstacles, "Fluid.obstacles"),
        )
        pair = closer_than(self.positions, CLOSEST * step)
        if pair is not None:
            raise SceneError(f"Fluid.positions: overlapping particles: {describe_pair(self.positions, pair, step)}")

    @property
    def elements(self) -> dict[Element, int]:
        """The number of particles, which have densities and pressures; no wall."""
        return {"particles": len(self), "fluid particles": len(self)}

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
    separation = float(lengths(points[one] - points[other]))
    return f"{one} and {other} are {separation:.3g} m apart, which is less than half the spacing of {spacing:g} m"


def _mass(density: float, spacing: float, dimension: int) -> float:
    """The mass of one particle [kg].

    Raises:
        SceneError: it is too large or too small for a number.
    """
    try:
        mass = density * math.prod([spacing] * dimension)
    except OverflowError:
        mass = math.inf
    if not 0.0 < mass < math.inf:
        rule = f"density · spacing^{dimension} must be a finite mass above 0"
        raise SceneError(f"Fluid.density: {rule}, got {mass:g} kg with a spacing of {spacing:g} m")
    return mass
