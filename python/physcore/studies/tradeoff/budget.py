"""Time budget, which starts at its creation."""

from __future__ import annotations

from physcore.studies import clock


class Budget:
    """Time budget [s]."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._start = clock.seconds()

    def spent(self) -> float:
        """The time spent [s]."""
        return clock.seconds() - self._start

    def left(self) -> float:
        """The remaining time [s]; negative if more was spent."""
        return self.seconds - self.spent()

    def share(self, fraction: float) -> Budget:
        """A fraction of the remaining time, as a separate budget."""
        return Budget(max(0.0, fraction * self.left()))
