"""Task: one point of a sweep, with its outcome as plain values that can be sent from one process to another."""

from __future__ import annotations

import builtins
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from physcore import errors
from physcore.checks import shown
from physcore.errors import PhyscoreError, SceneError, SimulationDiverged
from physcore.numerics.choices import Options
from physcore.scene.scene import Scene
from physcore.simulation.cache import scene_hash
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.storage import archive
from physcore.storage.archive import Tree

DIVERGED = ("step", "time", "particle", "element", "quantity", "cause", "hint")
"""Attributes of a SimulationDiverged that are plain values."""


@dataclass(frozen=True)
class Failure:
    """Exception as plain values."""

    kind: str
    """Name of its class."""
    arguments: tuple[Any, ...]
    attributes: dict[str, Any]
    trace: str
    """Traceback; empty for errors of physcore, whose messages suffice."""
    lasting: bool
    """Whether the point would fail again after a long time: the simulation diverged."""

    @classmethod
    def of(cls, error: Exception) -> Failure:
        """An exception as plain values."""
        diverged = isinstance(error, SimulationDiverged)
        plain = all(isinstance(each, (str, int, float, type(None))) for each in error.args)
        return cls(
            kind=type(error).__name__,
            arguments=error.args if plain else (str(error),),
            attributes={name: getattr(error, name) for name in DIVERGED} if diverged else {},
            trace="" if isinstance(error, PhyscoreError) else "".join(traceback.format_exception(error)),
            lasting=diverged,
        )

    def exception(self) -> Exception:
        """The exception. Classes that are neither of physcore nor of Python become a RuntimeError."""
        kind = getattr(errors, self.kind, None) or getattr(builtins, self.kind, None)
        error: Exception = RuntimeError(": ".join([self.kind, *map(str, self.arguments)]))
        if isinstance(kind, type) and issubclass(kind, Exception):
            with suppress(TypeError):  # Some classes take other arguments than they keep.
                error = kind(*self.arguments, **self.attributes)
        if self.trace:
            error.add_note(self.trace.rstrip())
        return error


@dataclass(frozen=True)
class Outcome:
    """Outcome of a task."""

    scene: str | None = None
    """Hash of the scene; None if it was not built, or no hash is needed."""
    value: Any = None
    """Value of the measure."""
    failure: Failure | None = None
    seconds: float = 0.0
    """Time of the simulation [s]."""
    recording: dict[str, Tree] | None = None
    """Content of the recording, if it is kept."""


@dataclass(frozen=True, eq=False)
class Task:
    """One point of a sweep."""

    build: Callable[..., Any]
    measure: Callable[[Recording], Any] | None
    arguments: dict[str, Any]
    """Arguments of `build`."""
    numerics: Options
    duration: float
    fps: float
    channels: tuple[str, ...] | None
    keep: bool
    """Whether the recording is kept."""
    filed: bool
    """Whether the outcome is kept in a file."""
    key: str | None
    """Text that stands for the functions of the scene."""

    def scene(self) -> Scene:
        """The scene of the point.

        Raises:
            SceneError: `build` returned no scene. Exceptions of `build` are passed on.
        """
        built = self.build(**self.arguments)
        if not isinstance(built, Scene):
            given = ", ".join(f"{name}={shown(value)}" for name, value in self.arguments.items())
            raise SceneError(f"build: must return a Scene, returned {shown(built)} for {given}")
        return built

    def hash(self, scene: Scene) -> str | None:
        """The hash of the scene, if its outcome is kept in a file or with a recording.

        Raises:
            SceneError: the scene has functions without a key, and the outcome is kept in a file.
        """
        if self.filed:
            return scene_hash(scene, self.key)
        return scene.hash(self.key or "") if self.keep else None


def identify(task: Task) -> Outcome:
    """Build the scene of a task, and return its hash.

    Raises:
        SceneError: the scene has functions without a key.
    """
    return _outcome(task, lambda scene: Outcome())


def compute(task: Task) -> Outcome:
    """Build the scene of a task, simulate it, and measure its recording.

    Raises:
        SceneError: the scene has functions without a key.
    """
    return _outcome(task, lambda scene: _measured(task, scene))


def _outcome(task: Task, run: Callable[[Scene], Outcome]) -> Outcome:
    """The outcome of a function of the scene. Exceptions become failures."""
    try:
        scene = task.scene()
    except Exception as error:
        return Outcome(failure=Failure.of(error))
    found = task.hash(scene)  # An error here is one of the whole sweep.
    start = time.perf_counter()
    try:
        outcome = run(scene)
    except Exception as error:
        outcome = Outcome(failure=Failure.of(error), seconds=time.perf_counter() - start)
    return Outcome(found, outcome.value, outcome.failure, outcome.seconds, outcome.recording)


def _measured(task: Task, scene: Scene) -> Outcome:
    """The outcome of a simulation."""
    start = time.perf_counter()
    simulation = Simulation(scene, **task.numerics)
    recording = simulation.record(task.duration, task.fps, task.channels, progress=False)
    seconds = time.perf_counter() - start
    value = None if task.measure is None else simple(task.measure(recording), "measure")
    return Outcome(value=value, seconds=seconds, recording=archive.plain(recording.content()) if task.keep else None)


def simple(value: object, path: str) -> Any:
    """A value of a measure as it is kept in files: numbers and arrays of Python and NumPy, texts, lists and mappings.

    Raises:
        SceneError: the value is none of these.
    """
    if isinstance(value, (np.ndarray, np.generic)) and value.dtype.kind in "biuf":
        kind = {"b": np.bool_, "i": np.int64, "u": np.uint64, "f": np.float64}[value.dtype.kind]
        return value.astype(kind).item() if value.ndim == 0 else np.array(value, dtype=kind)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (list, tuple)):
        return [simple(each, f"{path}[{index}]") for index, each in enumerate(value)]
    if isinstance(value, dict) and all(isinstance(key, str) and not key.startswith("$") for key in value):
        return {key: simple(each, f"{path}[{key!r}]") for key, each in value.items()}
    raise SceneError(
        f"{path}: must return numbers, texts, arrays of numbers, or lists and mappings of these, got {shown(value)}"
    )
