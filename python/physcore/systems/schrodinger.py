"""Wave functions on a grid: the Schrödinger and the Gross–Pitaevskii equation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physcore.arithmetic import arctan2, cos, exp, sin
from physcore.checks import LONGEST, FloatArray, array, called, frozen, number, regular, require, shown, text
from physcore.entrance import entrance
from physcore.errors import SceneError, SceneWarning, warn
from physcore.scene.edges import Absorbing, Condition, absorbing_layer
from physcore.scene.grid import Field, Grid, GridSystem
from physcore.systems.resolution import note, wave_number
from physcore.systems.wave import EDGES, Edges

ComplexArray: TypeAlias = NDArray[np.complex128]
Complex: TypeAlias = ArrayLike | Callable[..., ArrayLike]
"""Complex field: an array of the grid's shape, or a function of the coordinates."""


@entrance
def wave_packet(
    grid: Grid, center: ArrayLike, momentum: ArrayLike, width: ArrayLike, hbar: float = 1.0
) -> ComplexArray:
    """Gaussian wave packet exp(−(x − c)²/4σ² + ip(x − c)/ħ), an array of shape `grid.cells` with Σ|ψ|² hᴰ = 1.

        grid = pc.Grid((512,), spacing=0.1)
        packet = pc.wave_packet(grid, center=15.0, momentum=2.0, width=1.5)

    Along a periodic axis, the nearest image of the center is used. The phase is 0 at the center.

    Args:
        grid: a grid in 1D, 2D or 3D.
        center: center c [m], one number for each axis, or one for all.
        momentum: mean momentum p [kg·m/s], likewise.
        width: standard deviation σ of |ψ|² [m], likewise, above zero.
        hbar: reduced Planck constant ħ [J·s].

    Raises:
        SceneError: a value is out of range or of the wrong shape, or the packet is zero on the whole grid.
    """
    if not isinstance(grid, Grid):
        raise SceneError(f"wave_packet.grid: must be a Grid, got {shown(grid)}")
    given = {"center": center, "momentum": momentum, "width": width}
    places, momenta, widths = (_per_axis(value, grid, f"wave_packet.{name}") for name, value in given.items())
    require(np.abs(places) <= LONGEST, places, "wave_packet.center", f"at most {LONGEST:g} in size")
    require(widths > 0.0, widths, "wave_packet.width", "> 0")
    unit = number(hbar, "wave_packet.hbar", above=0.0)
    with np.errstate(over="ignore"):
        turns = np.abs(momenta) * grid.spacing / unit
    if np.isfinite(turns).all() and (turns > math.pi).any():
        warn(
            f"wave_packet.momentum: p h/ħ = {turns.max():.3g} is above π, the largest of a grid, which takes it for "
            f"another momentum; take a spacing below {math.pi * grid.spacing / turns.max():.2g} m",
            SceneWarning,
        )
    envelope, phase = np.zeros(grid.cells), np.zeros(grid.cells)
    with np.errstate(over="ignore", invalid="ignore"):  # a very narrow packet underflows beside its center
        for axis, x in enumerate(grid.coordinates):
            away = x - places[axis]
            if grid.periodic[axis]:
                length = grid.cells[axis] * grid.spacing
                away = away - length * np.rint(away / length)
            envelope -= np.square(away / widths[axis]) / 4.0
            phase += momenta[axis] * away * (1.0 / unit)
    if not np.isfinite(phase).all():
        raise SceneError(f"wave_packet.momentum: p x/ħ must be finite, got {shown(momentum)} with ħ = {unit:g} J·s")
    size = exp(envelope)
    norm = float(np.square(size).sum()) * math.prod([grid.spacing] * grid.dimension)
    if not norm > 0.0:
        raise SceneError(f"wave_packet.center: must be on the grid or near it, got {shown(center)}")
    size /= math.sqrt(norm)
    packet: ComplexArray = np.stack([size * cos(phase), size * sin(phase)], axis=-1).view(np.complex128)[..., 0]
    return packet


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Schrodinger(GridSystem):
    """Wave function with the equation iħ ∂ψ/∂t = (−ħ²/2m ∇² + V + g|ψ|²) ψ.

        line = pc.Grid((512,), spacing=0.1)
        packet = pc.wave_packet(line, center=15.0, momentum=2.0, width=1.5)
        electron = pc.Schrodinger(line, packet, potential=lambda x: 2.5 * (abs(x - 26.0) < 0.5))
        recording = pc.simulate(pc.Scene(electron), duration=10.0)
        recording[electron].wave_function  # complex, (F, 512); also .density and .phase

    There are budgets of the probability Σ|ψ|² hᴰ in the grid, and of the energy ⟨H⟩. The energy is that of modes with
    SplitStep, and of finite differences with CrankNicolson and Staggered. The flux across an absorbing edge is
    `removed_by["edges"]` of the probability; an inward flux counts as negative. Energy is not localized. ⟨H⟩ therefore
    includes the absorbing layer, in which it is dissipated by "edges".

    Args:
        grid: a grid in 1D, 2D or 3D.
        wave_function: initial ψ [1/√mᴰ], an array of complex numbers of shape `grid.cells` or a function of the
            coordinates. Real and imaginary parts along a last axis are valid too. ψ is not normalized.
        potential: potential energy V [J], a field of real numbers.
        mass: particle mass m [kg], above zero.
        hbar: reduced Planck constant ħ [J·s], above zero.
        interaction: interaction strength g [J·mᴰ] of the Gross–Pitaevskii equation.
        edges: "fixed": ψ is zero on the outer face of the outer cells; "free": no flux through it; "absorbing": waves
            leave into a layer outside of the grid, by default three wavelengths wide. A word for all edges, or a
                mapping
            of axes or sides; other sides are fixed. Periodic axes of the grid have no edges.
        name: name of the system, also a key into results.
        absorbing: the layer of absorbing edges, as an alternative to `Absorbing` in `edges`.

    Raises:
        SceneError: a field has the wrong shape or values out of range, ψ is zero everywhere, or an edge is not valid.

    Source: L. Pitaevskii, S. Stringari, "Bose–Einstein Condensation", 2003, chapter 5.
    """

    units: ClassVar[Mapping[str, str]] = {"density": "m^-D", "wave_function": "m^(-D/2)"}
    signed: ClassVar[bool] = False
    default_integrator: ClassVar[str] = "SplitStep"
    derived: ClassVar[tuple[str, ...]] = ("density",)
    parts: ClassVar[tuple[type, ...]] = (Grid, Absorbing)

    wave_function: FloatArray
    """Initial ψ [1/√mᴰ], real and imaginary parts along a last axis."""
    potential: float | FloatArray
    """Potential energy V [J], a number or of shape `grid.cells`."""
    mass: float
    """Particle mass m [kg]."""
    hbar: float
    """Reduced Planck constant ħ [J·s]."""
    interaction: float
    """Interaction strength g [J·mᴰ]."""
    edges: tuple[Condition, ...]
    """Edge condition of each side, "fixed", "free", "absorbing" or "periodic", in the order x−, x+, y−, y+, z−, z+."""
    absorbing: Absorbing
    """The layer of absorbing edges."""

    def __init__(
        self,
        grid: Grid,
        wave_function: Complex,
        potential: Field = 0.0,
        mass: float = 1.0,
        hbar: float = 1.0,
        interaction: float = 0.0,
        edges: Edges = "fixed",
        name: str | None = None,
        *,
        absorbing: Absorbing | None = None,
    ) -> None:
        if not isinstance(grid, Grid):
            raise SceneError(f"Schrodinger.grid: must be a Grid, got {shown(grid)}")
        words, layer = grid.edges(edges, "Schrodinger.edges", EDGES, "fixed")
        self._set(
            grid=grid,
            wave_function=frozen(_pairs(wave_function, grid, "Schrodinger.wave_function")),
            potential=grid.uniform_or_field(potential, "Schrodinger.potential"),
            mass=number(mass, "Schrodinger.mass", above=0.0),
            hbar=number(hbar, "Schrodinger.hbar", above=0.0),
            interaction=number(interaction, "Schrodinger.interaction"),
            edges=words,
            name=None if name is None else text(name, "Schrodinger.name"),
            absorbing=absorbing_layer(absorbing, layer, words, "Schrodinger.absorbing"),
        )

    @property
    def landscape(self) -> FloatArray | None:
        """The potential."""
        potential = np.broadcast_to(np.asarray(self.potential, dtype=float), self.grid.cells)
        height = float(np.ptp(potential))
        return (potential - potential.min()) / height if height > 0.0 else None

    def unresolved(self, integrator: str) -> list[str]:
        """A note on an initial wave function that differences slow down; SplitStep takes modes, which are exact."""
        if integrator == "SplitStep":
            return []
        number = wave_number(np.ascontiguousarray(self.wave_function).view(np.complex128)[..., 0])
        return note("wave function at the start", number, _group_velocity, self.grid.spacing)

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shapes of the fields by name, as in the engine."""
        return {"density": self.grid.cells, "wave_function": (*self.grid.cells, 2)}

    def values(self, field: str, value: object, path: str) -> FloatArray:
        """A new wave function, from an array or a function of the coordinates."""
        return _pairs(value, self.grid, path) if field == "wave_function" else super().values(field, value, path)

    def shown(self, fields: dict[str, FloatArray]) -> dict[str, Any]:
        """The wave function as complex numbers, and its phase [rad], from −π to π."""
        if "wave_function" not in fields:
            return fields
        complete = np.ascontiguousarray(fields["wave_function"]).view(np.complex128)[..., 0]
        return {**fields, "wave_function": complete, "phase": arctan2(complete.imag, complete.real)}

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        return f"Schrodinger({label}{' × '.join(map(str, self.grid.cells))} cells)"


def _group_velocity(number: float) -> float:
    """The group velocity over p/m of waves with p h/ħ = `number`, by differences."""
    return float(sin(number)) / number if number > 0.0 else 1.0


def _per_axis(value: ArrayLike, grid: Grid, path: str) -> FloatArray:
    """One number for each axis, from one number for all axes or one for each."""
    numbers = array(value, path)
    if numbers.shape not in ((), (grid.dimension,)):
        raise SceneError(f"{path}: must be a number, or {grid.dimension} for this grid, got the shape {numbers.shape}")
    return np.broadcast_to(numbers, (grid.dimension,))


def _pairs(value: object, grid: Grid, path: str) -> FloatArray:
    """A complex field as real and imaginary parts along a last axis."""
    given = regular(called(value, path, *grid.coordinates) if callable(value) else value, path)
    if given.shape == (*grid.cells, 2) and given.dtype.kind != "c":
        parts = array(given, path)
    else:
        each = (given.real, given.imag) if given.dtype.kind == "c" else (given, np.broadcast_to(0.0, given.shape))
        both = [grid.field((lambda *_, part=part: part) if callable(value) else part, path) for part in each]
        parts = np.stack(both, axis=-1)
    if not parts.any():
        raise SceneError(f"{path}: must not be zero everywhere")
    return parts
