"""A force that the user writes as a NumPy function."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import FloatArray, shown
from physcore.errors import SceneError
from physcore.scene.items import Force


@dataclass(frozen=True)
class CustomForce(Force):
    """A force from a Python function. Slow, correct, and named in the plan.

        swing = pc.CustomForce(lambda time, x, v: -4.0 * x, potential=lambda x: 2.0 * (x**2).sum())
        scene = pc.Scene(pc.Particles([[1.0, 0.0]]), swing)

    Args:
        function: `function(time, positions, velocities)` with the time [s] and arrays of shape (N, D) [m, m/s] of the
            particles that it acts on, which are copies; gives the forces [N], shape (N, D), finite and real. The same
            arguments must always give the same forces.
        potential: `potential(positions)`, the energy of those particles [J], one finite real number; with it the force
            counts as conservative, without it what the force does counts as work.
        on: the body or bodies that it acts on; all by default.

    Limits of the time step:
        With `dt="auto"`, with `AdaptiveStep()` and in `stability_limit` the largest |eigenvalues| of M⁻¹ ∂F/∂x and of
        M⁻¹ ∂F/∂v are found from differences of forces, by Arnoldi's method: exactly, up to 1e-4, for a few particles or
        a force that is the same on all, and elsewhere with a margin of 10 %. Where these matrices are not symmetric
        their norms count, which are not smaller. A force that turns velocities, as a magnetic field does, gets at least
        a hundred steps for a turn. The sign does not count: a force that drives particles apart limits the step as one
        that holds them.

        A look takes 6 calls of the function at the least, 10 to 30 as a rule and 130 at most: with `dt="auto"` one look
        every 256 steps, with `AdaptiveStep()` one in every step. It sees the force as it is then. From one look to the
        next the stiffness may double; but a floor that nothing touches yet is not stiff at all, so give a `dt`, or take
        `AdaptiveStep()`, where a force sets in suddenly. At a kink the steeper side counts. A
        jump, as in dry friction at rest, has no slope and does not count, nor does a function that gives other
        values for the same arguments.

    Raises:
        SceneError: `function` or `potential` cannot be called with these arguments. In a run: it raised an exception,
            which is the cause (`__cause__`), or gave something else; the message starts with `forces[i].function` or
            `forces[i].potential`, and the simulation stands at the last good step. What is no `Exception`, such as that
            of `sys.exit()`, passes as it is.
    """

    feels_charges: ClassVar[bool] = True

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
