"""The period of a motion, found from frames of a recording."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physcore.simulation.periods import period_of

TIMES = np.arange(200) / 30.0


@pytest.mark.parametrize("period", [0.73, 1.0, 2.41])
def test_the_period_is_found_between_frames(period: float) -> None:
    """A parabola through 4 sin²(ω τ/2) around its minimum: its error is of third order in the 1/30 s of a frame."""
    phase = 2.0 * math.pi * TIMES / period
    orbit = np.stack([np.cos(phase), 0.5 * np.sin(phase)], axis=1)[:, np.newaxis]
    assert period_of(TIMES, orbit, None) == pytest.approx(period, abs=2e-3)


def test_what_does_not_come_back_has_no_period() -> None:
    steady = np.stack([TIMES, 0.0 * TIMES], axis=1)[:, np.newaxis]
    assert period_of(TIMES, steady, None) is None
    assert period_of(TIMES, 0.0 * steady, None) is None
    decaying = np.exp(-TIMES)[:, np.newaxis, np.newaxis] * steady
    assert period_of(TIMES, decaying, None) is None
