"""Dates as the time labels of a film."""

from __future__ import annotations

import sys
from datetime import date, datetime, timedelta, timezone
from typing import Literal, TypeAlias

from physcore.checks import FloatArray, shown
from physcore.errors import SceneError
from physcore.units.constants import day, minute
from physcore.units.systems import UnitSystem

Start: TypeAlias = datetime
"""Date and time at the time 0 of a scene."""
Resolution: TypeAlias = Literal["days", "minutes", "seconds", "milliseconds", "microseconds"]
RESOLUTIONS: tuple[tuple[Resolution, float], ...] = (
    ("days", day),
    ("minutes", minute),
    ("seconds", 1.0),
    ("milliseconds", 1e-3),
)
"""Resolutions of labels and their least frame intervals [s]; the finest resolution is a microsecond."""

ROUNDING = 4.0 * sys.float_info.epsilon
"""Relative error of times: they are quotients, in a unit that is itself rounded."""
WHOLE = 2.0**53
"""Number from which on each number is whole."""


def check_start(start: object, units: UnitSystem) -> Start | None:
    """The date at the time 0, from a date, a datetime or an ISO 8601 text; None without one.

    Raises:
        SceneError: the value is none of these, or the scene is without units.
    """
    if start is None:
        return None
    if units.is_dimensionless:
        raise SceneError(f"start: must be None for a scene without units, which has no days, got {shown(start)}")
    found = start
    if isinstance(start, str):
        try:
            found = datetime.fromisoformat(start)
        except ValueError:
            found = None
    if isinstance(found, date) and not isinstance(found, datetime):
        found = datetime(found.year, found.month, found.day)
    if not isinstance(found, datetime) or found != found:  # pandas.NaT is no time
        raise SceneError(
            'start: must be a date such as "2026-01-01" or "2026-01-01 12:00", a datetime.date or a datetime.datetime, '
            f"got {shown(start)}"
        )
    offset = found.utcoffset()
    return found if offset is None else found.replace(tzinfo=timezone(offset))


class Calendar:
    """Dates of frames, as detailed as the interval of the frames requires.

    Args:
        start: the date at the time 0.
        times: times of the frames, in the unit of the scene.
        interval: time between two frames.
        units: the units of the scene.

    Raises:
        SceneError: a frame is before the year 1 or after the year 9999.
    """

    def __init__(self, start: Start, times: FloatArray, interval: float, units: UnitSystem) -> None:
        self._start, self._seconds = start, units.time.value or 1.0
        seconds = interval * self._seconds * (1.0 + 1e-9)
        self._resolution = next((name for name, least in RESOLUTIONS if seconds >= least), "microseconds")
        for time in times[[0, -1]].tolist():
            try:
                self._at(time)
            except OverflowError:
                reached = f"{time:g}{units.suffix('s')} after {start}"
                raise SceneError(f"start: must leave all frames in the years 1 to 9999, got {reached}") from None

    def text(self, time: float) -> str:
        """The date at a time: "2026-01-31", or "2026-01-31 12:30" where frames are less than a day apart."""
        moment = self._at(time)
        if self._resolution == "days":
            return moment.date().isoformat()
        return moment.isoformat(" ", self._resolution).replace("+00:00", " UTC")

    def _at(self, time: float) -> datetime:
        """The moment at a time, to a microsecond. A time that is a whole second but for rounding is taken as one."""
        seconds = float(time) * self._seconds
        if abs(seconds) < WHOLE and abs(seconds - round(seconds)) <= ROUNDING * abs(seconds):
            seconds = round(seconds)
        return self._start + timedelta(seconds=seconds)
