"""The time labels of films: units of time, dates, and the simulated time per second of the film."""

from __future__ import annotations

from datetime import date, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import physcore as pc
from physcore.film.labels.clock import Clock, check_unit
from physcore.film.labels.dates import check_start
from physcore.film.labels.scale_bar import rounded

ASTRONOMICAL = pc.units.system(length="AU", time="d", mass="M☉")
OWN = pc.units.system(length=(2.0, "ell"), time=(0.5, "tau"))
BARE = pc.units.dimensionless
NEW_YEAR = datetime(2026, 1, 1)


def clock(units: pc.units.UnitSystem, interval: float, frames: int = 11, start: Any = None, **options: Any) -> Clock:
    """The clock of a film of 25 frames per second, with this time between frames."""
    times = interval * np.arange(frames)
    begin = check_start(start, units)
    return Clock(times, 1.0 / interval, options.get("rate", 25.0), options.get("unit"), units, begin)


@pytest.mark.parametrize(
    ("units", "interval", "unit", "text", "pace"),
    [
        (pc.units.SI, 0.04, None, "0.40 s", ""),
        (pc.units.SI, 0.016, None, "0.16 s", "2.5 × slower"),
        (pc.units.SI, 40e-6, None, "400.00 µs", "1000 × slower"),
        (pc.units.SI, 20e-6, None, "200.00 µs", "1 s = 500 µs"),
        (pc.units.SI, 0.4, None, "4.00 s", "10 × faster"),
        (pc.units.SI, 60.0, None, "10 min", "1 s = 25 min"),
        (pc.units.SI, 86400.0 * 3.6, None, "36 d", "1 s = 90 d"),
        (ASTRONOMICAL, 6020.0, None, "60200 d", "1 s = 150000 d"),
        (ASTRONOMICAL, 3.6, None, "36 d", "1 s = 90 d"),
        (ASTRONOMICAL, 0.01, None, "0.10 d", "1 s = 0.25 d"),
        (ASTRONOMICAL, 365.25, "yr", "10 yr", "1 s = 25 yr"),
        (OWN, 0.1, None, "1.00 tau", "1.25 × faster"),
        (OWN, 0.1, "s", "0.50 s", "1.25 × faster"),
        (OWN, 0.08, None, "0.80 tau", ""),
        (BARE, 0.1, None, "t = 1.00", ""),
        (BARE, 0.04, None, "t = 0.40", ""),
        (BARE, 100.7, None, "t = 1007.00", ""),
    ],
)
def test_time_is_in_the_unit_of_the_scene_or_as_asked(units, interval, unit, text, pace):
    made = clock(units, interval, unit=unit)
    assert made.text(made.times[10]) == text
    assert made.pace == pace


@pytest.mark.parametrize(
    ("start", "units", "interval", "text"),
    [
        ("2026-01-01", ASTRONOMICAL, 1.0, "2026-01-11"),
        ("2026-01-01", ASTRONOMICAL, 1.5, "2026-01-16"),
        (date(2026, 1, 1), ASTRONOMICAL, 0.5, "2026-01-06 00:00"),
        (NEW_YEAR, ASTRONOMICAL, 1.0 / 24.0, "2026-01-01 10:00"),
        ("2026-01-01 12:00", ASTRONOMICAL, 1.0 / 1440.0, "2026-01-01 12:10"),
        ("2026-01-01T12:00:30", pc.units.SI, 1.0, "2026-01-01 12:00:40"),
        ("2026-01-01", pc.units.SI, 0.04, "2026-01-01 00:00:00.400"),
        ("2026-01-01", pc.units.SI, 1e-6, "2026-01-01 00:00:00.000010"),
        ("2026-01-01", OWN, 2.0 * 86400.0, "2026-01-11"),
        ("2024-02-28", ASTRONOMICAL, 0.2, "2024-03-01 00:00"),
        ("2026-01-01T00:00Z", ASTRONOMICAL, 0.5, "2026-01-06 00:00 UTC"),
        (datetime(2026, 1, 1, tzinfo=timezone(timedelta(hours=2))), ASTRONOMICAL, 0.5, "2026-01-06 00:00+02:00"),
    ],
)
def test_dates_are_as_detailed_as_the_frames_require(start, units, interval, text):
    made = clock(units, interval, start=start)
    assert made.text(made.times[10]) == text


@given(st.integers(1, 1000), st.integers(1, 400))
@example(75, 3)  # whose time is 224.99999999999997 d
@example(600, 95)  # whose time is 0.6 µs before the day
def test_days_are_counted_without_rounding(days, frames):
    # k/fps for 1/fps days may be a rounding error less than a whole day, which would show the day before.
    fps = 1.0 / days
    made = Clock(np.arange(frames + 1) / fps, fps, 25.0, None, ASTRONOMICAL, NEW_YEAR)
    assert made.text(made.times[frames]) == (NEW_YEAR + timedelta(days=days * frames)).date().isoformat()


@pytest.mark.parametrize(
    "start", ["2026-13-01", "soon", "", 2026, 1.5, True, ("2026",), np.datetime64("2026-01-01"), b"2026"]
)
def test_what_is_no_date_is_refused(start, tmp_path: Path):
    recording = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]])), 0.1)
    with pytest.raises(pc.SceneError, match="start: must be a date such as"):
        pc.film(recording, tmp_path / "film.gif", start=start)


@pytest.mark.parametrize(("start", "days"), [("9999-12-31", 2.0), ("2026-01-01", 1e7), ("2026-01-01", 1e300)])
def test_dates_beyond_the_calendar_are_refused(start, days):
    with pytest.raises(pc.SceneError, match=r"start: must leave all frames in the years 1 to 9999, got .* d after"):
        clock(ASTRONOMICAL, days, 2, start)


def test_a_scene_without_units_has_no_dates_and_no_other_units(tmp_path: Path):
    recording = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]]), units=BARE), 0.1)
    for options in ({"start": "2026-01-01"}, {"time_unit": "d"}, {"scale_bar": "km"}):
        with pytest.raises(pc.SceneError, match=f"{next(iter(options))}: must be .* for a scene without units"):
            pc.film(recording, tmp_path / "film.gif", **options)  # type: ignore[arg-type]
    assert check_unit("tau", OWN) == "tau"
    with pytest.raises(pc.SceneError, match="time_unit"):
        check_unit("tau", ASTRONOMICAL)


def test_a_film_has_dates(tmp_path: Path):
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]]), units=ASTRONOMICAL)
    pictures = []
    for start in (None, "2026-01-01", date(2026, 1, 1)):
        path = tmp_path / "film.gif"
        film = pc.film(scene, path, duration=4.0, fps=1.0, speed=20.0, start=start, size=(160, 120))
        assert film.frames == 5
        pictures.append(path.read_bytes())
    assert pictures[0] != pictures[1] == pictures[2]


@pytest.mark.parametrize(
    ("most", "unit", "units", "words", "length"),
    [
        (7.0, None, ASTRONOMICAL, "5 AU", 5.0),
        (7.0e-6, None, ASTRONOMICAL, "5 · 10⁻⁶ AU", 5.0e-6),
        (1.0, "km", ASTRONOMICAL, "10⁸ km", 1e11 / pc.units.AU),
        (3.0, None, OWN, "2 ell", 2.0),
        (3.0, "m", OWN, "5 m", 2.5),
        (3.0, None, BARE, "2", 2.0),
    ],
)
def test_a_scale_bar_is_in_the_unit_of_the_scene_or_as_asked(most, unit, units, words, length):
    found, text = rounded(most, unit, units)
    assert text == words
    assert abs(found / length - 1.0) < 1e-12
