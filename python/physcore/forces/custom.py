"""Force given by a user's NumPy function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import FloatArray, misfit, shown
from physcore.errors import SceneError
from physcore.scene.items import Force


@dataclass(frozen=True)
class CustomForce(Force):
    """Force given by a Python function; slow, and named in the plan.

        swing = pc.CustomForce(lambda time, x, v: -4.0 * x, potential=lambda x: 2.0 * (x**2).sum())
        scene = pc.Scene(pc.Particles([[1.0, 0.0]]), swing)

    Args:
        function: `function(time, positions, velocities)`, with the time [s] and copies of the positions [m] and
            velocities [m/s], shape (N, D), of the particles that the force acts on. Returns the forces [N], shape (N,
            D), finite and real. Equal arguments must always give equal forces.
        potential: `potential(positions)`, the potential energy of these particles [J], one finite real number. With a
            potential the force counts as conservative; without one, its work counts as external work.
        on: the body or bodies that the force acts on; all by default.

    Limits of the time step:
        `dt="auto"`, `AdaptiveStep()` and `stability_limit` use the largest |eigenvalues| of M⁻¹ ∂F/∂x and M⁻¹ ∂F/∂v.
        Arnoldi's method finds them from differences of forces. They are exact to 1e-4 for a few particles, or for a
        force that is the same on all; otherwise they have a margin of 10 %. For matrices that are not symmetric, their
        norms are used, which are not smaller. A force that rotates velocities, as a magnetic field does, gets at least
        100 steps per rotation. The sign has no effect: a repulsive force limits the step as an attractive one does.

        One estimate takes at least 6 calls of the function, usually 10 to 30, and at most 130. With `dt="auto"` there
        is one estimate every 16 steps in small scenes and every 256 steps in large ones, with `AdaptiveStep()` one in
        every step. An estimate is for the present state. Until the next one, the stiffness may double. But a floor that
        nothing touches yet has no stiffness. For a force with a sudden onset, therefore give `dt`, or use
        `AdaptiveStep()`. At a kink the steeper side counts. A discontinuity, as in dry friction at rest, has no slope
        and does not count. A function whose values differ for equal arguments does not count either.

    Raises:
        SceneError: `function` or `potential` cannot be called with these arguments. In a run: a function raised an
            exception, which is the cause (`__cause__`), or what is no array of numbers. The message begins with
            `forces[i].function` or `forces[i].potential`, and the simulation is at the last good step. Exceptions that
            are not subclasses of `Exception`, such as that of `sys.exit()`, are passed on unchanged.
        SimulationDiverged: in a step: a value is not finite.
    """

    feels_charges: ClassVar[bool] = True
    is_shown: ClassVar[bool] = False

    @property
    def dissipates(self) -> bool:
        """Whether there is no potential."""
        return self.potential is None

    function: Callable[[float, FloatArray, FloatArray], FloatArray]
    potential: Callable[[FloatArray], float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        _check(self.function, "function", "time", "positions", "velocities")
        if self.potential is not None:
            _check(self.potential, "potential", "positions")


def _check(function: object, field: str, *arguments: str) -> None:
    """Check that a value is a function of these arguments, as far as its signature is known."""
    if not callable(function):
        raise SceneError(f"CustomForce.{field}: must be a function, got {shown(function)}")
    reason = misfit(function, *arguments)
    if reason is not None:
        raise SceneError(f"CustomForce.{field}: must take ({', '.join(arguments)}), got {reason}")
