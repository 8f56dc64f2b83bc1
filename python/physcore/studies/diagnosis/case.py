"""Subject of a diagnosis: a recording or a simulation."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.checks import FloatArray
from physcore.numerics.integrators import INTEGRATORS_BY_NAME, Integrator
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

    def _channel(self, name: str) -> FloatArray | None:
        if not self.scene.bodies:
            return None
        if isinstance(self.run, Recording):
            return self.run.channels.get(name)
        values: FloatArray = getattr(self.run, name)
        return values[None]
