"""States within a step: by interpolation, or by steps of other lengths from its start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np

from physcore._core import World
from physcore.arithmetic import dots, lengths
from physcore.checks import FloatArray
from physcore.errors import SimulationDiverged
from physcore.numerics.choices import Numerics
from physcore.scene.rotations import quaternion_rates
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.state import Snapshot
from physcore.storage.archive import Tree

S = TypeVar("S", bound=Snapshot)

FINEST = 1024
"""Largest number of parts in which a part of a step is taken, if it diverges as a whole."""


def between(before: S, after: Snapshot, fraction: float, dt: float, rates: Mapping[str, str | None]) -> S:
    """The fields at a fraction of a step; all else is that of `before`.

    A field whose rate of change is also a field is a cubic Hermite interpolation, and its rate is the derivative of
    this cubic. All other fields are interpolated linearly. The formulas use differences, so that constant values keep
    their bits. The error is of order dt⁴ for fields such as positions, dt³ for their rates, and dt² for the others.
    Orientations are normalized.

    Source: C. de Boor, "A Practical Guide to Splines", 1978, chapter IV.
    """
    s, r = fraction, 1.0 - fraction
    fields: dict[str, FloatArray] = {}
    for name, rate in rates.items():
        if rate is not None:
            shift = after.fields[name] - before.fields[name]
            v0, v1 = before.fields[rate], after.fields[rate]
            fields[name] = _cubic(before.fields[name], shift, (v0, v1), s, dt)
            shift /= dt
            fields[rate] = _sum((6.0 * s * r, shift), (r * (1.0 - 3.0 * s), v0), (s * (3.0 * s - 2.0), v1))
    # The order of fields is that of the state.
    fields = {
        name: fields[name] if name in fields else values + s * (after.fields[name] - values)
        for name, values in before.fields.items()
    }
    if "orientations" in fields:
        fields["orientations"] = _turned(before, after, s, dt)
    return replace(before, fields=fields)


def _cubic(
    start: FloatArray, shift: FloatArray, rates: tuple[FloatArray, FloatArray], s: float, dt: float
) -> FloatArray:
    """The cubic Hermite interpolation at a fraction of a step, by its start, its change, and its rates at both ends."""
    r = 1.0 - s
    bend = _sum((r, rates[0]), (-s, rates[1]))
    value = s * s * (3.0 - 2.0 * s) * shift
    value += start
    bend *= dt * s * r
    value += bend
    return value


def _sum(*terms: tuple[float, FloatArray]) -> FloatArray:
    """The sum of coefficients times arrays. Large arrays cost more than the arithmetic, so that there are few."""
    total, product = terms[0][0] * terms[0][1], np.empty_like(terms[0][1])
    for coefficient, values in terms[1:]:
        total += np.multiply(coefficient, values, out=product)
    return total


def _turned(before: Snapshot, after: Snapshot, s: float, dt: float) -> FloatArray:
    """Unit quaternions at a fraction of a step, by a cubic Hermite interpolation that is normalized; the error is of
    order dt⁴.
    """
    q0, q1 = before.orientations, after.orientations
    q1 = np.where(dots(q0, q1)[:, np.newaxis] < 0.0, -q1, q1)  # q and −q are the same orientation
    r0, r1 = quaternion_rates(q0, before.angular_velocities), quaternion_rates(q1, after.angular_velocities)
    turned = _cubic(q0, q1 - q0, (r0, r1), s, dt)
    # A quaternion that does not change keeps its bits.
    unit: FloatArray = np.where((turned == q0).all(axis=1, keepdims=True), q0, turned / lengths(turned)[:, np.newaxis])
    return unit


class Step(NamedTuple):
    """A step that was taken, from its start to its end. Positions are not wrapped into the periodic domain."""

    world: Tree
    """Captured world at the start."""
    before: Snapshot
    """State at the start."""
    after: Snapshot
    """State at the end."""

    @property
    def length(self) -> float:
        """Length of the step [s]."""
        return self.after.time - self.before.time

    def interpolated(self, part: float, rates: Mapping[str, str | None]) -> Snapshot:
        """The interpolated state a part of the step [s] after its start."""
        state = between(self.before, self.after, part / self.length, self.length, rates)
        return replace(state, time=self.before.time + part)


class Stretch(NamedTuple):
    """Part of a step, in one or more equal parts."""

    parts: int
    """Number of parts."""
    size: float
    """Their size [s]."""
    world: Tree
    """Captured world at the end."""


class Fork:
    """A second world, for parts of the steps of the first one."""

    def __init__(self, scene: Scene, numerics: Numerics) -> None:
        self._scene = scene
        self._numerics = numerics

    @cached_property
    def _world(self) -> World:
        return engine.build(self._scene, self._numerics)

    def state(self, step: Step, part: float) -> Snapshot:
        """The state after a part of a step [s].

        Raises:
            SimulationDiverged: the part diverges, even in the smallest parts.
        """
        self._reach(step, part)
        return engine.snapshot(self._world, self._scene)

    def stretch(self, step: Step, part: float) -> Stretch:
        """The way to the end of a part of a step [s]."""
        parts = self._reach(step, part)
        return Stretch(parts, part / parts, self._world.capture())

    def free(self) -> None:
        """Free the second world until it is needed again."""
        self.__dict__.pop("_world", None)

    def _reach(self, step: Step, part: float) -> int:
        """Take a part of a step [s], if need be in smaller parts, and return their number."""
        parts = 1
        while True:
            self._world.restore(step.world)
            try:
                self._world.step(parts, part / parts)
            except SimulationDiverged:
                if parts == FINEST:
                    raise
                parts *= 2
            else:
                return parts
