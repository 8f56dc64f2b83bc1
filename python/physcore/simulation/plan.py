"""The plan: what a scene requires, and how it will be computed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physcore.markup import html_table
from physcore.numerics.choices import LimitKind


@dataclass(frozen=True)
class Plan:
    """Exactly the stages that a scene requires, and the choices that were made; `print` it.

        print(pc.Simulation(scene).plan)  # a Plan

    `Simulation.plan` and `Recording.plan` give it.
    """

    stages: tuple[str, ...]
    """The stages of one step, in order."""
    dimension: int
    """2 or 3."""
    precision: str
    """"f32" or "f64": the arithmetic of forces."""
    integrator: str
    """The integrator's name."""
    order: int
    """The order that holds in this scene."""
    evaluations: int
    """Force evaluations per step."""
    pairs: int
    """About how many springs, pairs of particles, and pairs of a particle and a cell of a tree each of them goes
    through, at the start.
    """
    dt: float
    """The time step [s]."""
    dt_limit: float
    """The largest time step that this scene allows [s], as it stands now where dt was given or follows the motion; inf
    where nothing limits it, 0.0 where no step is certain to be stable.
    """
    limit_kind: LimitKind
    """Whether stability or accuracy limits the time step."""
    limit_term: str
    """The term that limits the time step."""
    memory: int
    """Memory of the simulation [bytes]."""
    threads: int
    """Threads that share the work."""
    simd: str
    """The vector instructions in use."""
    layout: str
    """How particles and springs are laid out in memory."""
    left_out: tuple[str, ...]
    """The stages that this scene does not need."""
    notes: tuple[str, ...]
    """Advice."""
    force_error: float = 0.0
    """The error of the accelerations by a tree, rms over rms, measured at the start on up to 1000 particles against the
    exact sum; 0.0 where sums are exact.
    """
    substeps: int = 0
    """How many steps failed and were taken again in parts."""

    @property
    def margin(self) -> float:
        """The time step as a fraction of its limit."""
        return self.dt / self.dt_limit if self.dt_limit > 0 else math.inf

    def _rows(self) -> dict[str, str]:
        """What it says, line by line."""
        rows = {
            "stages": " → ".join(self.stages),
            "dimension": f"{self.dimension}D",
            "precision": self.precision,
            "integrator": f"{self.integrator}, force evaluations per step: {self.evaluations}",
            "order": f"{self.order} in this scene",
            "dt": f"{self.dt:.6g} s, {self._limit()}",
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
        """For notebooks: the same lines as a table."""
        notes = {f"note {number}" if len(self.notes) > 1 else "note": note for number, note in enumerate(self.notes, 1)}
        return html_table([], {name: [text] for name, text in {**self._rows(), **notes}.items()}, "Plan")

    def _limit(self) -> str:
        """One phrase on the limit of the time step."""
        if math.isinf(self.dt_limit):
            return "nothing limits it"
        if self.dt_limit == 0.0:
            return f"no step is certain to be stable ({self.limit_term})"
        return f"{self.margin:.0%} of the {self.limit_kind} limit {self.dt_limit:.6g} s ({self.limit_term})"


def _bytes(size: int) -> str:
    """A size in the unit that suits it."""
    for unit, scale in (("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10)):
        if size >= scale:
            return f"{size / scale:.1f} {unit}"
    return f"{size} bytes"
