"""What is known of a run that is diagnosed."""

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
    """A run, recorded or still ahead."""

    run: Recording | Simulation
    duration: float | None
    """How long a simulation is meant to run [s]."""

    @property
    def recording(self) -> Recording | None:
        """The run where it was recorded."""
        return self.run if isinstance(self.run, Recording) else None

    @property
    def simulation(self) -> Simulation | None:
        """The run where it is ahead."""
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
        """Positions [m], shape (F, N, D), one frame of a simulation; None where they were not recorded."""
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
