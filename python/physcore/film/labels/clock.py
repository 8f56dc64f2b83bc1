"""The clock of a film: time in the unit of the motion, and how much of it passes in a second."""

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
"""Of time, by their signs [s]."""
LEAST = 2.0
"""A unit is taken for films of at least so many."""
SHORTEST = 0.1
"""Films of at least this many seconds are told in seconds."""


def check_unit(unit: object) -> str | None:
    """The unit that was asked for.

    Raises:
        SceneError: there is no such unit.
    """
    return None if unit is None else word(unit, "time_unit", (*UNITS,))


class Clock:
    """What is written of the time.

    Args:
        times: of the frames [s].
        fps: frames per second of the simulation, which say how many decimals the time has.
        rate: frames per second of the film.
        unit: a key of UNITS; None: as suits the duration.
    """

    def __init__(self, times: FloatArray, fps: float, rate: float, unit: str | None) -> None:
        self.times = times
        self.unit = unit or _suitable(float(abs(times[-1] - times[0])))
        self._seconds, self._pace = UNITS[self.unit], rate / fps
        # The time moves with each frame, but nobody reads the third decimal of a day.
        step = 1.0 / (fps * self._seconds)
        most = 2 if self._seconds >= minute else 6
        self._decimals = min(max(2 if self._seconds < minute else 0, math.ceil(-math.log10(step) - 1e-9)), most)
        self._width = max((len(self._number(time)) for time in times[[0, -1]].tolist()), default=0)

    def text(self, frame: int) -> str:
        """The time at a frame, always in the same width."""
        return f"{self._number(self.times[frame]).rjust(self._width, FIGURE_SPACE)} {self.unit}"

    @property
    def pace(self) -> str:
        """What passes in a second of the film, such as "1 s = 90 d"; empty in real time."""
        per_second = 1.0 / self._pace
        if abs(per_second - 1.0) < 0.01:
            return ""
        unit = self.unit if 0.01 <= per_second / UNITS[self.unit] < 1e4 else _suitable(2.0 * per_second)
        return f"1 s = {float(f'{per_second / UNITS[unit]:.3g}'):g} {unit}"

    def _number(self, time: float) -> str:
        return f"{time / self._seconds:.{self._decimals}f}"


def _suitable(duration: float) -> str:
    """The largest unit of which a duration [s] is some; seconds from a tenth up."""
    if SHORTEST <= duration < LEAST * minute or duration == 0.0:
        return "s"
    suitable = [name for name, seconds in UNITS.items() if duration >= LEAST * seconds]
    return suitable[-1] if suitable else "fs"
