"""Exceptions and warnings. Messages name the place, the expected value and the remedy."""

from __future__ import annotations

import sys
import warnings
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class PhyscoreError(Exception):
    """Base class of all errors that physcore raises on purpose.

        try:
            pc.load("missing.npz")
        except pc.PhyscoreError as error:
            print(error)

    Its subclasses are SceneError, FileError, SimulationDiverged, AccuracyError, WorkerError and InternalError.
    """


class SceneError(PhyscoreError, ValueError):
    """Invalid scene or numerical choice. The message begins with the path of the parameter.

        try:
            pc.Particles([[0.0, 0.0]], mass=-1.0)
        except pc.SceneError as error:
            print(error)  # Particles.mass[0]: must be > 0 …

    This class is a ValueError too.
    """


class FileError(PhyscoreError, OSError):
    """File that cannot be read or written, is damaged, or has another version.

        try:
            pc.load("missing.npz")
        except pc.FileError as error:
            print(error)

    This class is an OSError too.
    """


class InternalError(PhyscoreError):
    """Internal inconsistency of physcore. Please report it with the script that causes it.

        try:
            pc.simulate(scene, duration=0.1)
        except pc.InternalError as error:
            print("please report", error)

    After this error the simulation is at the last good step.
    """


class WorkerError(PhyscoreError, RuntimeError):
    """Worker process that died, or an executor that cannot run the points of a sweep.

        try:
            table = pc.sweep(lambda number: scene, {"number": [1, 2]}, 0.1, measure=len)
        except pc.WorkerError as error:
            table = error.table

    This class is a RuntimeError too.

    Attributes:
        table: the finished points of the sweep, a Sweep; None if there are none.
    """

    def __init__(self, message: str, *, table: Any = None) -> None:
        super().__init__(message)
        self.table = table


class State(Protocol):
    """State of the particles that an error provides; a `Snapshot` is one."""

    @property
    def time(self) -> float:
        """Time [s]."""

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions [m], shape (N, D); within the periodic domain."""

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities [m/s], shape (N, D)."""

    @property
    def densities(self) -> NDArray[np.float64]:
        """Mass densities [kg/m³], shape (N,), if there is a fluid."""

    @property
    def pressures(self) -> NDArray[np.float64]:
        """Pressures [Pa], shape (N,), if there is a fluid."""


class SimulationDiverged(PhyscoreError, ArithmeticError):
    """Divergence of a simulation, which then is at the last good state.

        try:
            pc.simulate(scene, duration=5.0, dt=0.1)
        except pc.SimulationDiverged as error:
            print(error.hint, error.last_good.positions.max())

    Attributes:
        step: number of the failed step, counted from 1.
        time: end of the failed step [s].
        particle: index of the particle, or other element, at which the failure was detected, in scene order.
        element: name of this element, such as "particle 3".
        quantity: the quantity that failed the check ("position", "velocity", "energy").
        cause: one sentence on the cause.
        hint: the remedy, with a time step that would be stable.
        last_good: Snapshot of the state before the failed step; finite, not necessarily accurate.
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
        """Pickle with the attributes, so that a worker process can pass on the error."""
        return _rebuild_divergence, (str(self), dict(self.__dict__))


class AccuracyError(PhyscoreError, ArithmeticError):
    """No method reaches the requested accuracy.

        try:
            pc.simulate(scene, duration=0.1, accuracy=1e-18)
        except pc.AccuracyError as error:
            print(error.error)  # how near it came [m]

    Attributes:
        error: the smallest error reached [m]; inf if every run diverged.
        energy_drift: relative drift of the energy balance in that run.
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
    """Time step above the limit of stability, as far as this limit is known, or with signs of instability.

        import warnings
        warnings.simplefilter("error", pc.StabilityWarning)  # a step that is too long stops the script

    A failed step is such a sign. `stability_limit` gives the limit.
    """


class SceneWarning(UserWarning):
    """Scene that is probably not as intended, such as charges without a force, or 10⁸ steps for one second.

        import warnings
        warnings.simplefilter("ignore", pc.SceneWarning)

    The simulation runs nevertheless, with the scene unchanged.
    """


class MachWarning(UserWarning):
    """Flow of a fluid at a Mach number too large for weak compressibility.

        import warnings
        warnings.simplefilter("error", pc.MachWarning)  # a fluid that is too fast stops the script

    A larger `sound_speed` lowers the Mach number. The time steps become shorter by the same factor.
    """


class FileWarning(UserWarning):
    """File of a cache or a sweep that is damaged or cannot be written. Its result is computed anew.

        import warnings
        warnings.simplefilter("error", pc.FileWarning)  # a damaged file stops the script

    The message has the path.
    """


def warn(message: str, category: type[Warning]) -> None:
    """Issue a warning, attributed to the innermost caller outside of physcore."""
    package = __name__.partition(".")[0]
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level + 1)
