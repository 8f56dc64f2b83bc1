"""Wave equation on a grid."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import cos, exp, sin
from physcore.checks import (
    BoolArray,
    FloatArray,
    array,
    called,
    count,
    frozen,
    items,
    number,
    regular,
    require,
    shown,
    text,
)
from physcore.errors import SceneError, SceneWarning, warn
from physcore.scene.edges import Absorbing, Condition, Dirichlet, Neumann, absorbing_layer
from physcore.scene.grid import AXES, Field, Grid, GridSystem
from physcore.systems.resolution import angle, note, wave_number

Edge = Literal["fixed", "free", "absorbing"]
Side: TypeAlias = Edge | Absorbing | Dirichlet | Neumann
Edges: TypeAlias = Side | Mapping[str, Side] | Sequence[Condition]
"""Edge conditions: one for all edges, or a mapping from axes ("x") and sides ("x-", "x+") to conditions."""
EDGES: tuple[Edge, ...] = ("fixed", "free", "absorbing")
ORDERS = (2, 4)
"""Orders of the spatial differences."""
STEEPEST = {2: 1.0, 4: math.sqrt(4.0 / 3.0)}
"""Largest ω h/2c of waves that travel on a grid, by the order of the differences."""


@dataclass(frozen=True)
class Ricker:
    """Ricker pulse, the second derivative of a Gaussian: (1 − 2 π² f² τ²) exp(−π² f² τ²) with τ = t − 1.5/f.

        grid = pc.Grid((100, 60), spacing=0.1)
        drop = pc.Source((5.0, 3.0), amplitude=1.0, signal=pc.Ricker(2.0))
        pond = pc.Wave(grid, speed=1.0, sources=[drop])

    The largest value is 1, at t = 1.5/f. The spectrum has its maximum at f. At t = 0 the value is 1e-8.

    Args:
        frequency: peak frequency f [Hz], above zero.

    Source: N. Ricker, Geophysics 18, 10 (1953).

    Raises:
        SceneError: the frequency is not above zero.
    """

    frequency: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "frequency", number(self.frequency, "Ricker.frequency", above=0.0))

    def __call__(self, time: ArrayLike) -> FloatArray:
        """The values at times [s]."""
        square = np.square(np.pi * self.frequency * (np.asarray(time, dtype=float) - 1.5 / self.frequency))
        pulse: FloatArray = (1.0 - 2.0 * square) * exp(-square)
        return pulse


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Source:
    """Source of waves: s = amplitude · sin(2 π f t + phase) from `start` to `stop`, and zero before and after.

        grid = pc.Grid((100, 60), spacing=0.1)
        lamp = pc.Source((8.0, 3.0), amplitude=0.5, frequency=0.6)
        slit = pc.Source(grid.centers[..., 0] < 0.1, amplitude=1.0, signal=pc.Ricker(2.0))
        pond = pc.Wave(grid, speed=1.0, sources=[lamp, slit])

    Args:
        where: a point [m], D numbers within the grid. The amplitude is then the integral of s over space, distributed
            multilinearly over the nearest cell centers, so that the radiation does not depend on the spacing. Or a mask
            of the grid's shape, with equal s in all its cells; or an array of weights.
        amplitude: amplitude [m/s²] in each cell of a mask; at a point [m/s²·mᴰ].
        frequency: frequency f [Hz], at least zero; not needed with a signal.
        phase: phase [rad].
        start, stop: times at which the source begins and ends to act [s].
        signal: function s(t) of the time [s] that replaces the sine and returns a number, such as `pc.Ricker(f)`.

    Raises:
        SceneError: a value is out of range or of the wrong kind, or neither frequency nor signal is given.
    """

    where: tuple[float, ...] | BoolArray | FloatArray
    """Point [m], or the weights of cells."""
    amplitude: float
    """Amplitude [m/s²], or [m/s²·mᴰ] at a point."""
    frequency: float
    """Frequency [Hz]; 0 with a signal."""
    phase: float
    """Phase [rad]."""
    start: float
    """Start time [s]."""
    stop: float
    """End time [s]; may be infinite."""
    signal: Ricker | Callable[[float], float] | None
    """Function that replaces the sine, or None."""

    def __init__(
        self,
        where: ArrayLike,
        amplitude: float,
        frequency: float | None = None,
        phase: float = 0.0,
        start: float = 0.0,
        stop: float = math.inf,
        signal: Ricker | Callable[[float], float] | None = None,
    ) -> None:
        if signal is None and frequency is None:
            raise SceneError("Source.frequency: give a frequency [Hz], or a signal")
        if signal is not None and not callable(signal):
            raise SceneError(f"Source.signal: must be a function of the time, or Ricker(…), got {shown(signal)}")
        given: object = stop
        end = math.inf if isinstance(given, (float, np.floating)) and given == math.inf else number(stop, "Source.stop")
        values = {
            "where": _where(where),
            "amplitude": number(amplitude, "Source.amplitude"),
            "frequency": 0.0 if frequency is None else number(frequency, "Source.frequency", least=0.0),
            "phase": number(phase, "Source.phase"),
            "start": number(start, "Source.start"),
            "stop": end,
            "signal": signal,
        }
        if not values["start"] < end:  # type: ignore[operator]
            raise SceneError(f"Source.stop: must be after the start at {start:g} s, got {end:g} s")
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        where = self.where if isinstance(self.where, tuple) else f"{np.count_nonzero(self.where)} cells"
        what = f"{self.frequency:g} Hz" if self.signal is None else shown(self.signal)
        return f"Source({where}, {self.amplitude:g}, {what})"

    def steepness(self, grid: Grid, speed: float | FloatArray) -> float:
        """ω h/2c for the frequency of the source and the slowest waves at it; waves exist up to 1. 0 if unknown."""
        frequency = self.signal.frequency if isinstance(self.signal, Ricker) else self.frequency
        slowest = float(np.broadcast_to(speed, grid.cells)[self.cells(grid)].min(initial=math.inf))
        return math.pi * frequency * grid.spacing / slowest if slowest > 0.0 else 0.0

    def cells(self, grid: Grid) -> BoolArray:
        """Mask of the cells of the source; of a point those with the nearest centers, two along each axis."""
        if not isinstance(self.where, tuple):
            return np.not_equal(self.where, 0.0)
        mask = np.zeros(grid.cells, dtype=bool)
        place = (np.array(self.where) - grid.origin) / grid.spacing - 0.5
        first = np.maximum(np.floor(place).astype(int), 0)
        mask[tuple(slice(start, start + 2) for start in first)] = True
        return mask

    def check(self, grid: Grid, path: str) -> None:
        """Check that the source fits a grid.

        Raises:
            SceneError: the source is outside of the grid, a mask has another shape, or the signal does not return a
                number.
        """
        if isinstance(self.where, tuple):
            if len(self.where) != grid.dimension:
                raise SceneError(f"{path}.where: must be {grid.dimension} numbers on this grid, got {self.where}")
            for axis, place, low, high in zip(AXES, self.where, grid.origin, grid.upper, strict=False):
                if not low <= place <= high:
                    raise SceneError(
                        f"{path}.where: must be on the grid, {axis} from {low:g} to {high:g} m, got {place:g} m"
                    )
        elif self.where.shape != grid.cells:
            raise SceneError(f"{path}.where: must have the shape {grid.cells} of the grid, got {self.where.shape}")
        if self.signal is not None:
            number(called(self.signal, f"{path}.signal", max(self.start, 0.0)), f"{path}.signal: its value")


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Wave(GridSystem):
    """Wave equation on a string, on a membrane or in space: ρ u_tt = ∇·(ρ c² ∇u) − ρ γ u_t + ρ s.

        grid = pc.Grid((200, 120), spacing=0.05)
        pond = pc.Wave(grid, speed=1.0, displacement=lambda x, y: np.exp(-((x - 3) ** 2 + (y - 3) ** 2) / 0.1),
                       edges={"x": "absorbing", "y": "free"})
        recording = pc.simulate(pc.Scene(pond), duration=10.0)
        recording[pond].displacement  # (F, 200, 120)

    Fields are numbers, arrays of shape `grid.cells` or functions of the coordinates of the cell centers. Differences
    are central. On a face between two cells, ρ c² is their harmonic mean, so that u and ρ c² ∂u/∂n are continuous at
    jumps of ρ and c. The discrete energy is the one whose negative gradient is the force. In 2D it is that of a
    membrane with the mass per area ρ, in 1D that of a string with the mass per length ρ, both under the tension ρ c².

    The impedance is Z = ρ c. An interface reflects R = (Z₁ − Z₂)/(Z₁ + Z₂) of the amplitude at normal incidence.

    Sound in a medium with the mass density ρ_m has the pressure p, with p_tt/(ρ_m c²) = ∇·(∇p/ρ_m). Take u = p and
    ρ = 1/(ρ_m c²):

        air_and_water = pc.Grid(200, spacing=0.01)
        c, mass_density = np.repeat([343.0, 1480.0], 100), np.repeat([1.2, 1000.0], 100)
        sound = pc.Wave(air_and_water, speed=c, density=1.0 / (mass_density * c**2), edges="absorbing")

    Args:
        grid: a grid in 1D, 2D or 3D.
        speed: wave speed c [m/s], a field ≥ 0.
        displacement: initial u [m], a field.
        rate: initial u_t [m/s], a field.
        density: density ρ [kg/mᴰ], a field > 0. If it is a number, only energies depend on it.
        damping: damping rate γ [1/s], a field ≥ 0.
        edges: "fixed": u is zero on the outer face of the outer cells; "free": no flux through it; "absorbing": waves
            leave into a layer outside of the grid; `Dirichlet(value)` and `Neumann(gradient)`: others than zero, also
            as functions of the time. One condition for all edges, or a mapping of axes or sides, `{"x": "free", "y-":
            "absorbing"}`; other sides are fixed. Periodic axes of the grid have no edges.
        walls: a mask of excluded cells, with u zero on their faces; or a function that returns one.
        sources: a Source, or several.
        order: order of the spatial differences, 2 or 4; only 2 with absorbing edges and with values at edges.
        name: name of the system, also a key into results.
        absorbing: the layer of absorbing edges, as an alternative to `Absorbing` in `edges`.

    Raises:
        SceneError: a field has the wrong shape or values out of range, or an edge or a source is not valid.

    Source: R. Courant, K. Friedrichs, H. Lewy, Math. Ann. 100, 32 (1928); for variable c, G. C. Cohen, "Higher-Order
    Numerical Methods for Transient Wave Equations", 2002, chapter 4.
    """

    parts: ClassVar[tuple[type, ...]] = (Grid, Absorbing, Dirichlet, Neumann, Source, Ricker)

    speed: float | FloatArray
    """Wave speed c [m/s], a number or of shape `grid.cells`."""
    displacement: float | FloatArray
    """Initial u [m], likewise."""
    rate: float | FloatArray
    """Initial u_t [m/s], likewise."""
    density: float | FloatArray
    """Density ρ [kg/mᴰ], a number or of shape `grid.cells`."""
    damping: float | FloatArray
    """Damping rate γ [1/s], a number or of shape `grid.cells`."""
    edges: tuple[Condition, ...]
    """Edge condition of each side, "fixed", "free", "absorbing", "periodic" or one with a value, in the order x−, x+,
    y−, y+, z−, z+.
    """
    walls: BoolArray | None
    """Mask of the excluded cells, of shape `grid.cells`; None: none."""
    sources: tuple[Source, ...]
    """The sources."""
    order: int
    """Order of the spatial differences."""
    absorbing: Absorbing
    """The layer of absorbing edges."""

    def __init__(
        self,
        grid: Grid,
        speed: Field,
        displacement: Field = 0.0,
        rate: Field = 0.0,
        density: Field = 1.0,
        damping: Field = 0.0,
        edges: Edges = "fixed",
        walls: Any = None,
        sources: Source | Sequence[Source] = (),
        order: Literal[2, 4] = 2,
        name: str | None = None,
        *,
        absorbing: Absorbing | None = None,
    ) -> None:
        if not isinstance(grid, Grid):
            raise SceneError(f"Wave.grid: must be a Grid, got {shown(grid)}")
        differences = count(order, "Wave.order")
        if differences not in ORDERS:
            raise SceneError(f"Wave.order: must be 2 or 4, got {differences}")
        words, layer = grid.edges(edges, "Wave.edges", EDGES, "fixed", valued=True)
        if order == 4 and "absorbing" in words:
            raise SceneError("Wave.order: must be 2 beside absorbing edges, got 4")
        if order == 4 and any(isinstance(each, (Dirichlet, Neumann)) for each in words):
            raise SceneError("Wave.order: must be 2 beside edges with values, got 4")
        speeds = _checked(grid, speed, "Wave.speed")
        solid = None if walls is None else frozen(grid.mask(walls, "Wave.walls"))
        self._set(
            grid=grid,
            speed=speeds,
            displacement=grid.uniform_or_field(displacement, "Wave.displacement"),
            rate=grid.uniform_or_field(rate, "Wave.rate"),
            density=_checked(grid, density, "Wave.density", above=True),
            damping=_checked(grid, damping, "Wave.damping"),
            edges=words,
            walls=solid,
            sources=_sources(sources, grid, speeds, solid, differences),
            order=differences,
            name=None if name is None else text(name, "Wave.name"),
            absorbing=absorbing_layer(absorbing, layer, words, "Wave.absorbing"),
        )

    @property
    def units(self) -> Mapping[str, str]:
        """The units of displacement and rate."""
        return {"displacement": "m", "rate": "m/s"}

    def timed(self) -> Iterator[tuple[str, Callable[[float], object]]]:
        """The signals of sources, and the functions of edges."""
        for index, source in enumerate(self.sources):
            if callable(source.signal):
                yield f"sources[{index}].signal", source.signal
        yield from super().timed()

    @property
    def solid(self) -> BoolArray | None:
        """The walls."""
        return self.walls

    def unresolved(self, integrator: str) -> list[str]:
        """Notes on waves that the grid slows down: those of the initial field, and of the sources."""
        del integrator
        notes = []
        for name in ("displacement", "rate"):
            field = np.asarray(getattr(self, name))
            if field.ndim and (number := wave_number(field)) > 0.0:
                notes += note(f"{name} at the start", number, self._group_velocity, self.grid.spacing)
        for index, source in enumerate(self.sources):
            if (steepness := source.steepness(self.grid, self.speed)) > 0.0:
                own = angle(_sine(steepness, self.order))
                notes += note(f"sources[{index}]", own, self._group_velocity, self.grid.spacing, 2.0 * steepness)
        return notes

    def _group_velocity(self, number: float) -> float:
        """The group velocity over c of waves with k h = `number` along an axis, as steps become small."""
        square = float(np.square(sin(0.5 * number)))
        slope = float(cos(0.5 * number))
        return slope if self.order == 2 else slope * (1.0 + 2.0 / 3.0 * square) / math.sqrt(1.0 + square / 3.0)

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        return f"Wave({label}{' × '.join(map(str, self.grid.cells))} cells)"


def _sine(steepness: float, order: int) -> float:
    """The sine of k h/2 at ω h/2c = `steepness`, by the dispersion relation of the differences."""
    if order == 2:
        return steepness
    return math.sqrt(1.5 * (math.sqrt(1.0 + 4.0 / 3.0 * steepness * steepness) - 1.0))


def _checked(grid: Grid, value: Field, path: str, above: bool = False) -> float | FloatArray:
    """A field without negative values; with `above`, without zeros too."""
    field = grid.uniform_or_field(value, path)
    values = np.asarray(field)
    require(values > 0.0 if above else values >= 0.0, values, path, "> 0" if above else "≥ 0")
    return field


def _sources(
    given: object, grid: Grid, speed: float | FloatArray, walls: BoolArray | None, order: int
) -> tuple[Source, ...]:
    """Validated sources on a grid. Warns of those whose waves it cannot carry."""
    sources = [given] if isinstance(given, Source) else items(given, "Wave.sources", "sources")
    for index, source in enumerate(sources):
        if not isinstance(source, Source):
            raise SceneError(f"Wave.sources[{index}]: must be a Source, got {shown(source)}")
        source.check(grid, f"Wave.sources[{index}]")
        own = source.cells(grid)
        if walls is not None and own.any() and walls[own].all():
            raise SceneError(f"Wave.sources[{index}].where: is in the walls, where nothing moves")
        steepness, most = source.steepness(grid, speed), STEEPEST[order]
        if steepness > most:
            warn(
                f"Wave.sources[{index}]: its waves have {math.pi / steepness:.2g} cells in a wavelength, and none "
                f"shorter than {math.pi / most:.2g} travel on a grid; "
                f"take a spacing of {0.2 * grid.spacing / steepness:.2g} m",
                SceneWarning,
            )
    return tuple(sources)


def _where(value: ArrayLike) -> tuple[float, ...] | BoolArray | FloatArray:
    """A point, or the weights of cells. Up to three numbers in one dimension are a point."""
    given = regular(value, "Source.where")
    if given.dtype.kind == "b":
        if given.ndim not in (1, 2, 3):
            raise SceneError(
                f"Source.where: must be a point or a mask of the grid's shape, got the shape {given.shape}"
            )
        return frozen(np.array(given))
    numbers = np.atleast_1d(array(value, "Source.where"))
    if numbers.ndim == 1 and len(numbers) <= len(AXES):
        return tuple(numbers.tolist())
    return frozen(numbers)
