"""The clock that studies plan and measure by."""

from __future__ import annotations

import time


def seconds() -> float:
    """The time since some moment [s]."""
    return time.perf_counter()
