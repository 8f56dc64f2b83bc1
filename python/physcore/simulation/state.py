"""The state of particles at one time: positions, velocities and fields."""

from __future__ import annotations

from dataclasses import dataclass, field

from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.simulation.energy import Energy


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Positions and velocities at one time, and what fluids have beside them; its arrays are copies."""

    time: float
    """[s]"""
    positions: FloatArray
    """[m], shape (N, D); within the periodic domain."""
    velocities: FloatArray
    """[m/s], shape (N, D)."""
    fields: dict[str, FloatArray] = field(default_factory=dict, kw_only=True)
    """Densities and pressures by name, each of shape (N,), where there is a fluid."""

    @property
    def densities(self) -> FloatArray:
        """[kg/m³], shape (N,); not a number for particles that are not a fluid's."""
        return self._field("densities")

    @property
    def pressures(self) -> FloatArray:
        """[Pa], shape (N,); not a number for particles that are not a fluid's."""
        return self._field("pressures")

    def _field(self, name: str) -> FloatArray:
        if name not in self.fields:
            raise SceneError(f"{name}: only a Fluid has them")
        return self.fields[name]


@dataclass(frozen=True, eq=False)
class Frame(Snapshot):
    """A snapshot at a frame's time, with the audit of the last step at or before it."""

    dt: float
    """The time step in use [s]."""
    energy: Energy
    """The energy budget; `energy.time` is the time of its step."""
    momentum: FloatArray
    """Total momentum [kg·m/s], shape (D,)."""
    angular_momentum: FloatArray
    """Total angular momentum about the origin [kg·m²/s], shape (1,) in 2D and (3,) in 3D."""
