"""Findings of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape


@dataclass(frozen=True)
class Finding:
    """Something that goes wrong in a run.

        worn = pc.simulate(scene, duration=1.0, integrator="BackwardEuler", dt=0.1)
        for finding in pc.diagnose(worn):  # each is a Finding
            print(finding)

    `diagnose` gives a sequence of them.
    """

    symptom: str
    """What it looks like: "explodes", "sluggish", "penetrates", "jitters", "clumps", "scatters", "slow" or
    "large"."""
    cause: str
    """Why, with the figure that shows it."""
    cure: str
    """What to change."""
    measured: float
    """The figure."""

    def __str__(self) -> str:
        return f"{self.symptom}: {self.cause}\n  cure: {self.cure}"


class Diagnosis(tuple[Finding, ...]):
    """All findings of a run, in words where it is printed.

        print(pc.diagnose(recording))  # a Diagnosis

    `diagnose` gives it; it is a tuple, which is empty where all is well.
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
