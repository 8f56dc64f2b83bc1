"""Clock of the studies, for planning and measuring."""

from __future__ import annotations

import time


def seconds() -> float:
    """The time since an arbitrary start [s]."""
    return time.perf_counter()
