"""A progress bar on standard error: drawn in place on a terminal, a line for every quarter elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Self

WIDTH = 32
PATIENCE = 1.0
"""Work that ends within this many seconds shows no bar, unless one is asked for."""


class Progress:
    """Shows how much of `total` is done.

    Args:
        total: how much there is to do.
        label: what is being done.
        show: True: always; False: never; None: only on a terminal, and only if it takes longer than a second.
    """

    def __init__(self, total: int, label: str, show: bool | None = None) -> None:
        self._total = max(total, 1)
        self._label = label
        self._terminal = sys.stderr.isatty()
        self._shown = self._terminal if show is None else show
        self._start = time.monotonic()
        self._visible_from = self._start + (PATIENCE if show is None else 0.0)
        self._last = -1
        self._drawn = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._drawn and self._terminal:
            sys.stderr.write("\n")
            sys.stderr.flush()

    def update(self, done: int) -> None:
        """Say that `done` of the total is done."""
        now = time.monotonic()
        if not self._shown or now < self._visible_from:
            return
        percent = 100 * done // self._total
        mark = percent if self._terminal else percent // 25 * 25
        if mark == self._last:
            return
        self._last, self._drawn = mark, True
        sys.stderr.write(self._bar(done / self._total, now) if self._terminal else f"{self._label}: {mark} %\n")
        sys.stderr.flush()

    def _bar(self, fraction: float, now: float) -> str:
        """The bar with the time that is left, to be drawn over the last one."""
        filled = round(WIDTH * fraction)
        left = (now - self._start) * (1.0 - fraction) / fraction if fraction > 0 else 0.0
        bar = "█" * filled + "·" * (WIDTH - filled)
        return f"\r{self._label}  {bar} {fraction:4.0%}  {left:4.0f} s left "
