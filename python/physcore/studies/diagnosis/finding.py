"""Findings of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from physcore.markup import Printed


@dataclass(frozen=True)
class Finding:
    """Finding: a problem in a run.

        worn = pc.simulate(scene, duration=1.0, integrator="BackwardEuler", dt=0.1)
        for finding in pc.diagnose(worn):  # each is a Finding
            print(finding)

    `diagnose` returns a sequence of findings.
    """

    symptom: str
    """Symptom: "explodes", "sluggish", "penetrates", "overlaps", "sinks", "jitters", "clumps", "scatters", "coarse",
    "slow" or "large".
    """
    cause: str
    """Cause, with the measured value."""
    cure: str
    """Remedy."""
    measured: float
    """Measured value."""

    def __str__(self) -> str:
        return f"{self.symptom}: {self.cause}\n  cure: {self.cure}"


class Diagnosis(Printed, tuple[Finding, ...]):
    """Diagnosis: all findings of a run; `print` shows them as text.

        print(pc.diagnose(recording))  # a Diagnosis

    `diagnose` returns it. A Diagnosis is a tuple, which is empty if there are no problems.
    """

    __slots__ = ()

    def __str__(self) -> str:
        return "\n".join(map(str, self)) or "nothing wrong was found"

    def _repr_html_(self) -> str:
        heads = "".join(f"<th>{head}</th>" for head in ("symptom", "cause", "cure"))
        rows = "".join(
            f"<tr><td>{escape(each.symptom)}</td><td>{escape(each.cause)}</td><td>{escape(each.cure)}</td></tr>"
            for each in self
        )
        return f"<table><tr>{heads}</tr>{rows}</table>" if self else f"<p>{self}</p>"
