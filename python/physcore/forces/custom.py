"""A force that the user writes as a NumPy function."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass

from physcore.checks import FloatArray, shown
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
        SceneError: `function` or `potential` cannot be called with these arguments.
    """

    function: Callable[[float, FloatArray, FloatArray], FloatArray]
    potential: Callable[[FloatArray], float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        _check(self.function, "function", "time", "positions", "velocities")
        if self.potential is not None:
            _check(self.potential, "potential", "positions")


def _check(function: object, field: str, *arguments: str) -> None:
    """A function that can be called with so many arguments, as far as Python can tell beforehand."""
    if not callable(function):
        raise SceneError(f"CustomForce.{field}: must be a function, got {shown(function)}")
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return  # Some functions that are not written in Python do not say what they take.
    try:
        signature.bind(*arguments)
    except TypeError as error:
        raise SceneError(
            f"CustomForce.{field}: must take ({', '.join(arguments)}), got a function of {signature} ({error})"
        ) from None
