"""Contents of diagrams: the energy, or curves that a function computes from a recording."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

import numpy as np

from physcore.arithmetic import log
from physcore.checks import FloatArray, array, called, flag, is_word, misfit, shown
from physcore.errors import SceneError
from physcore.film.labels.heading import line_of
from physcore.film.labels.scale_bar import SUPERSCRIPTS
from physcore.film.labels.text import ends
from physcore.simulation.energy import Energy
from physcore.simulation.sources import Recorded, Source
from physcore.units.systems import UnitSystem

MOST = 4
"""Largest number of diagrams."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Diagram of a quantity that a function computes from a recording, for `inset=` of a film.

        speed = pc.Curve(lambda recording: abs(recording.velocities).max(axis=(1, 2)), "speed", unit="m/s")
        pc.film(recording, "run.gif", inset=[speed, "energy"])

    Args:
        function: `function(recording)` returns one value for each frame, shape (F,): a curve that grows as the film
            plays. A mapping of names to such arrays gives several curves. With `against`, it returns the values of a
            whole curve for each frame, shape (F, K), such as a spectrum.
        label: the name of the quantity.
        unit: the unit of the values.
        against: abscissas of the values in each frame, shape (K,), ascending.
        axis: the name of the abscissas, such as "frequency [Hz]".
        logarithmic: whether the vertical axis is logarithmic. Values that are not positive are left out.

    Raises:
        SceneError: an argument is not valid.
    """

    function: Callable[[Any], object]
    label: str = ""
    unit: str = ""
    against: FloatArray | Sequence[float] | None = None
    axis: str = ""
    logarithmic: bool = False

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise SceneError(f"Curve.function: must be a function of the recording, got {shown(self.function)}")
        if wrong := misfit(self.function, "recording"):
            raise SceneError(f"Curve.function: {wrong}")
        for name in ("label", "unit", "axis"):
            line_of(getattr(self, name), f"Curve.{name}")
        flag(self.logarithmic, "Curve.logarithmic")
        if self.against is not None:
            places = array(self.against, "Curve.against")
            if places.ndim != 1 or len(places) < 2 or not (np.diff(places) > 0.0).all():
                raise SceneError(f"Curve.against: must be two or more ascending numbers, got {shown(self.against)}")
            object.__setattr__(self, "against", places)

    def values(self, recording: object, frames: int, path: str) -> tuple[tuple[str, ...], FloatArray]:
        """The names of the curves and their values of a recording: (C, F), or (F, K) with `against`.

        Raises:
            SceneError: the function failed, or its result has another shape.
        """
        found = called(self.function, f"{path}.function", recording)
        if self.against is not None:
            return (), self._shaped(found, (frames, len(self.against)), f"{path}.function")
        several = found if isinstance(found, Mapping) else {"": found}
        if not several:
            raise SceneError(f"{path}.function: must return values, got an empty mapping")
        curves = [
            self._shaped(each, (frames,), f"{path}.function" + (f"[{name!r}]" if name else ""))
            for name, each in several.items()
        ]
        names = tuple(line_of(name, f"{path}.function") for name in several)
        return () if names == ("",) else names, np.stack(curves)

    def _shaped(self, found: object, shape: tuple[int, ...], path: str) -> FloatArray:
        values = array(found, path)
        if values.shape == shape:
            return values
        asked = "one value for each frame" + ("" if len(shape) == 1 else " and each abscissa of `against`")
        cure = ""
        if self.against is None and values.ndim == 2 and values.shape[0] == shape[0]:
            cure = (
                "; take one column, return a mapping of names to columns, or give `against` for a curve in each frame"
            )
        elif values.ndim == len(shape) and abs(values.shape[0] - shape[0]) == 1:
            cure = "; np.gradient gives as many values as there are frames, np.diff one fewer"
        raise SceneError(f"{path}: must return {asked}, shape {shape}, got {values.shape}{cure}")


Inset: TypeAlias = Literal["energy"] | Curve
"""Diagram in a picture."""


@dataclass(frozen=True, eq=False)
class Graph:
    """Curves of all panels on common axes."""

    label: str
    unit: str
    names: tuple[str, ...]
    """Names of the curves; empty for a single one."""
    places: Sequence[FloatArray]
    """Abscissas of each panel: times of the frames from the first one (F,), or those in each frame (K,)."""
    values: Sequence[FloatArray]
    """Values of each panel: (C, F), or with `anew` (F, K)."""
    across: tuple[float, float]
    """Ends of the horizontal axis."""
    anew: bool = False
    """Whether each frame has a whole curve of its own."""
    axis: str = ""
    """Name of the horizontal axis."""
    logarithmic: bool = False
    """Whether the values are decimal logarithms."""
    total: bool = False
    """Whether the last curve is the sum of the others, and zero is on the axis."""

    @property
    def range(self) -> tuple[float, float]:
        """The least and the largest value of all panels; whole decades if they are logarithms."""
        every = np.concatenate([each.ravel() for each in self.values])
        finite = every[np.isfinite(every)]
        if self.logarithmic:
            low = math.floor(finite.min() + 1e-9)
            return float(low), float(max(math.ceil(finite.max() - 1e-9), low + 1))
        if self.total:
            return min(float(finite.min(initial=0.0)), 0.0), max(float(finite.max(initial=0.0)), 0.0)
        return float(finite.min()), float(finite.max())

    @property
    def ends(self) -> tuple[str, str]:
        """The ends of the vertical axis as text."""
        low, high = self.range
        if not self.logarithmic:
            return ends(low, high)
        first, last = (_power(round(each)) for each in (low, high))
        return first, last


def _power(exponent: int) -> str:
    """A power of ten: 0.01, 1 or 10⁵."""
    return f"{10.0**exponent:g}" if -3 < exponent < 4 else f"10{str(exponent).translate(SUPERSCRIPTS)}"


def _logarithms(values: FloatArray) -> FloatArray:
    """Decimal logarithms; not a number where a value is not positive."""
    positive = values > 0.0
    return np.where(positive, log(np.where(positive, values, 1.0)) / math.log(10.0), np.nan)


def energy_graph(energies: Sequence[Sequence[Energy]], duration: float, units: UnitSystem) -> Graph:
    """The energies of all panels, frame by frame; internal energy only if it is not zero."""
    internal = any(energy.internal != 0.0 for panel in energies for energy in panel)
    names = ("kinetic", "potential", *(["internal"] if internal else []), "total")
    values = [np.array([[getattr(energy, name) for energy in panel] for name in names]) for panel in energies]
    times = [np.array([energy.time for energy in panel]) for panel in energies]
    places = [each - each[:1] for each in times]
    return Graph("energy", units.suffix("J").strip(), names, places, values, (0.0, duration), total=True)


def check_inset(inset: object, found: Sequence[Source]) -> tuple[Literal["energy"] | Graph, ...]:
    """The requested diagrams; curves are computed.

    Raises:
        SceneError: there is no such diagram, its energies were not recorded, or a curve does not fit the frames.
    """
    if inset is None:
        return ()
    several = isinstance(inset, (list, tuple))
    asked = list(cast("Sequence[object]", inset)) if several else [inset]
    if len(asked) > MOST:
        raise SceneError(f"inset: must be at most {MOST} diagrams, got {len(asked)}")
    result: list[Literal["energy"] | Graph] = []
    for index, each in enumerate(asked):
        path = f"inset[{index}]" if several else "inset"
        if isinstance(each, Curve):
            result.append(_graph_of(each, found, path))
        elif is_word(each, "energy"):
            if not all(source.audited for source in found):
                raise SceneError(
                    f"{path}: 'energy' is known of a Scene and of what simulate(…) gives, and of nothing else"
                )
            result.append("energy")
        else:
            raise SceneError(f"{path}: must be 'energy', a Curve, several of these or None, got {shown(each)}")
    return tuple(result)


def _graph_of(curve: Curve, found: Sequence[Source], path: str) -> Graph:
    """The graph of a curve of all sources."""
    recorded = [source.recording for source in found if isinstance(source, Recorded)]
    if len(recorded) < len(found):
        raise SceneError(
            f"{path}: a Curve is computed from a recording; film what simulate(…) gives instead of a scene"
        )
    computed = [curve.values(one, source.count, path) for one, source in zip(recorded, found, strict=True)]
    names, values = computed[0][0], [each for _, each in computed]
    if any(other != names for other, _ in computed):
        raise SceneError(f"{path}.function: must return the same names for all recordings")
    if curve.logarithmic:
        values = [_logarithms(each) for each in values]
        if not any(np.isfinite(each).any() for each in values):
            raise SceneError(f"{path}.function: must return a positive value for a logarithmic axis")
    if curve.against is not None:
        places = np.asarray(curve.against)
        across, every = (float(places[0]), float(places[-1])), [places] * len(found)
    else:
        every = [source.times - source.times[0] for source in found]
        across = 0.0, max(float(times[-1]) for times in every)
    anew = curve.against is not None
    return Graph(curve.label, curve.unit, names, every, values, across, anew, curve.axis, curve.logarithmic)
