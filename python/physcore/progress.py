"""Progress bar on standard error: drawn in place on a terminal and in a notebook, as occasional lines elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Self

WIDTH = 32
PATIENCE = 1.0
"""Time after which a bar appears, unless it is requested explicitly [s]."""
LINES = 10.0
"""Time between the lines of a log, in addition to one line for every quarter [s]."""
REDRAWN = 0.1
"""Time between two drawings of a bar [s]."""


class Progress:
    """Progress bar with the fraction done, and an estimate of the remaining time.

    Args:
        total: total amount of work.
        label: name of the work.
        show: True: always; False: never; None: only on a terminal or in a notebook, after one second.
    """

    def __init__(self, total: int, label: str, show: bool | None = None) -> None:
        self._total = max(total, 1)
        self._label = label
        self._in_place = sys.stderr.isatty() or in_notebook()
        self._shown = self._in_place if show is None else show
        self._start = time.monotonic()
        self._visible_from = self._start + (PATIENCE if show is None else 0.0)
        self._last, self._last_time = -1, -1.0
        self._drawn = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._drawn and self._in_place:
            sys.stderr.write("\n")
            sys.stderr.flush()

    def update(self, done: int) -> None:
        """Update the bar: `done` of the total is done."""
        now = time.monotonic()
        if not self._shown or now < self._visible_from or not self._due(done, now):
            return
        self._drawn, self._last_time = True, now
        fraction = done / self._total
        sys.stderr.write(self._bar(fraction, now) if self._in_place else self._line(fraction, now))
        sys.stderr.flush()

    def _due(self, done: int, now: float) -> bool:
        """Whether the bar has to be drawn again."""
        percent = 100 * done // self._total
        mark = percent if self._in_place else percent // 25
        waited = now - self._last_time if self._drawn else 0.0
        if mark == self._last and not (not self._in_place and waited >= LINES):
            return False
        if self._in_place and self._drawn and waited < REDRAWN and done < self._total:
            return False
        self._last = mark
        return True

    def _left(self, fraction: float, now: float) -> str:
        """The remaining time at the present speed, as text."""
        if fraction <= 0.0:
            return ""
        seconds = (now - self._start) * (1.0 - fraction) / fraction
        return f"{seconds:4.0f} s left" if seconds < 100.0 else f"{seconds / 60.0:4.0f} min left"

    def _line(self, fraction: float, now: float) -> str:
        """A line for a log."""
        left = self._left(fraction, now).strip() if 0.0 < fraction < 1.0 else ""
        return f"{self._label}: {100 * fraction:.0f} %{', ' + left if left else ''}\n"

    def _bar(self, fraction: float, now: float) -> str:
        """The bar with the remaining time, to be drawn over the previous one."""
        filled = round(WIDTH * fraction)
        bar = "█" * filled + "·" * (WIDTH - filled)
        return f"\r{self._label}  {bar} {fraction:4.0%}  {self._left(fraction, now):<13}"


def in_notebook() -> bool:
    """Whether this process is a notebook, where a carriage return overwrites the last line too."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is not None and hasattr(shell, "kernel")
