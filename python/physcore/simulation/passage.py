"""Passages of a simulation: the states at both ends of its last step, for pictures at any time in between."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from physcore.scene.fields import GAUGES
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.energy import Energy
from physcore.simulation.simulation import Simulation
from physcore.simulation.state import Snapshot
from physcore.simulation.stepper import TIME_TOLERANCE
from physcore.simulation.within import between

COARSE = 0.25
"""Least step, as a fraction of the time between two pictures, that is interpolated in. Shorter ones are not seen."""


@dataclass(frozen=True, eq=False)
class Passage:
    """The last step of a simulation. Positions are not wrapped into the periodic domain."""

    before: Snapshot
    """State at its start; with steps that are not interpolated in, that at its end."""
    after: Snapshot
    """State at its end."""
    rates: Mapping[str, str | None]
    """The name of the rate of change of each field, or None."""
    energy: Energy | None
    """Energy budget at the end, if it was asked for."""

    def at(self, time: float, scene: Scene) -> Snapshot:
        """The state at a time [s], or at the nearest end of the step, as the user of a scene sees it."""
        length = self.after.time - self.before.time
        part = min(max((time - self.before.time) / length, 0.0), 1.0) if length > 0.0 else 1.0
        if part == 1.0:
            state = self.after
        else:
            state = replace(
                between(self.before, self.after, part, length, self.rates), time=self.before.time + part * length
            )
        return engine.shown(replace(state, scene=scene), scene)


class Course:
    """A simulation that advances piece by piece.

    Args:
        simulation: the simulation. Nothing else may change it between two pieces without a call of `begin`.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._last: Snapshot | None = None

    def begin(self) -> None:
        """Forget the last step, after the state was changed."""
        self._last = None

    def present(self, *, audited: bool) -> Passage:
        """The present state, as a passage of no length; `audited`: with its energy."""
        self._last = self._state()
        return self._passage(self._last, audited=audited)

    def advance(self, duration: float, *, audited: bool) -> Passage:
        """Advance by at least a duration [s], and by a step or more; adaptive steps end exactly there.

        Raises:
            SimulationDiverged, SceneError: as `Simulation.step`.
        """
        simulation = self._simulation
        if simulation._numerics.adaptive is not None:
            simulation.run(duration)
            return self.present(audited=audited)
        dt = simulation.dt
        steps = max(1, math.ceil(duration / dt - TIME_TOLERANCE))
        if dt < COARSE * duration:
            simulation.step(steps)
            return self.present(audited=audited)
        if steps > 1:
            simulation.step(steps - 1)
            self._last = None
        before = self._state() if self._last is None else self._last
        simulation.step()
        self._last = self._state()
        return self._passage(before, audited=audited)

    def _passage(self, before: Snapshot, *, audited: bool) -> Passage:
        assert self._last is not None  # The caller has just set it.
        rates = {info.name: info.rate for info in engine.fields(self._simulation._world, self._simulation.scene)}
        return Passage(before, self._last, rates, self._simulation.energy() if audited else None)

    def _state(self) -> Snapshot:
        """The present state without time integrals, which belong to frames at equal intervals."""
        state = engine.snapshot(self._simulation._world, self._simulation.scene)
        return replace(
            state, fields={name: values for name, values in state.fields.items() if name not in GAUGES.values()}
        )
