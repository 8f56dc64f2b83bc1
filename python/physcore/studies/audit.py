"""Audit of a recording as text: the energy budget and the conserved quantities."""

from __future__ import annotations

from physcore.checks import FloatArray
from physcore.simulation.recording import Recording, contents


def audit(recording: Recording) -> str:
    """A table of the energy budget at the start and at the end, its drift, and the momenta."""
    plan, units = recording.plan, recording.units
    second = units.suffix("s")
    lines = [
        f"{contents(recording.scene)}, {plan.integrator}, {plan.precision}, dt = {plan.dt:.3g}{second}, "
        f"{recording.times[-1] - recording.times[0]:.3g}{second} simulated",
        str(recording.energy),
        *([f"  substeps: {plan.substeps} steps failed and were taken again in parts"] if plan.substeps else []),
        *(
            f"  {name}{f' [{each.unit}]' if each.unit else ''}: {each.total[0]:.6g} → {each.total[-1]:.6g}, "
            f"drift at most {abs(each.drift).max():.1e}"
            for name, each in recording.budgets.items()
        ),
        f"  {units.label('momentum', 'kg·m/s')}: {_vector(recording.momentum[0])} → {_vector(recording.momentum[-1])}",
        f"  {units.label('angular momentum', 'kg·m²/s')}: {_vector(recording.angular_momentum[0])} → "
        f"{_vector(recording.angular_momentum[-1])}",
    ]
    return "\n".join(lines)


def _vector(values: FloatArray) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"
