"""Plan of a simulation: the stages that a scene requires, and the chosen numerics."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physcore.markup import Printed, html_table
from physcore.numerics.choices import LimitKind
from physcore.units.systems import SI, UnitSystem


@dataclass(frozen=True, repr=False)
class Plan(Printed):
    """Plan of a simulation: the stages that the scene requires, and the chosen numerics.

        print(pc.Simulation(scene).plan)  # a Plan

    `Simulation.plan` and `Recording.plan` have it; `print` shows it.
    """

    stages: tuple[str, ...]
    """Stages of one step, in order."""
    dimension: int
    """The dimension of space."""
    precision: str
    """"f32" or "f64": the arithmetic of forces."""
    integrator: str
    """Name of the integrator."""
    order: int
    """Order of the method in this scene."""
    evaluations: int
    """Force evaluations per step."""
    pairs: int
    """Approximate number of springs, particle pairs and particle–cell pairs of a tree per force evaluation, at the
    start.
    """
    dt: float
    """The time step [s]."""
    dt_limit: float
    """Largest time step that this scene allows [s]: inf without a limit, 0.0 if no step is certain to be stable. The
    value is for the present state if dt was given or follows the motion.
    """
    limit_kind: LimitKind
    """Whether stability or accuracy limits the time step."""
    limit_term: str
    """Term of the scene that limits the time step."""
    memory: int
    """Memory of the simulation [bytes]."""
    threads: int
    """Number of threads."""
    simd: str
    """Vector instructions in use."""
    layout: str
    """Memory layout of particles and springs."""
    left_out: tuple[str, ...]
    """Stages that this scene does not need."""
    notes: tuple[str, ...]
    """Notes with advice."""
    force_error: float = 0.0
    """Relative rms error of the accelerations by a tree, measured at the start on up to 1000 particles against the
    exact sum; 0.0 with exact sums.
    """
    substeps: int = 0
    """Number of steps that failed and were repeated in parts."""
    units: UnitSystem = SI
    """Units of the scene."""

    @property
    def margin(self) -> float:
        """The time step as a fraction of its limit."""
        return self.dt / self.dt_limit if self.dt_limit > 0 else math.inf

    def _rows(self) -> dict[str, str]:
        """The lines of the plan, as names and texts."""
        rows = {
            "stages": " → ".join(self.stages),
            "dimension": f"{self.dimension}D",
            "precision": self.precision,
            "integrator": f"{self.integrator}, force evaluations per step: {self.evaluations}",
            "order": f"{self.order} in this scene",
            "dt": f"{self.dt:.6g}{self.units.suffix('s')}, {self._limit()}",
            "tree": f"rms error {self.force_error:.2g} of the accelerations" if self.force_error else "",
            "memory": _bytes(self.memory),
            "threads": f"{self.threads}, {self.simd}",
            "layout": self.layout,
            "substeps": f"{self.substeps} steps failed and were taken again in parts" if self.substeps else "",
            "left out": ", ".join(self.left_out) or "nothing",
        }
        return {name: text for name, text in rows.items() if text}

    def __str__(self) -> str:
        lines = [f"  {name:<11}{text}" for name, text in self._rows().items()]
        return "\n".join(["Plan", *lines, *(f"  {'note':<11}{note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        """The plan as an HTML table, for notebooks."""
        notes = {f"note {number}" if len(self.notes) > 1 else "note": note for number, note in enumerate(self.notes, 1)}
        return html_table([], {name: [text] for name, text in {**self._rows(), **notes}.items()}, "Plan")

    def _limit(self) -> str:
        """A phrase on the limit of the time step."""
        if math.isinf(self.dt_limit):
            return "nothing limits it"
        if self.dt_limit == 0.0:
            return f"no step is certain to be stable ({self.limit_term})"
        limit = f"{self.dt_limit:.6g}{self.units.suffix('s')}"
        return f"{self.margin:.0%} of the {self.limit_kind} limit {limit} ({self.limit_term})"


def _bytes(size: int) -> str:
    """A size in a suitable unit, as text."""
    for unit, scale in (("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10)):
        if size >= scale:
            return f"{size / scale:.1f} {unit}"
    return f"{size} bytes"
