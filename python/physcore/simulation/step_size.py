"""Size of steps: the given time step, or the one that a rule chooses from the limit of stability."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace

from physcore._core import World
from physcore.numerics.choices import FRAMES_PER_SECOND, Limit, Numerics, StepRule, largest_step
from physcore.scene.scene import Scene
from physcore.simulation import engine

CHECK_INTERVAL = 256
"""Number of steps between two checks of the limit of stability with dt="auto". Checks are at multiples of this number,
so that the bits do not depend on how the steps are requested.
"""

SHORT_CHECK_INTERVAL = 8
"""Number of steps between two checks of the limit with a fluid or a reaction.

At a tenth of the speed of sound and half of the limit, no particle of a fluid moves farther than a spacing in this
time. A check costs a reaction a few percent.
"""

RESOLVED_CHECK_INTERVAL = 16
"""Number of steps between two checks where oscillations are resolved: one or two periods of the fastest."""

FEW_CELLS = 10_000
"""Number of cells up to which the limit of a reaction is checked in each step, to resolve the fastest spikes."""

RECOVERED = 1.25
"""Factor by which the limit must rise before the time step follows it."""

SLOWEST = 64
"""Largest ratio of the initial time step to a later one. A spring compressed to zero length has no direction, and no
time step resolves it.
"""

_UNDIVIDED = ContextVar("undivided", default=False)


@contextmanager
def undivided() -> Iterator[None]:
    """Never divide steps among systems, for runs that measure which steps are stable."""
    token = _UNDIVIDED.set(True)
    try:
        yield
    finally:
        _UNDIVIDED.reset(token)


class StepSize:
    """Size of the steps of a world, given or chosen from the limit of stability.

    The limit is that of the springs in their present directions. The certified limit is lower, and valid for all
    directions, as long as no spring is shorter than half its rest length. No automatic time step exceeds it. With
    dt="auto" the certified limit is checked periodically. A time step above it is replaced by a smaller one, and is
    restored when the limit rises again.

    A given time step is divided by each of several systems whose own limit is smaller: the engine then finds how many
    substeps that system takes, and the limits here are those of the divided step.
    """

    def __init__(self, world: World, scene: Scene, numerics: Numerics) -> None:
        self.world = world
        self.scene = scene
        self.numerics = numerics
        self.adaptive = numerics.adaptive
        """The rule of steps that follow the motion, or None."""
        self.varies = engine.limit_varies(world)
        """Whether the limit depends on the state."""
        self._limits: tuple[Limit, Limit] | None = None
        """The initial limit, and the limit that the present time step obeys; None unless dt="auto"."""
        self._interval = _check_interval(scene, numerics)

    def begin(self) -> None:
        """Find the limits before the first step, and divide a given one.

        Raises:
            SceneError: no time step is certain to be stable.
        """
        if self.fixed is not None:
            if not _UNDIVIDED.get():
                self.world.divide(self.fixed)
            return
        if self.adaptive is None:
            self._limits = (engine.limit(self.world),) * 2
        self.largest(FRAMES_PER_SECOND)  # Raises for a scene without any stable step.

    @property
    def fixed(self) -> float | None:
        """The given time step [s], or None."""
        return None if isinstance(self.numerics.dt, StepRule) else self.numerics.dt

    @property
    def limit(self) -> Limit:
        """The limit of the time step; of the present state if the step follows the motion or was given."""
        if self.adaptive is not None:
            return engine.present_limit(self.world)
        return self._limits[1] if self._limits else engine.limit(self.world)

    @property
    def limits(self) -> tuple[Limit, ...]:
        """The initial limit, and the limit that the present time step obeys; none unless dt="auto"."""
        return self._limits or ()

    def restore(self, limits: Sequence[Limit]) -> None:
        """Restore `limits`."""
        if limits:
            first, kept = limits
            self._limits = first, kept

    def largest(self, fps: float) -> float:
        """The largest time step [s] that the rule allows for frames at a rate [1/s]."""
        rule = self.numerics.dt
        assert isinstance(rule, StepRule)
        return largest_step(self.limit, rule, self.numerics.integrator, fps)

    def until_check(self) -> int:
        """The number of steps until the next check of the limit."""
        return self._interval - self.world.steps % self._interval if self.varies else sys.maxsize

    def check(self, dt: float) -> bool:
        """Check the limit if due, and return whether the present time step [s] has to change."""
        if not self.varies or self.world.steps == 0 or self.world.steps % self._interval != 0:
            return False
        assert self._limits
        first, kept = self._limits
        fallen = kept.kept / RECOVERED if self.numerics.resolves else dt
        # NaN, and so no change, where a function of the user's is not finite nearby: the step itself will say so.
        certified = engine.certified(self.world)
        if kept != first and certified >= first.kept:
            kept = first
        elif certified < fallen or (kept != first and certified >= RECOVERED * kept.kept):
            present = engine.limit(self.world)
            # Without an initial limit, as for grains that do not touch yet, there is no lower bound of the time step.
            least = first.dt / SLOWEST if math.isfinite(first.dt) and present.term == "springs" else 0.0
            kept = replace(present, dt=max(present.dt, least), certified=max(present.certified, least))
        else:
            return False
        self._limits = first, kept
        return True


def _check_interval(scene: Scene, numerics: Numerics) -> int:
    """The number of steps between two checks of the limit."""
    if numerics.resolves:
        return RESOLVED_CHECK_INTERVAL
    cells = [sum(system.elements.values()) for system in scene.systems if system.has_varying_limit]
    if cells and max(cells) <= FEW_CELLS:
        return 1
    return SHORT_CHECK_INTERVAL if cells or scene.fluids else CHECK_INTERVAL
