"""Warnings about steps: unstable or many ones, a drift of the energy, Mach numbers, and steps taken in parts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from physcore.arithmetic import power
from physcore.errors import MachWarning, SceneWarning, SimulationDiverged, StabilityWarning, warn
from physcore.numerics.choices import AdaptiveStep, Limit, StepRule
from physcore.simulation import engine
from physcore.simulation.effort import ENCOUNTER_CURE, MOST_STEPS, is_encounter, long_run
from physcore.simulation.energy import BROKEN_DRIFT, FAIR_DRIFT, WRONG_DRIFT
from physcore.simulation.rehearsal import steps_ahead
from physcore.simulation.step_size import StepSize

FIRST = 100
"""Number of steps before a drift with a given time step is warned of."""

COARSE = 25.0
"""Ratio of a given time step to the limit of accuracy above which it is warned of: a quarter of a turn in a step."""

FAST_SHARE = 0.02
"""Fraction of a fluid's particles that may exceed the Mach number without a warning, as spray and the tips of jets do
at any speed of sound. They are thin and have free surfaces, so that their density hardly changes.
"""

_UNWARNED = ContextVar("unwarned", default=False)


@contextmanager
def unwarned() -> Iterator[None]:
    """Suppress warnings, for runs whose time step the package itself chooses in order to measure the result."""
    token = _UNWARNED.set(True)
    try:
        yield
    finally:
        _UNWARNED.reset(token)


class StepWarnings:
    """Warnings about the steps of a run, in the units of its scene; those of length and Mach numbers once in a run."""

    def __init__(self, size: StepSize) -> None:
        self._size = size
        self._mach_warned = False
        self._long_warned = False

    def of_instability(self, dt: float) -> None:
        """Warn of a given time step [s] that may be unstable, or that does not resolve the motion."""
        world, integrator = self._size.world, self._size.numerics.integrator
        if _UNWARNED.get():
            return
        # The certified limit is smaller and much faster to compute.
        if dt <= engine.certified(world):
            return
        limit = engine.limit(world)
        if dt <= limit.stability:
            if limit.kind == "accuracy" and dt > COARSE * limit.accuracy and not integrator.stiff:
                self._warn(
                    f"dt = {dt:g} s is {dt / limit.accuracy:.2g} times the limit of accuracy in this scene, "
                    f"{limit.accuracy:g} s ({limit.term}): the motion is not resolved",
                    StabilityWarning,
                )
            return
        self._warn(_instability(dt, limit, type(integrator).__name__), StabilityWarning)

    def of_length(self, duration: float, dt: float) -> None:
        """Warn if a duration [s] takes more steps than are probably intended; the present step is `dt` [s]."""
        if self._long_warned or duration <= MOST_STEPS * dt or _UNWARNED.get():
            return
        steps = steps_ahead(self._size, dt, duration)
        if steps is None:
            return
        given = self._size.fixed is not None
        message = long_run(duration, duration / steps, "" if given else self._size.limit.term, given)
        if message is not None:
            self._long_warned = True
            self._warn(message, SceneWarning)

    def of_drift(self, drift: float, dt: float) -> None:
        """Warn of a large drift of the energy balance over a whole run; with a given time step, of a very large one.

        Methods for stiff motion lose energy by choice. The energy in motion of the first steps from rest is no scale.

        Args:
            drift: relative drift.
            dt: present time step [s].
        """
        size = self._size
        allowed = WRONG_DRIFT if size.fixed is None else BROKEN_DRIFT if size.world.steps > FIRST else math.inf
        # NaN, beyond the range of numbers, has a warning of its own.
        if not drift > allowed or size.numerics.integrator.stiff or _UNWARNED.get():
            return
        self._warn(
            f"the energy balance drifted by {drift:.2g} of the energy in motion: the motion is not resolved; "
            f"{_finer(size, drift, dt)}, and see pc.diagnose(recording)",
            StabilityWarning,
        )

    def of_mach_number(self, mach: float, share: float, sound: float) -> None:
        """Warn if too large a share of a fluid exceeds a Mach number; `sound` is the speed of sound [m/s]."""
        if self._mach_warned or share <= FAST_SHARE:
            return
        self._mach_warned = True
        message = (
            f"{share:.1%} of a fluid's particles are faster than Mach {mach} where sound has {sound:.3g} m/s: there "
            f"density is off by about Mach squared, {mach * mach:.1%} and more, and one percent is meant; raise "
            "sound_speed in fluids=pc.WeaklyCompressible(…)"
        )
        self._warn(message, MachWarning)

    def of_parts(self, error: SimulationDiverged) -> None:
        """Warn that a failed step is taken again in parts."""
        self._warn(
            f"at {error.time:.4g} s a step failed ({error.cause}) and is taken again in parts; take a smaller dt where "
            "this happens often",
            StabilityWarning,
        )

    def of_halves(self, rule: AdaptiveStep) -> None:
        """Warn that a step that follows the motion was halved."""
        cause = "safety" if rule.tolerance is None else "tolerance"
        self._warn(f"a step that follows the motion diverged and was halved: take a smaller {cause}", StabilityWarning)

    def _warn(self, message: str, category: type[Warning]) -> None:
        """Warn in the scene's units."""
        warn(self._size.scene.units.reworded(message), category)


def _instability(dt: float, limit: Limit, name: str) -> str:
    """The message about a given time step [s] above the limit of stability of an integrator."""
    if limit.endured == 0.0:
        return f"{name} is not stable at any time step in this scene ({limit.term}): its energy grows without end"
    if dt > limit.endured:
        return (
            f"dt = {dt:g} s is above the limit of stability of {name} in this scene, {limit.stability:g} s "
            f"({limit.term}): the simulation will blow up"
        )
    return (
        f"dt = {dt:g} s is above the limit of stability that is certain for {name} in this scene, "
        f"{limit.stability:g} s ({limit.term}): the simulation may blow up; the true limit may be "
        f"{_how_much_larger(limit)}, `stability_limit(scene, {name}(), measured=True)` finds it"
    )


def _how_much_larger(limit: Limit) -> str:
    """The ratio of the possible limit of stability to the certain one, as text."""
    if limit.stability == 0.0 or math.isinf(limit.endured):
        return "larger"
    return f"up to {limit.endured / limit.stability:.3g} times as large"


def _finer(size: StepSize, drift: float, dt: float) -> str:
    """Advice for a fair drift, from drift ∝ dt^order."""
    rule, order, limit = size.numerics.dt, max(1, size.numerics.integrator.order), size.limit
    if is_encounter(limit.term, limit.kind) and not isinstance(rule, AdaptiveStep):
        return ENCOUNTER_CURE
    factor = float(power(FAIR_DRIFT / min(drift, 1.0), 1.0 / order))
    if not isinstance(rule, StepRule) or math.isinf(limit.dt):
        return f"take dt={factor * dt:.1g}"
    if isinstance(rule, AdaptiveStep) and rule.tolerance is not None:
        return f"take dt=pc.AdaptiveStep(tolerance={0.01 * rule.tolerance:.1g})"
    # Steps may be shorter than the rule asks for, where frames are near each other.
    safety = rule.safety if isinstance(rule, AdaptiveStep) else min(rule.safety, dt / limit.dt)
    method = type(size.numerics.integrator).__name__
    return f'take integrator="{method}" and dt=pc.{type(rule).__name__}(safety={factor * safety:.1g})'
