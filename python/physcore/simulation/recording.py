"""Recordings: arrays over time, with their budgets."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from physcore import memory
from physcore.checks import FloatArray, is_word, word, words
from physcore.errors import FileError, SceneError
from physcore.scene.contents import ItemKey
from physcore.scene.fields import FIELDS, FLOW, MOTION, RIGID
from physcore.scene.scene import Scene
from physcore.simulation.diagrams import over_time
from physcore.simulation.energy import Amount, AmountSeries, EnergySeries
from physcore.simulation.occurrences import Events
from physcore.simulation.periods import marked, period_of
from physcore.simulation.plan import Plan
from physcore.simulation.provenance import Provenance
from physcore.simulation.serial import unpack_scene
from physcore.simulation.state import Frame
from physcore.simulation.tables import data_frame
from physcore.simulation.trajectory import Trajectory, channel_rules
from physcore.storage import archive, schema
from physcore.storage.schema import Sizes, anything, of, real, record, several, table, text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

AMOUNTS = ("kinetic", "internal", "dissipated", "work")
"""Parts of the energy budget that are single numbers."""
PARTS = ("removed_by", "supplied_by")
"""Parts of other budgets that have one number for each cause."""
TOTALS = {"momentum": "kg·m/s", "angular_momentum": "kg·m²/s"}
"""Sums over all particles and rigid bodies, with their units."""
TERMS = 8
"""Approximate number of forces and causes of dissipation, each with an energy of its own."""


def check_channels(channels: object, scene: Scene, listed: Collection[str] | None = None) -> tuple[str, ...]:
    """The fields of a scene to record; None: all except those of fluids. "positions" and "velocities" include those of
    rigid bodies.

    Args:
        channels: the user's choice.
        scene: the scene.
        listed: the fields that there are with the integrator, if it is known.

    Raises:
        SceneError: a field is not one of the scene's, or is not there with the integrator.
    """
    known = tuple(scene.fields)
    if channels is None:
        return tuple(name for name in known if name not in FLOW and (listed is None or name in listed))
    if isinstance(channels, (tuple, list)) and scene.has_rigid_bodies:
        # Positions and velocities are those of rigid bodies too.
        more = [name for name in RIGID if any(is_word(each, FIELDS[name].source) for each in channels)]
        channels = [*channels, *more]
    hint = ""
    if isinstance(channels, str):
        hint = f'; write ("{channels}",)' if channels in known else ""
    elif isinstance(channels, (tuple, list)) and any(is_word(each, name) for each in channels for name in FLOW):
        hint = "" if scene.fluids else "; only a Fluid has densities and pressures"
    kept = words(channels, "channels", known, hint)
    for name in kept:
        if listed is not None and name not in listed:
            owner = FIELDS[name].owner if name in FIELDS else None
            whose = "" if owner is None else f": only {owner} them"
            raise SceneError(f"channels: there are no {name} with this integrator{whose}")
    return kept


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Trajectory):
    """Recording of a simulation: frames at a fixed rate. `recording[body]` is the part of one body.

        recording = pc.simulate(scene, duration=0.2)  # a Recording
        recording["cloth"].positions  # (F, N, D)
        print(recording.energy)
        recording.film("cloth.png")

    `save` writes a recording, `physcore.load` loads it, and `physcore.film` draws it.
    """

    energy: EnergySeries
    """Energy budget at the last step at or before each frame: `energy.times`."""
    momentum: FloatArray
    """Total momentum at `energy.times` [kg·m/s], shape (F, D)."""
    angular_momentum: FloatArray
    """Total angular momentum about the origin at `energy.times` [kg·m²/s], shape (F, D (D − 1)/2)."""
    fps: float
    """Frames per second of simulated time."""
    scene: Scene
    """Simulated scene."""
    plan: Plan
    """Plan of the simulation."""
    budgets: Mapping[str, AmountSeries]
    """Budgets of other conserved quantities by name, such as `budgets["u"]` for the amount of a species."""
    provenance: Provenance
    """The steps that were taken, and the hash of the state at the end."""
    events: Events = field(default_factory=Events)
    """Occurrences of the events that the run looked for: `events[event].times`, by event, name or number."""
    film: ClassVar[Callable[..., Any]]
    """Draw a film: `recording.film("run.gif", …)` is `physcore.film(recording, "run.gif", …)`."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "units", self.scene.units)

    def to_dataframe(self) -> DataFrame:
        """Convert to a pandas data frame, as in `Trajectory`; at each time, the bodies follow one another."""
        bodies = self.scene.particle_bodies
        names = [(self.scene.index(body) if body.name is None else body.name, len(body)) for body in bodies]
        own = {name: values for name, values in self.channels.items() if name in (*MOTION, *FLOW)}
        return data_frame(self.times, own if names else {}, names)

    def plot(self, channel: str = "energy", axes: Axes | None = None) -> Axes:
        """Plot a quantity over time with Matplotlib (`pip install "physcore[plot]"`).

            axes = recording.plot()
            axes = recording.plot("velocities")

        Args:
            channel: "energy" (the budget), "momentum", "angular_momentum", or a channel such as "positions". A channel
                has
                the mean of each component, and a band from the smallest to the largest value.
            axes: the axes to draw into; a new figure by default.

        Raises:
            PhyscoreError: Matplotlib is not installed.
            SceneError: there is no such quantity.
        """
        name = word(channel, "plot.channel", ("energy", *TOTALS, *self.channels))
        if name == "energy":
            return self.energy.plot(axes)
        if name not in TOTALS:
            return super().plot(name, axes)
        values: FloatArray = getattr(self, name)
        components = "xyz"[-values.shape[1] :] if name == "angular_momentum" else "xyz"[: values.shape[1]]
        label = self.units.label(name.replace("_", " "), TOTALS[name])
        return over_time(self.energy.times, values[:, np.newaxis], components, label, axes, self.units)

    def __getitem__(self, item: ItemKey) -> Trajectory:  # type: ignore[override]  # the part of an item
        return self._part(self.scene, item)

    def __repr__(self) -> str:
        return (
            f"Recording({len(self)} frames at {self.fps:g} per {self.units.per}, {contents(self.scene)} "
            f"in {self.scene.dimension}D, energy drift {np.abs(self.energy.drift).max():.1e})"
        )

    def _repr_html_(self) -> str | None:
        """HTML for notebooks: a small film, if a function for it was registered by `show_with`."""
        return None if _preview is None else _preview(self)

    def show(self) -> Shown:
        """Show the whole film in a notebook, at any size; by default a notebook shows a small preview.

        All frames, in the size of `film`, are in memory. For more than a few hundred frames, write a file instead.

        Raises:
            SceneError: there are no positions to draw.
        """
        if _whole is None or "positions" not in self.channels:
            raise SceneError("show: needs the channel 'positions'")
        return Shown(_whole(self), repr(self))

    @property
    def period(self) -> float | None:
        """Period of the motion [s], after which all particles return to their positions, and rigid bodies to their
        positions and orientations; None without a period.

            swing = pc.simulate(scene, duration=recording.period or 1.0)

        The tolerance is 2 % of the extent of the motion. Periods up to half of the recording are found. A film of one
        period loops without a jump.
        """
        places = marked(self.scene, self.channels)
        return None if places is None else period_of(self.times, places, self.scene.periodic)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save the recording as a NumPy archive, which `physcore.load` and `numpy.load` read.

        Raises:
            FileError: the file cannot be written, or the scene has a CustomForce.
        """
        archive.write(path, "recording", {**self.content(), "scene": self.scene.packed()})

    def content(self) -> dict[str, archive.Tree]:
        """The recording as plain values without its scene, for a file."""
        return {
            "times": self.times,
            **self.channels,
            "channels": list(self.channels),
            "energy": self.energy.series,
            "budgets": {name: _without_units(vars(budget)) for name, budget in self.budgets.items()},
            "momentum": self.momentum,
            "angular_momentum": self.angular_momentum,
            "fps": self.fps,
            "plan": _without_units(asdict(self.plan)),
            "provenance": self.provenance.content(),
            "events": [occurrences.content() for occurrences in self.events],
        }

    @classmethod
    def from_content(cls, content: dict[str, archive.Tree], scene: Scene | None = None) -> Self:
        """Rebuild a recording from the content of its file.

        Args:
            content: the content.
            scene: the scene, if it is not in the file.

        Raises:
            FileError: an entry is missing or not valid; the message has its path.
        """
        scene = unpack_scene(content.get("scene")) if scene is None else scene
        sizes = Sizes(N=scene.particles, S=scene.count("springs"), D=scene.dimension, A=_turns(scene))
        if "provenance" not in content:
            raise FileError("provenance: is missing")
        provenance = Provenance.from_content(content["provenance"])
        # A run that went on in spite of its divergence may have energies beyond the range of numbers.
        finite = not is_word(provenance.numerics.get("on_divergence"), "ignore")
        over_time = sizes.array("F", finite=finite)
        channels = several(schema.word(*scene.fields))(content.get("channels"), "channels")
        rules = channel_rules(scene, sizes, "F")
        terms = {"by_term": table(over_time), "dissipated_by": table(over_time)}
        amounts = dict.fromkeys(("times", *AMOUNTS), over_time)
        budget = record(unit=text, total=over_time, times=over_time, **dict.fromkeys(PARTS, table(over_time)))
        shape = record(
            {"scene": anything},
            channels=anything,
            times=sizes.array("F", finite=True),
            fps=real(above=0.0),
            energy=record(**amounts, **terms),
            momentum=sizes.array("F", "D", finite=finite),
            angular_momentum=sizes.array("F", "A", finite=finite),
            plan=of(Plan, units=None),
            budgets=table(budget),
            provenance=anything,
            events=lambda value, path: Events.from_content(value, path, scene, sizes),
            **{name: rules[name] for name in channels},
        )
        checked = shape(content, "")
        if not (np.diff(checked["times"]) > 0.0).all():
            raise FileError("times: must be ascending")
        energy = EnergySeries(**checked["energy"], units=scene.units)
        with np.errstate(over="ignore", invalid="ignore"):
            if finite and not np.isfinite(energy.drift).all():
                raise FileError("energy: must have a drift of the balance that is finite")
        return cls(
            times=checked["times"],
            channels={name: checked[name] for name in channels},
            energy=energy,
            momentum=checked["momentum"],
            angular_momentum=checked["angular_momentum"],
            fps=checked["fps"],
            scene=scene,
            plan=Plan(**checked["plan"], units=scene.units),
            budgets={name: AmountSeries(**each, units=scene.units) for name, each in checked["budgets"].items()},
            provenance=provenance,
            events=checked["events"],
        )


def collect(
    frames: Iterable[Frame],
    count: int,
    scene: Scene,
    fps: float,
    shapes: Mapping[str, tuple[int, ...]],
    end: Callable[[], tuple[Plan, Provenance]],
    tick: Callable[[int], None],
) -> Recording:
    """Collect the fields in `shapes` from at most `count` frames. `tick` is called with the number of frames so far,
    `end` after the last one.

    Raises:
        SceneError: the recording would not fit into memory.
    """
    audit = count * (len(("times", "times", *AMOUNTS)) + TERMS + scene.dimension + _turns(scene))
    hint = "lower fps, record fewer channels, or stream: physcore.film(scene, …)"
    refuse_if_too_large(count, scene, 8 * (audit + count * sum(map(math.prod, shapes.values()))), hint)
    data: dict[str, FloatArray] = {name: np.empty((count, *shape)) for name, shape in shapes.items()}
    times = np.empty(count)
    momentum = np.empty((count, scene.dimension))
    angular_momentum = np.empty((count, _turns(scene)))
    budget: dict[str, FloatArray] = {name: np.empty(count) for name in ("times", *AMOUNTS)}
    by_term: dict[str, FloatArray] = {}
    dissipated_by: dict[str, FloatArray] = {}
    amounts: dict[str, list[Amount]] = {}
    taken = 0
    for index, frame in enumerate(frames):
        taken = index + 1
        for name, values in data.items():
            values[index] = frame.fields[name]
        times[index] = frame.time
        momentum[index], angular_momentum[index] = frame.momentum, frame.angular_momentum
        budget["times"][index] = frame.energy.time
        for part in AMOUNTS:
            budget[part][index] = getattr(frame.energy, part)
        for parts, series in ((frame.energy.by_term, by_term), (frame.energy.dissipated_by, dissipated_by)):
            for term, value in parts.items():
                series.setdefault(term, np.empty(count))[index] = value
        for name, amount in frame.budgets.items():
            amounts.setdefault(name, []).append(amount)
        tick(taken)
    budgets = {name: AmountSeries.of(each) for name, each in amounts.items()}
    by_term, dissipated_by, budget, data = (
        {name: values[:taken] for name, values in series.items()} for series in (by_term, dissipated_by, budget, data)
    )
    energy = EnergySeries(by_term=by_term, dissipated_by=dissipated_by, **budget, units=scene.units)
    plan, provenance = end()
    totals = momentum[:taken], angular_momentum[:taken]
    return Recording(times[:taken], data, energy, *totals, fps, scene, plan, budgets, provenance)


def _without_units(content: Mapping[str, archive.Tree]) -> dict[str, archive.Tree]:
    """A part of a file without the units, which are those of the scene."""
    return {name: value for name, value in content.items() if name != "units"}


def refuse_if_too_large(frames: int, scene: Scene, needed: int, hint: str) -> None:
    """Check that enough memory is free.

    Raises:
        SceneError: it is not.
    """
    memory.require(needed, f"{frames} frames of {contents(scene)}", "duration", hint)


def contents(scene: Scene) -> str:
    """The numbers of particles, rigid bodies, tracers and cells of a scene, as text."""
    counts = {
        "particles": scene.particles,
        "rigid bodies": scene.count("rigid bodies"),
        "tracers": scene.count("points"),
        "cells": scene.count("cells"),
    }
    return " and ".join(f"{count} {name}" for name, count in counts.items() if count) or "0 particles"


def _turns(scene: Scene) -> int:
    """The number of components of the angular momentum."""
    return scene.dimension * (scene.dimension - 1) // 2


@dataclass(frozen=True, repr=False)
class Shown:
    """HTML content to be shown in a notebook, and words for it. A notebook stores both."""

    html: str
    words: str

    def __repr__(self) -> str:
        return self.words

    def _repr_html_(self) -> str:
        return self.html


_preview: Callable[[Recording], str | None] | None = None
_whole: Callable[[Recording], str] | None = None


def show_with(preview: Callable[[Recording], str | None], whole: Callable[[Recording], str]) -> None:
    """Register the functions that give the HTML of recordings in notebooks: of a preview (None: text is shown), and of
    the whole film.
    """
    global _preview, _whole
    _preview, _whole = preview, whole
