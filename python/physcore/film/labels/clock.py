"""The clock of a film: the time in a unit that suits the motion, and the simulated time per second of the film."""

from __future__ import annotations

import math
from collections.abc import Mapping

from physcore.checks import FloatArray, shown, word
from physcore.errors import SceneError
from physcore.film.labels.dates import Calendar, Start
from physcore.film.labels.text import FIGURE_SPACE
from physcore.units.constants import minute
from physcore.units.symbols import SYMBOLS
from physcore.units.systems import SI, UnitSystem

UNITS = SYMBOLS["time"]
"""Units of time by symbol [s]."""
LEAST = 2.0
"""A unit is chosen if the film lasts at least this many of it."""
SHORTEST = 0.1
"""Seconds are chosen for films of at least this duration [s]."""

MOST = 1000.0
"""Largest number of times that a film is said to be slower or faster."""


def check_unit(unit: object, units: UnitSystem = SI) -> str | None:
    """The requested unit of time.

    Raises:
        SceneError: there is no such unit, or the scene is without units.
    """
    if unit is not None and units.is_dimensionless:
        raise SceneError(f"time_unit: must be None for a scene without units, got {shown(unit)}")
    return None if unit is None else word(unit, "time_unit", (*_known(units),))


class Clock:
    """The time labels of a film.

    Args:
        times: times of the frames, in the unit of the scene.
        fps: frames per unit of time of the scene, which determine the number of decimals.
        rate: frames per second of the film.
        unit: the symbol of the unit of the labels; None: that of the scene, or in the SI one that suits the duration.
        units: the units of the scene.
        start: the date at the time 0; the labels are dates then.
        paced: whether the pace is told.
    """

    def __init__(
        self,
        times: FloatArray,
        fps: float,
        rate: float,
        unit: str | None,
        units: UnitSystem = SI,
        start: Start | None = None,
        *,
        paced: bool = True,
    ) -> None:
        self.times, self._paced = times, paced
        self._units, self._chosen, own = units, units.is_si, _known(units)
        self.unit = unit or (_suitable(float(abs(times[-1] - times[0]))) if self._chosen else units.time.symbol)
        self._length, self._pace = own[self.unit], rate / fps
        self._calendar = None if start is None else Calendar(start, times, 1.0 / fps, units)
        # Enough decimals to change with each frame, but at most 2 for minutes and longer units.
        step, long = 1.0 / (fps * self._length), self._length * (units.time.value or 1.0) >= minute
        most = 2 if long else 6
        self._decimals = min(max(0 if long else 2, math.ceil(-math.log10(step) - 1e-9)), most)
        self._width = max((len(self._number(time)) for time in times[[0, -1]].tolist()), default=0)

    def text(self, time: float) -> str:
        """A time as text of constant width: with its unit, "t = 2.50" without units, or a date."""
        if self._calendar is not None:
            return self._calendar.text(time)
        number = self._number(time).rjust(self._width, FIGURE_SPACE)
        return f"{number} {self.unit}" if self.unit else f"t = {number}"

    @property
    def pace(self) -> str:
        """The simulated time per second of the film: "2.5 × slower", or "1 s = 90 d" where that is a larger number.
        Empty in real time and without units.
        """
        seconds = self._units.time.value
        if not self._paced or self._units.is_dimensionless or abs(self._pace * (seconds or 1.0) - 1.0) < 0.01:
            return ""
        factor = self._pace * (seconds or math.inf)
        if 1.0 / MOST <= factor <= MOST:
            slower = factor < 1.0
            return f"{float(f'{1.0 / factor if slower else factor:.3g}'):g} × {'slower' if slower else 'faster'}"
        in_own = not self._chosen or 0.01 <= self._pace / self._length < 1e4
        unit = self.unit if in_own else _suitable(2.0 * self._pace)
        return f"1 s = {float(f'{self._pace / _known(self._units)[unit]:.3g}'):g} {unit}"

    def _number(self, time: float) -> str:
        return f"{time / self._length:.{self._decimals}f}"


def _known(units: UnitSystem) -> Mapping[str, float]:
    """Units of time by symbol, in the unit of a scene; its own is among them."""
    own = units.time
    return {**({} if own.value is None else {name: each / own.value for name, each in UNITS.items()}), own.symbol: 1.0}


def _suitable(duration: float) -> str:
    """The largest unit of which a duration [s] is at least LEAST; seconds for 0.1 s to 2 min."""
    if SHORTEST <= duration < LEAST * minute or duration == 0.0:
        return "s"
    suitable = [name for name, seconds in UNITS.items() if duration >= LEAST * seconds]
    return suitable[-1] if suitable else "fs"
