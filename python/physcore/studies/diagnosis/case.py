"""Subject of a diagnosis: a recording or a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from physcore.checks import FloatArray
from physcore.numerics.contacts import ContactSolver
from physcore.numerics.integrators import INTEGRATORS_BY_NAME, Integrator
from physcore.scene.fields import FIELDS, RIGID
from physcore.scene.marks import TURNS
from physcore.scene.scene import Scene
from physcore.simulation.plan import Plan
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation


@dataclass(frozen=True)
class Case:
    """Subject of a diagnosis: a recorded run, or one that is still ahead."""

    run: Recording | Simulation
    duration: float | None
    """Planned duration of a simulation [s]."""

    @property
    def recording(self) -> Recording | None:
        """The recording; None for a simulation."""
        return self.run if isinstance(self.run, Recording) else None

    @property
    def simulation(self) -> Simulation | None:
        """The simulation; None for a recording."""
        return self.run if isinstance(self.run, Simulation) else None

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.run.scene

    @property
    def plan(self) -> Plan:
        """The plan."""
        return self.run.plan

    @property
    def integrator(self) -> type[Integrator]:
        """The integrator."""
        return INTEGRATORS_BY_NAME[self.plan.integrator]

    @property
    def positions(self) -> FloatArray | None:
        """Positions [m], shape (F, N, D), one frame for a simulation; None if they were not recorded."""
        return self._channel("positions")

    @property
    def velocities(self) -> FloatArray | None:
        """Velocities [m/s], likewise."""
        return self._channel("velocities")

    @property
    def rigid(self) -> dict[str, FloatArray] | None:
        """Fields of all rigid bodies by their names in the scene, shape (F, B, …), one frame for a simulation; None if
        there are no rigid bodies, or if their places were not recorded.
        """
        names = [name for name in RIGID if name in self.scene.fields]
        if isinstance(self.run, Recording):
            found = {name: self.run.channels[name] for name in names if name in self.run.channels}
        else:
            bodies = [self.run[body].fields for body in self.scene.bodies if body.is_rigid]
            parts = {name: FIELDS[name].part for name in names}
            found = {name: np.concatenate([own[part] for own in bodies])[None] for name, part in parts.items()}
        return found if {"rigid_positions", TURNS.get(self.scene.dimension)} <= found.keys() else None

    @property
    def begin(self) -> float:
        """Time of the first frame, or the present time of a simulation [s]."""
        return float(self.run.times[0]) if isinstance(self.run, Recording) else self.run.time

    @property
    def solver(self) -> ContactSolver | None:
        """The solver of the contacts of rigid bodies; None without rigid bodies."""
        given = self.run.provenance.numerics.get("contacts")
        return (
            None if given is None else ContactSolver(**cast("dict[str, int]", cast("dict[str, Any]", given)["fields"]))
        )

    def _channel(self, name: str) -> FloatArray | None:
        if not self.scene.bodies:
            return None
        if isinstance(self.run, Recording):
            return self.run.channels.get(name)
        values: FloatArray = getattr(self.run, name)
        return values[None]
