"""Diagnosis of runs: common problems, each with its symptom, a measured value and a remedy.

Each symptom is a module with one function, which yields a `Finding` for each case, and has a line in `SYMPTOMS`.
"""

from __future__ import annotations

from physcore.checks import shown, span
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.scene.scene import Scene
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.clumps import clumps
from physcore.studies.diagnosis.coarse import coarse
from physcore.studies.diagnosis.explodes import explodes
from physcore.studies.diagnosis.finding import Diagnosis, Finding
from physcore.studies.diagnosis.jitters import jitters
from physcore.studies.diagnosis.large import large
from physcore.studies.diagnosis.overlapping import overlapping, sinks
from physcore.studies.diagnosis.penetrates import penetrates
from physcore.studies.diagnosis.slow import slow
from physcore.studies.diagnosis.sluggish import sluggish
from physcore.studies.diagnosis.trembles import trembles

__all__ = ["SYMPTOMS", "Diagnosis", "Finding", "diagnose"]

SYMPTOMS = (explodes, sluggish, penetrates, overlapping, sinks, jitters, trembles, clumps, coarse, slow, large)
"""All symptoms, in the order of the report."""


@entrance
def diagnose(run: Recording | Simulation, duration: float | None = None) -> Diagnosis:
    """Diagnose a run: each finding has a symptom, a cause, a remedy and a measured value.

        for finding in pc.diagnose(recording):
            print(finding.symptom, finding.measured, finding.cure)

    A Recording gives the most complete diagnosis. For a Simulation, which is not changed, only the scene and the
    present state are examined.

    Args:
        run: a Recording, or a Simulation.
        duration: the planned duration of a simulation [s]. Then the number of steps is included, and their processing
            time, estimated from a few steps of a copy. None: neither is included.

    Returns:
        Diagnosis: the findings, empty if there are no problems; `print` shows them as text.

    Raises:
        SceneError: the run is neither, or the duration is not above 0.
    """
    if not isinstance(run, (Recording, Simulation)):
        hint = "; write pc.diagnose(pc.Simulation(scene))" if isinstance(run, Scene) else ""
        raise SceneError(f"diagnose.run: must be a Recording or a Simulation, got {shown(run)}{hint}")
    case = Case(run, None if duration is None else span(duration, "diagnose.duration"))
    return Diagnosis(finding for symptom in SYMPTOMS for finding in symptom(case))
