"""A recording: arrays over time, and the audit that goes with them."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterable
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal, Self

import numpy as np

from physcore import storage
from physcore._core import available_memory
from physcore.checks import FloatArray
from physcore.energy import EnergySeries
from physcore.errors import SceneError
from physcore.fluid import Fluid
from physcore.plan import Plan
from physcore.provenance import Provenance
from physcore.scene import BodyKey, Scene
from physcore.serial import pack_scene, unpack_scene
from physcore.state import Frame

Channel = Literal["positions", "velocities", "densities", "pressures"]
CHANNELS: tuple[Channel, ...] = ("positions", "velocities")
"""What is recorded by default."""
FLUID_CHANNELS: tuple[Channel, ...] = ("densities", "pressures")
"""What can be recorded of fluids too."""
AMOUNTS = ("kinetic", "internal", "dissipated", "work")
"""The parts of the energy budget that are one number each."""

SLOW = 5.0
"""Frames per second below which a notebook plays a recording faster than real time: the orbit of a planet, say."""


def check_channels(channels: object, *, fluids: bool) -> tuple[Channel, ...]:
    """The channels to record; `fluids` says whether the scene has any.

    Raises:
        SceneError: they are not some of CHANNELS, or of FLUID_CHANNELS where there are fluids.
    """
    known = (*CHANNELS, *FLUID_CHANNELS) if fluids else CHANNELS
    if isinstance(channels, str) or not isinstance(channels, Collection) or any(c not in known for c in channels):
        hint = ""
        if isinstance(channels, str):
            hint = f'; write ("{channels}",)' if channels in known else ""
        elif isinstance(channels, Collection) and set(channels) & set(FLUID_CHANNELS) and not fluids:
            hint = "; only a Fluid has densities and pressures"
        raise SceneError(f"channels: must be a tuple of {', '.join(map(repr, known))}, got {channels!r}{hint}")
    return tuple(channels)


@dataclass(frozen=True, eq=False, repr=False)
class Track:
    """Positions, velocities and what else was recorded over time, of a whole scene or of one body."""

    times: FloatArray
    """Time of each frame [s], shape (F,)."""
    channels: dict[Channel, FloatArray]
    """What was recorded, by name: vectors of shape (F, N, D), numbers of shape (F, N)."""

    @property
    def positions(self) -> FloatArray:
        """[m], shape (F, N, D); within the periodic domain."""
        return self._channel("positions")

    @property
    def velocities(self) -> FloatArray:
        """[m/s], shape (F, N, D)."""
        return self._channel("velocities")

    @property
    def densities(self) -> FloatArray:
        """[kg/m³], shape (F, N); not a number for particles that are not a fluid's."""
        return self._channel("densities")

    @property
    def pressures(self) -> FloatArray:
        """[Pa], shape (F, N); not a number for particles that are not a fluid's."""
        return self._channel("pressures")

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in self.channels.items())
        return f"{type(self).__name__}({len(self)} frames: {shapes or 'nothing'})"

    def _channel(self, name: Channel) -> FloatArray:
        if name not in self.channels:
            whose = "; only a Fluid has them" if name in FLUID_CHANNELS else ""
            raise SceneError(f"channels: {name} were not recorded; ask for them with channels=({name!r}, …){whose}")
        return self.channels[name]


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Track):
    """Frames of a simulation at a fixed rate; `recording[body]` gives the part of one body.

    Save one with `save`, read it back with `physcore.load`, draw it with `physcore.film`.
    """

    energy: EnergySeries
    """The energy budget, of the last step at or before each frame: `energy.times`."""
    momentum: FloatArray
    """Total momentum at `energy.times` [kg·m/s], shape (F, D)."""
    angular_momentum: FloatArray
    """Total angular momentum about the origin at `energy.times` [kg·m²/s], shape (F, 1) in 2D, (F, 3) in 3D."""
    fps: float
    """Frames per second of simulated time."""
    scene: Scene
    """What was simulated."""
    plan: Plan
    """How it was simulated."""
    provenance: Provenance | None = None
    """The steps that were taken, and the hash of the state at the end; None in files of an earlier physcore."""

    def __getitem__(self, body: BodyKey) -> Track:
        part = self.scene.slice(body)
        wet = isinstance(self.scene.bodies[self.scene.index(body)], Fluid)
        mine = {name: values for name, values in self.channels.items() if wet or name not in FLUID_CHANNELS}
        return Track(self.times, {name: values[:, part] for name, values in mine.items()})

    def __repr__(self) -> str:
        return (
            f"Recording({len(self)} frames at {self.fps:g} per second, {self.scene.particles} particles "
            f"in {self.scene.dimension}D, energy drift {np.abs(self.energy.drift).max():.1e})"
        )

    def _repr_html_(self) -> str | None:
        """The GIF, for notebooks: in real time, or as close to it as a GIF can be. None without positions."""
        import base64

        from physcore.film import gif_bytes
        from physcore.film.writers.gif import GifWriter

        if "positions" not in self.channels:
            return None
        rate = min(max(self.fps, SLOW), GifWriter.fastest)
        content = base64.b64encode(gif_bytes(self, speed=rate / self.fps)).decode()
        return f'<img alt="{self!r}" src="data:image/gif;base64,{content}">'

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to a NumPy archive, which `physcore.load` and `numpy.load` read.

        Raises:
            FileError: the file cannot be written, or the scene has a CustomForce.
        """
        series = {entry.name: getattr(self.energy, entry.name) for entry in fields(self.energy)}
        content: dict[str, storage.Tree] = {
            "times": self.times,
            **dict[str, FloatArray](self.channels.items()),
            "channels": list(self.channels),
            "energy": series,
            "momentum": self.momentum,
            "angular_momentum": self.angular_momentum,
            "fps": self.fps,
            "scene": pack_scene(self.scene),
            "plan": asdict(self.plan),
            "provenance": None if self.provenance is None else self.provenance.content(),
        }
        storage.write(path, "recording", content)

    @classmethod
    def from_content(cls, content: dict[str, storage.Tree]) -> Self:
        """Rebuild a recording from the content of its file."""
        plan: Any = {
            name: tuple(value) if isinstance(value, list) else value for name, value in content["plan"].items()
        }
        provenance = content.get("provenance")
        return cls(
            times=content["times"],
            channels={name: content[name] for name in content["channels"]},
            energy=EnergySeries(**content["energy"]),
            momentum=content["momentum"],
            angular_momentum=content["angular_momentum"],
            fps=content["fps"],
            scene=unpack_scene(content["scene"]),
            plan=Plan(**plan),
            provenance=Provenance.from_content(provenance) if provenance is not None else None,
        )


def collect(
    frames: Iterable[Frame],
    count: int,
    scene: Scene,
    fps: float,
    channels: tuple[Channel, ...],
    end: Callable[[], tuple[Plan, Provenance]],
    tick: Callable[[int], None],
) -> Recording:
    """Gather `count` frames into a recording; `tick` is told how many there are so far, `end` is asked at the end.

    Raises:
        SceneError: the recording would not fit into memory.
    """
    numbers = (count, scene.particles)
    shapes = {name: numbers if name in FLUID_CHANNELS else (*numbers, scene.dimension) for name in channels}
    refuse_if_too_large(count, scene.particles, 8 * sum(math.prod(shape) for shape in shapes.values()))
    data: dict[Channel, FloatArray] = {name: np.empty(shape) for name, shape in shapes.items()}
    times = np.empty(count)
    momentum = np.empty((count, scene.dimension))
    angular_momentum = np.empty((count, 1 if scene.dimension == 2 else 3))
    budget: dict[str, FloatArray] = {name: np.empty(count) for name in ("times", *AMOUNTS)}
    by_term: dict[str, FloatArray] = {}
    dissipated_by: dict[str, FloatArray] = {}
    for index, frame in enumerate(frames):
        for name in channels:
            data[name][index] = getattr(frame, name)
        times[index] = frame.time
        momentum[index], angular_momentum[index] = frame.momentum, frame.angular_momentum
        budget["times"][index] = frame.energy.time
        for amount in AMOUNTS:
            budget[amount][index] = getattr(frame.energy, amount)
        for parts, series in ((frame.energy.by_term, by_term), (frame.energy.dissipated_by, dissipated_by)):
            for term, value in parts.items():
                series.setdefault(term, np.empty(count))[index] = value
        tick(index + 1)
    energy = EnergySeries(by_term=by_term, dissipated_by=dissipated_by, **budget)
    return Recording(times, data, energy, momentum, angular_momentum, fps, scene, *end())


def refuse_if_too_large(frames: int, particles: int, needed: int) -> None:
    """Refuse to begin what needs more bytes than are free.

    Raises:
        SceneError: it does.
    """
    available = _available_memory()
    if available is not None and needed > available:
        raise SceneError(
            f"duration: {frames} frames of {particles} particles take {needed / 1e9:.1f} GB, and "
            f"{available / 1e9:.1f} GB are free; lower fps, record fewer channels, or stream: physcore.film(scene, …)"
        )


def _available_memory() -> int | None:
    """Bytes that can be had without swapping, within the process's limits; all there are where nothing tells."""
    available = available_memory()
    if available is not None:
        return available
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None
