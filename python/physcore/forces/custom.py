"""A force that the user writes as a NumPy function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.forces.base import Force


@dataclass(frozen=True)
class CustomForce(Force):
    """A force from a Python function. Slow, correct, and named in the plan.

    Args:
        function: `function(time, positions, velocities)` with the time [s] and arrays of shape (N, D) [m, m/s] of the
            particles that it acts on; gives the forces [N], shape (N, D). It must not change its arguments.
        potential: `potential(positions)`, the energy of those particles [J]; with it the force counts as conservative,
            without it what the force does counts as work.
        on: the body or bodies that it acts on; all by default.

    Raises:
        SceneError: `function` or `potential` cannot be called.
    """

    function: Callable[[float, FloatArray, FloatArray], FloatArray]
    potential: Callable[[FloatArray], float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not callable(self.function):
            raise SceneError(f"CustomForce.function: must be a function, got {self.function!r}")
        if self.potential is not None and not callable(self.potential):
            raise SceneError(f"CustomForce.potential: must be a function or None, got {self.potential!r}")
