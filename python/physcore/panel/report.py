"""Reports of a panel: what the page shows beside the picture, as plain values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from physcore.errors import PhyscoreError
from physcore.simulation.energy import Energy
from physcore.simulation.simulation import Simulation

COLUMNS = ("time", "kinetic", "potential", "total", "balance", "drift")
"""Columns of the curve of energy."""


@dataclass(frozen=True, eq=False)
class Report:
    """State of a panel beside the picture."""

    time: float
    """Simulated time [s]."""
    steps: int
    """Number of steps."""
    playing: bool
    speed: float
    """Asked seconds of the simulation per second."""
    pace: float | None
    """Reached speed over the asked one, or None."""
    values: dict[str, Any]
    """Values of the controls."""
    note: str
    """Effect of the last change."""
    error: str
    """Reason for which something failed, or empty."""
    plan: dict[str, Any]
    """Time step and limit, from `plan_of`."""
    epoch: int
    """Number of restarts."""
    rows: list[list[float]]
    """New rows of the curve of energy, in the order of COLUMNS."""

    def content(self) -> dict[str, Any]:
        """The report for JSON, which has no numbers beyond the finite ones."""
        content = {"kind": "report", **vars(self)}
        content["rows"] = [[_finite(value) for value in row] for row in self.rows]
        return content


def energy_row(energy: Energy, drift: float) -> list[float]:
    """A row of the curve of energy."""
    return [energy.time, energy.kinetic, energy.potential + energy.internal, energy.total, energy.balance, drift]


def plan_of(simulation: Simulation) -> dict[str, Any]:
    """The time step with its limit; of a limit that cannot be told, the reason."""
    try:
        plan = simulation.plan
    except PhyscoreError as error:
        return {"dt": _finite(simulation.dt), "limit": None, "term": str(error), "over": False, "unit": ""}
    return {
        "dt": _finite(plan.dt),
        "limit": _finite(plan.dt_limit),
        "kind": plan.limit_kind,
        "term": plan.limit_term,
        # Rounding, and steps that end exactly where an interval ends, are not above the limit.
        "over": bool(plan.dt > plan.dt_limit * (1.0 + 1e-9)),
        "integrator": plan.integrator,
        "stages": " → ".join(plan.stages),
        "unit": plan.units.symbol("s"),
        "energy": plan.units.symbol("J"),
    }


def _finite(value: float) -> float | None:
    """A number, or None in place of one that JSON cannot represent."""
    return value if math.isfinite(value) else None
