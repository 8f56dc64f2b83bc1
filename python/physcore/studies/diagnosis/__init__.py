"""Diagnosis: what goes wrong in a run, by its symptom, with the figure that shows it and the change that cures it.

A symptom is a file with one function, which gives a `Finding` for each case of it, and a line in `SYMPTOMS`.
"""

from __future__ import annotations

from physcore.checks import shown, span
from physcore.errors import SceneError
from physcore.scene.scene import Scene
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.spelling import spelled
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.clumps import clumps
from physcore.studies.diagnosis.explodes import explodes
from physcore.studies.diagnosis.finding import Diagnosis, Finding
from physcore.studies.diagnosis.jitters import jitters
from physcore.studies.diagnosis.large import large
from physcore.studies.diagnosis.penetrates import penetrates
from physcore.studies.diagnosis.slow import slow
from physcore.studies.diagnosis.sluggish import sluggish

__all__ = ["SYMPTOMS", "Diagnosis", "Finding", "diagnose"]

SYMPTOMS = (explodes, sluggish, penetrates, jitters, clumps, slow, large)
"""What is looked for, in the order in which it is told."""


@spelled
def diagnose(run: Recording | Simulation, duration: float | None = None) -> Diagnosis:
    """What goes wrong in a run: each finding has its symptom, its cause, a cure, and the figure that shows it.

        for finding in pc.diagnose(recording):
            print(finding.symptom, finding.measured, finding.cure)

    A recording tells most: what it shows, beside what its scene says. Of a simulation the scene and the present state
    are looked at, before the run. It is not changed.

    Args:
        run: a Recording, or a Simulation.
        duration: how long a simulation is meant to run [s], for the number of its steps and the time that they take,
            for which a copy of it takes a few; None: nothing is said of these.

    Returns:
        The findings, none where all is well; `print` shows them in words.

    Raises:
        SceneError: it is neither, or the duration is not above 0.
    """
    if not isinstance(run, (Recording, Simulation)):
        hint = "; write pc.diagnose(pc.Simulation(scene))" if isinstance(run, Scene) else ""
        raise SceneError(f"diagnose.run: must be a Recording or a Simulation, got {shown(run)}{hint}")
    case = Case(run, None if duration is None else span(duration, "diagnose.duration"))
    return Diagnosis(finding for symptom in SYMPTOMS for finding in symptom(case))
