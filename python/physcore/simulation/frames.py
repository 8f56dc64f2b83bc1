"""Frames at a fixed rate, independent of the time step: the state of a step, or an interpolation between two steps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from physcore._core import World
from physcore.checks import MOST, FloatArray
from physcore.errors import PhyscoreError, SceneError, StabilityWarning, warn
from physcore.numerics.choices import steps_to
from physcore.scene.fields import GAUGES
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.earlier import Earlier
from physcore.simulation.energy import Amount, Energy
from physcore.simulation.state import Frame
from physcore.simulation.stepper import TIME_TOLERANCE, Stepper
from physcore.simulation.watch import Watch, stopped
from physcore.simulation.within import between
from physcore.units.systems import UnitSystem


def audit(world: World, units: UnitSystem, earlier: Earlier) -> tuple[Energy, dict[str, Amount]]:
    """The energy budget at the present step, and those of other conserved quantities by name, with what they have from
    earlier scenes; warn if the energy is not finite.
    """
    rows, others = world.budgets()

    def of(kind: str) -> dict[str, float]:
        return {name: energy for row, name, energy in rows if row == kind}

    dissipated_by = of("dissipated")
    budget = Energy(
        kinetic=sum(of("kinetic").values(), start=0.0),
        by_term=of("potential"),
        internal=sum(of("internal").values(), start=0.0),
        dissipated=sum(dissipated_by.values(), start=0.0),
        dissipated_by=dissipated_by,
        work=sum(of("work").values(), start=0.0),
        time=world.time,
        units=units,
    )
    _warn_if_beyond("energy", budget.balance, world, units)
    amounts = {
        name: Amount(units.symbol(unit), stored, dict(removed), dict(supplied), world.time, units=units)
        for name, unit, stored, removed, supplied in others
    }
    return earlier.on(budget, amounts)


def momentum(world: World, units: UnitSystem) -> FloatArray:
    """Total momentum at the present step; warn if it is not finite."""
    total = world.momentum()
    _warn_if_beyond("momentum", float(total.sum()), world, units)
    return total


def angular_momentum(world: World, units: UnitSystem) -> FloatArray:
    """Total angular momentum at the present step; warn if it is not finite."""
    total = world.angular_momentum()
    _warn_if_beyond("angular momentum", float(total.sum()), world, units)
    return total


def _warn_if_beyond(quantity: str, value: float, world: World, units: UnitSystem) -> None:
    """Warn if a quantity is not finite, which is possible even for finite positions and velocities."""
    if math.isfinite(value):
        return
    warn(
        f"the {quantity} at t = {world.time:.6g}{units.suffix('s')} is beyond the range of numbers ({value}): it has "
        'diverged, or particles coincide; take a smaller dt, and the default on_divergence="raise"',
        StabilityWarning,
    )


def frame(world: World, scene: Scene, earlier: Earlier) -> Frame:
    """The present step as a frame, with positions not wrapped into the periodic domain."""
    budget, budgets = audit(world, scene.units, earlier)
    return Frame(
        **vars(engine.snapshot(world, scene)),
        dt=world.dt,
        energy=budget,
        momentum=momentum(world, scene.units),
        angular_momentum=angular_momentum(world, scene.units),
        budgets=budgets,
    )


def present(world: World, scene: Scene, stepper: Stepper) -> Frame:
    """The present step as the user sees it, without means over an interval."""
    sample = _measured(frame(world, scene, stepper.earlier), None, 0.0)
    return replace(engine.shown(sample, scene), dt=stepper.dt)


def frame_count(duration: float, fps: float, units: UnitSystem) -> int:
    """The number of frames of a duration [s], including the first and the last one.

    Raises:
        SceneError: there are too many to count.
    """
    intervals = duration * fps + 1e-6
    if intervals > MOST:
        length, rate = f"{duration:g}{units.suffix('s')}", f"{fps:g} frames per {units.per}"
        raise SceneError(f"duration: {length} at {rate} are more frames than can be counted")
    return math.floor(intervals) + 1


def frames(
    world: World, scene: Scene, stepper: Stepper, duration: float, fps: float, watch: Watch | None = None
) -> Iterator[Frame]:
    """Advance by a duration, and yield a frame at each start + k/fps. The first one is the present state. With a watch,
    advance at most to a terminal event.

    With a given time step, a frame between two steps is a cubic Hermite interpolation of both. With dt="auto" every
    frame is at a step. The steps are the same as without frames. Positions are wrapped into the periodic domain at the
    end, because positions on different sides cannot be interpolated.

    Raises:
        PhyscoreError: the world was advanced by other code between two frames.
    """
    with scene.units.worded():
        yield from _frames(world, scene, stepper, duration, fps, watch)


def _frames(
    world: World, scene: Scene, stepper: Stepper, duration: float, fps: float, watch: Watch | None
) -> Iterator[Frame]:
    """The frames, with errors as of the engine."""
    start = world.time
    count = frame_count(duration, fps, scene.units)
    if stepper.fixed is not None:
        steps_to(duration, stepper.fixed, TIME_TOLERANCE)  # Raises if there are too many to count.
    stepper.warn_if_long(duration)
    sampled = _stepped if stepper.fixed is None else _interpolated
    before: Frame | None = None
    for index, sample in enumerate(sampled(world, scene, stepper, count, fps, watch)):
        time, here = start + index / fps, world.steps
        if watch is not None and watch.stop is not None and time > watch.stop.time + TIME_TOLERANCE * stepper.dt:
            break
        yield replace(engine.shown(_measured(sample, before, fps), scene), time=time, dt=stepper.dt)
        before = sample
        stepper.require_present()
        if world.steps != here:
            raise PhyscoreError(
                f"this simulation took {world.steps - here} steps between two of its frames, which would no longer be "
                "at their times: step it before or after, not meanwhile, and not from another thread"
            )
    left = duration - (world.time - start)
    if left > TIME_TOLERANCE * stepper.dt and not stopped(watch):
        stepper.run(left, fps, watch)
    stepper.settle(watch)


def _measured(sample: Frame, before: Frame | None, fps: float) -> Frame:
    """A frame in which measured fields of fluids are means since the previous frame: differences of their integrals."""
    if not any(integral in sample.fields for integral in GAUGES.values()):
        return sample
    fields = dict(sample.fields)
    for name, integral in GAUGES.items():
        total = fields.pop(integral, None)
        if total is not None and before is not None:
            fields[name] = fps * (total - before.fields[integral])
    return replace(sample, fields=fields)


def _stepped(
    world: World, scene: Scene, stepper: Stepper, count: int, fps: float, watch: Watch | None
) -> Iterator[Frame]:
    """Frames at the steps of a time step that divides the frame interval."""
    for index in range(count):
        if index > 0:
            stepper.run(1.0 / fps, fps, watch)
        yield frame(world, scene, stepper.earlier)


def _interpolated(
    world: World, scene: Scene, stepper: Stepper, count: int, fps: float, watch: Watch | None
) -> Iterator[Frame]:
    """Frames between steps of a given size, without meaning after a terminal event. `before` is the last step at or
    before a frame, `done` the number of the present step.
    """
    dt = stepper.dt
    rates = {info.name: info.rate for info in engine.fields(world, scene)}
    done, before = 0, frame(world, scene, stepper.earlier)
    for index in range(count):
        target = index / (fps * dt)
        nearest = round(target)
        on_step = abs(target - nearest) <= TIME_TOLERANCE
        first = nearest if on_step else math.floor(target)
        if done <= first:
            stepper.step(first - done, watch)
            done, before = first, frame(world, scene, stepper.earlier)
        if on_step:
            yield before
            continue
        if done == first:
            stepper.step(1, watch)
            done += 1
        yield between(before, engine.snapshot(world, scene), target - first, dt, rates)
