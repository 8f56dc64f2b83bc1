"""Rehearsal of a run: the number of steps that follow the motion, counted ahead in a copy of the world."""

from __future__ import annotations

from physcore.checks import MOST
from physcore.errors import SimulationDiverged
from physcore.numerics.choices import FRAMES_PER_SECOND, free_step
from physcore.simulation import engine
from physcore.simulation.step_size import StepSize

REHEARSED, REHEARSED_WORK, FEWEST = 20_000, 20_000_000, 100
"""Number of steps of a rehearsal, unless these are more steps of single particles than the second number; at least the
third number.
"""

STEADY = 1.5
"""Ratio of two numbers of steps per second up to which they count as equal."""


def steps_ahead(size: StepSize, dt: float, duration: float) -> float | None:
    """The number of steps in a duration [s] from now; None if it is unknown.

    Steps that follow the motion are counted in a rehearsal, in intervals of increasing length. Its mean is used if
    the last two intervals have about the same number of steps per second.

    Args:
        size: size of the steps.
        dt: present time step [s].
        duration: [s].
    """
    rule = size.adaptive
    if rule is None:
        return duration / dt
    world = engine.build(size.scene, size.numerics)
    world.restore(size.world.capture())
    most = max(FEWEST, min(REHEARSED, REHEARSED_WORK // max(1, size.scene.particles)))
    taken, passed, interval, rates = 0, 0.0, 0.5 * dt, [0.0, 0.0]
    try:
        while passed < duration and taken < most:
            interval, before = min(2.0 * interval, duration - passed), world.steps
            course = (world.time, interval, 0, None)
            world.run(course, MOST, rule.safety, free_step(FRAMES_PER_SECOND), rule.tolerance)
            taken, passed = taken + world.steps - before, passed + interval
            rates = [rates[1], (world.steps - before) / interval]
    except SimulationDiverged:
        return None
    steady = passed >= duration or max(rates) <= STEADY * min(rates)
    return taken * duration / passed if steady else None
