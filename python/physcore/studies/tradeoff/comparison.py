"""Comparison of runs by the primary fields of all items of a scene, each relative to its motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physcore.checks import FloatArray
from physcore.errors import SimulationDiverged
from physcore.numerics.contacts import Contacts
from physcore.numerics.fluids import Fluids
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation
from physcore.simulation.step_warnings import unwarned
from physcore.studies.primary import Primary
from physcore.studies.state import compared

LOOKS = 32
"""Number of states in which the changes of items are measured."""


@dataclass(frozen=True)
class Comparison:
    """Comparison of the values of all items in one array.

    A single item has its values as they are. Several items are flat and follow one another, and each is scaled to move
    as far as the first one that moves. Errors have the unit of that one.
    """

    scene: Scene
    scales: tuple[float, ...] = ()
    """Largest change of each item, if there are several."""

    @property
    def items(self) -> tuple[Primary, ...]:
        """The compared fields."""
        return compared(self.scene)

    @property
    def _first(self) -> int:
        """The index of the first item that moves."""
        return next((index for index, scale in enumerate(self.scales) if scale > 0.0), 0)

    @property
    def suffix(self) -> str:
        """The unit of errors as it follows a number."""
        return self.items[self._first].suffix

    @property
    def _weights(self) -> tuple[float, ...]:
        """The factor of each item; 1 for the first moving one, and for those at rest."""
        if len(self.items) == 1:
            return (1.0,)
        return tuple(self.scales[self._first] / scale if scale > 0.0 else 1.0 for scale in self.scales)

    def weighed(self, values: Sequence[float], power: int) -> list[float]:
        """One value for each item in a power of its unit, as values of the first moving item."""
        return [math.prod([weight] * power) * value for weight, value in zip(self._weights, values, strict=True)]

    def joined(self, values: Sequence[FloatArray], axes: int) -> FloatArray:
        """The values of all items in one array, after `axes` common axes."""
        if len(values) == 1:
            return values[0]
        pairs = zip(self._weights, values, strict=True)
        return np.concatenate([weight * each.reshape(*each.shape[:axes], -1) for weight, each in pairs], axis=-1)

    def present(self, simulation: Simulation) -> FloatArray:
        """The values of all items in a run."""
        return self.joined([each.values(simulation) for each in self.items], 0)

    def parts(self, samples: FloatArray) -> list[FloatArray]:
        """The values of each item in its own unit (F, …), from joined values (F, …)."""
        items = self.items
        if len(items) == 1:
            return [samples]
        ends = np.cumsum([math.prod(each.shape) for each in items])
        columns = np.split(samples, ends[:-1], axis=-1)
        return [
            (own / weight).reshape(*own.shape[:-1], *each.shape)
            for each, own, weight in zip(items, columns, self._weights, strict=True)
        ]

    def difference(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """The difference one − other; for positions in a periodic domain, the displacement to the nearest image."""
        if self.scene.periodic is None:
            return one - other
        pairs = zip(self.items, self.parts(one), self.parts(other), strict=True)
        return self.joined([each.difference(first, second) for each, first, second in pairs], 1)

    def distances(self, change: FloatArray) -> FloatArray:
        """The largest distance of any particle, or of any value, of any item at each time, from differences; (F,)."""
        own = [each.distances(part) for each, part in zip(self.items, self.parts(change), strict=True)]
        if len(own) == 1:
            return own[0]
        farthest: FloatArray = (np.array(self._weights)[:, np.newaxis] * np.stack(own)).max(axis=0)
        return farthest


def scales_of(
    scene: Scene, duration: float, threads: int | None, fluids: Fluids, contacts: Contacts
) -> tuple[float, ...]:
    """The largest change of each item since the start, in a run with the default numerics or until it diverges. Of a
    single item it is not needed.
    """
    items = compared(scene)
    if len(items) == 1:
        return ()
    scales = [0.0] * len(items)
    with unwarned():
        run = Simulation(scene, threads=threads, fluids=fluids, contacts=contacts)
        starts = [each.values(run) for each in items]
        for _ in range(LOOKS):
            try:
                run.run(duration / LOOKS)
            except SimulationDiverged:
                break
            for index, (each, start) in enumerate(zip(items, starts, strict=True)):
                change = each.difference(each.values(run), start)[np.newaxis]
                scales[index] = max(scales[index], float(each.distances(change)[0]))
    return tuple(scales)
