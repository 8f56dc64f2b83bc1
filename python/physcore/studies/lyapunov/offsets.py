"""Offsets between two runs of a scene: the state of every item, relative to its scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physcore.checks import BoolArray, FloatArray
from physcore.scene.scene import Scene
from physcore.scene.system import System
from physcore.simulation.simulation import Simulation
from physcore.studies.lyapunov.neighbors import TINY

Fields = list[FloatArray]
"""Fields of an item, each with rows for its particles, points or cells."""


@dataclass(frozen=True)
class Share:
    """Part of the state that belongs to one item."""

    scene: Scene
    path: str | None
    """Path of a system; None: all bodies."""
    names: tuple[str, ...]
    """Fields of the state."""
    free: BoolArray
    """Mask of the rows that can be perturbed."""

    def read(self, run: Simulation) -> Fields:
        """The fields of a run; complex numbers are pairs."""
        if self.path is None:
            return [run.positions, run.velocities]
        part = run[self.path]
        return [_rows(part.fields[name], self.free) for name in self.names]

    def write(self, run: Simulation, fields: Fields) -> None:
        """Set a run to fields."""
        if self.path is None:
            run.set(*fields)
            return
        shapes = self.scene.systems_by_path[self.path].shapes()
        run[self.path].set(**{name: own.reshape(shapes[name]) for name, own in zip(self.names, fields, strict=True)})

    def size(self, fields: Fields) -> int:
        """The number of values that can be perturbed."""
        return sum(own[self.free].size for own in fields)

    def moved(self, fields: Fields, scales: Sequence[float], offset: FloatArray) -> Fields:
        """The fields at an offset from others."""
        ends = np.cumsum([own[self.free].size for own in fields])
        result = [own.copy() for own in fields]
        for own, scale, change in zip(result, scales, np.split(offset, ends[:-1]), strict=True):
            own[self.free] += scale * change.reshape(own[self.free].shape)
        return result

    def offset(self, fields: Fields, others: Fields, scales: Sequence[float]) -> FloatArray:
        """The offset of fields from others, relative to their scales (P,)."""
        changes = [one[self.free] - other[self.free] for one, other in zip(fields, others, strict=True)]
        if self.path is None and self.scene.periodic is not None:
            changes[0] = self.scene.periodic.nearest(changes[0])
        return np.concatenate([(change / scale).ravel() for change, scale in zip(changes, scales, strict=True)])

    def scales(self, seen: list[Fields], duration: float, whole: float) -> tuple[float, ...]:
        """The scale of each field, from fields seen in the first part of the motion, of a duration [s].

        Of bodies, half the extent and the largest speed, at least that which crosses the extent in `whole` seconds. Of
        a system, half the range of the values, or the largest of values that do not change.
        """
        if self.path is not None:
            return tuple(_extent(np.concatenate(own)) for own in zip(*seen, strict=True))
        places, speeds = (np.concatenate(own) for own in zip(*seen, strict=True))
        speed = float(np.abs(speeds).max())
        extent = float(np.ptp(places, axis=0).max()) / 2.0 or speed * duration or 1.0
        return max(extent, TINY), max(speed, extent / whole, TINY)


def shares(scene: Scene) -> list[Share]:
    """The state of all items."""
    found = []
    if scene.bodies:
        free = ~scene.gather("fixed")
        found.append(Share(scene, None, ("positions", "velocities"), free))
    for path, system in scene.systems_by_path.items():
        names = tuple(name for name in system.shapes() if name not in system.derived)
        found.append(Share(scene, path, names, _changing(system)))
    return found


def _changing(system: System) -> BoolArray:
    """Mask of the cells or points of a system that are not solid."""
    count = sum(system.elements.values())
    return np.ones(count, dtype=np.bool_) if system.solid is None else ~system.solid.ravel()


def _rows(values: FloatArray, free: BoolArray) -> FloatArray:
    """Values with one row for each point or cell (N, C)."""
    given = np.ascontiguousarray(values)
    return given.view(np.float64).reshape(len(free), -1).copy()


def _extent(values: FloatArray) -> float:
    """Half the largest range of a component, or the largest value if there is none; 1 for zeros."""
    extent = float(np.ptp(values, axis=0).max()) / 2.0
    return extent or float(np.abs(values).max()) or 1.0
