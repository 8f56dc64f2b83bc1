"""A budget of seconds that runs from when it is made."""

from __future__ import annotations

from physcore.studies import clock


class Budget:
    """How many seconds are left of a number of them."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._start = clock.seconds()

    def spent(self) -> float:
        """[s]"""
        return clock.seconds() - self._start

    def left(self) -> float:
        """[s]; below 0 where more was spent than there was."""
        return self.seconds - self.spent()

    def share(self, fraction: float) -> Budget:
        """A fraction of what is left, as a budget of its own."""
        return Budget(max(0.0, fraction * self.left()))
