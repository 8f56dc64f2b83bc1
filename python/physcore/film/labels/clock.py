"""The clock of a film: the time in a unit that suits the motion, and the simulated time per second of the film."""

from __future__ import annotations

import math

from physcore.checks import FloatArray, word
from physcore.film.labels.text import FIGURE_SPACE
from physcore.units import day, hour, minute, year

UNITS = {
    "fs": 1e-15,
    "ps": 1e-12,
    "ns": 1e-9,
    "µs": 1e-6,
    "ms": 1e-3,
    "s": 1.0,
    "min": minute,
    "h": hour,
    "d": day,
    "yr": year,
    "kyr": 1e3 * year,
    "Myr": 1e6 * year,
    "Gyr": 1e9 * year,
}
"""Units of time by symbol [s]."""
LEAST = 2.0
"""A unit is chosen if the film lasts at least this many of it."""
SHORTEST = 0.1
"""Seconds are chosen for films of at least this duration [s]."""


def check_unit(unit: object) -> str | None:
    """The requested unit of time.

    Raises:
        SceneError: there is no such unit.
    """
    return None if unit is None else word(unit, "time_unit", (*UNITS,))


class Clock:
    """The time labels of a film.

    Args:
        times: times of the frames [s].
        fps: frames per second of the simulation, which determine the number of decimals.
        rate: frames per second of the film.
        unit: a key of UNITS; None: a unit that suits the duration.
    """

    def __init__(self, times: FloatArray, fps: float, rate: float, unit: str | None) -> None:
        self.times = times
        self.unit = unit or _suitable(float(abs(times[-1] - times[0])))
        self._seconds, self._pace = UNITS[self.unit], rate / fps
        # Enough decimals to change with each frame, but at most 2 for minutes and longer units.
        step = 1.0 / (fps * self._seconds)
        most = 2 if self._seconds >= minute else 6
        self._decimals = min(max(2 if self._seconds < minute else 0, math.ceil(-math.log10(step) - 1e-9)), most)
        self._width = max((len(self._number(time)) for time in times[[0, -1]].tolist()), default=0)

    def text(self, frame: int) -> str:
        """The time at a frame as text of constant width."""
        return f"{self._number(self.times[frame]).rjust(self._width, FIGURE_SPACE)} {self.unit}"

    @property
    def pace(self) -> str:
        """The simulated time per second of the film, such as "1 s = 90 d"; empty in real time."""
        per_second = self._pace
        if abs(per_second - 1.0) < 0.01:
            return ""
        unit = self.unit if 0.01 <= per_second / UNITS[self.unit] < 1e4 else _suitable(2.0 * per_second)
        return f"1 s = {float(f'{per_second / UNITS[unit]:.3g}'):g} {unit}"

    def _number(self, time: float) -> str:
        return f"{time / self._seconds:.{self._decimals}f}"


def _suitable(duration: float) -> str:
    """The largest unit of which a duration [s] is at least LEAST; seconds for 0.1 s to 2 min."""
    if SHORTEST <= duration < LEAST * minute or duration == 0.0:
        return "s"
    suitable = [name for name, seconds in UNITS.items() if duration >= LEAST * seconds]
    return suitable[-1] if suitable else "fs"
