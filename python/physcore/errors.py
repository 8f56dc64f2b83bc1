"""Exceptions that say where, what was expected and what to do, and warnings."""

from __future__ import annotations

import sys
import warnings
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class PhyscoreError(Exception):
    """The base of every error that physcore raises on purpose.

        try:
            pc.load("missing.npz")
        except pc.PhyscoreError as error:
            print(error)

    SceneError, FileError, SimulationDiverged, AccuracyError and InternalError are below it.
    """


class SceneError(PhyscoreError, ValueError):
    """A scene or a numerical choice is not valid: the message starts with the path of the parameter.

        try:
            pc.Particles([[0.0, 0.0]], mass=-1.0)
        except pc.SceneError as error:
            print(error)  # Particles.mass[0]: must be > 0 …

    It is a ValueError too.
    """


class FileError(PhyscoreError, OSError):
    """A file cannot be read or written, is damaged, or is of another version.

        try:
            pc.load("missing.npz")
        except pc.FileError as error:
            print(error)

    It is an OSError too.
    """


class InternalError(PhyscoreError):
    """physcore broke a promise to itself; please report it with the script that led here.

        try:
            pc.simulate(scene, duration=0.1)
        except pc.InternalError as error:
            print("please report", error)

    A run that raises it stands at the last good step.
    """


class State(Protocol):
    """The state that an error gives; a `Snapshot` is one."""

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def positions(self) -> NDArray[np.float64]:
        """[m], shape (N, D); within the periodic domain."""

    @property
    def velocities(self) -> NDArray[np.float64]:
        """[m/s], shape (N, D)."""

    @property
    def densities(self) -> NDArray[np.float64]:
        """[kg/m³], shape (N,), where there is a fluid."""

    @property
    def pressures(self) -> NDArray[np.float64]:
        """[Pa], shape (N,), where there is a fluid."""


class SimulationDiverged(PhyscoreError, ArithmeticError):
    """The simulation blew up, and stands at the last good state.

        try:
            pc.simulate(scene, duration=5.0, dt=0.1)
        except pc.SimulationDiverged as error:
            print(error.hint, error.last_good.positions.max())

    Attributes:
        step: the step that failed, counted from 1.
        time: the time at which that step would have ended [s].
        particle: index of the particle, or other element, that was caught, in scene order.
        element: its name, such as "particle 3".
        quantity: what went wrong there ("position", "velocity", "energy").
        cause: one sentence on why.
        hint: what to change, with a time step that would hold.
        last_good: a Snapshot, the state before the failed step; finite, not necessarily accurate.
    """

    def __init__(
        self,
        message: str,
        *,
        step: int,
        time: float,
        particle: int,
        element: str,
        quantity: str,
        cause: str,
        hint: str,
        last_good: State | None = None,
    ) -> None:
        super().__init__(message)
        self.step = step
        self.time = time
        self.particle = particle
        self.element = element
        self.quantity = quantity
        self.cause = cause
        self.hint = hint
        self.last_good = last_good

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle with the attributes, so that the error survives the way out of a worker process."""
        return _rebuild_divergence, (str(self), dict(self.__dict__))


class AccuracyError(PhyscoreError, ArithmeticError):
    """No method computes a scene as accurately as was asked for.

        try:
            pc.simulate(scene, duration=0.1, accuracy=1e-18)
        except pc.AccuracyError as error:
            print(error.error)  # how near it came [m]

    Attributes:
        error: the smallest error that was reached [m]; inf where everything diverged.
        energy_drift: the drift of the energy balance of that run.
    """

    def __init__(self, message: str, *, error: float, energy_drift: float) -> None:
        super().__init__(message)
        self.error = error
        self.energy_drift = energy_drift

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle with the attributes."""
        return _rebuild_inaccuracy, (str(self), self.error, self.energy_drift)


def _rebuild_inaccuracy(message: str, error: float, energy_drift: float) -> AccuracyError:
    return AccuracyError(message, error=error, energy_drift=energy_drift)


def _rebuild_divergence(message: str, attributes: dict[str, object]) -> SimulationDiverged:
    return SimulationDiverged(message, **attributes)  # type: ignore[arg-type]


class StabilityWarning(UserWarning):
    """The time step is above the limit of stability, as far as that is certain, or it shows: a step failed, for one.

        import warnings
        warnings.simplefilter("error", pc.StabilityWarning)  # a step that is too long stops the script

    `stability_limit` gives the limit.
    """


class SceneWarning(UserWarning):
    """A scene says something that was hardly meant, such as charges that no force acts on, or 10⁸ steps for a second.

        import warnings
        warnings.simplefilter("ignore", pc.SceneWarning)

    The scene is simulated as it is.
    """


class MachWarning(UserWarning):
    """A fluid flows too fast for its speed of sound to pass for weakly compressible.

        import warnings
        warnings.simplefilter("error", pc.MachWarning)  # a fluid that is too fast stops the script

    A larger `sound_speed` cures it, in steps that are shorter by as much.
    """


def warn(message: str, category: type[Warning]) -> None:
    """Warn the first caller that is not physcore's own."""
    package = __name__.partition(".")[0]
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level + 1)
