"""Symptom "sluggish": oscillations are overdamped, by the springs or by the method."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.bodies import SpringNetwork
from physcore.simulation.energy import WRONG_DRIFT
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.explodes import is_loss, worst_drift
from physcore.studies.diagnosis.finding import Finding

OVERDAMPED = 3.0
"""Damping ratio ζ above which springs relax slowly. Their rate ω (ζ − √(ζ² − 1)) is 0.17 ω at 3, a sixth of the rate at
critical damping.
"""


def sluggish(case: Case) -> Iterator[Finding]:
    """Check the damping ratios of springs, and the numerical damping of the method."""
    for body in case.scene.networks:
        if len(body.pairs):
            ratio = float(np.median(_damping_ratios(body)))
            if ratio > OVERDAMPED:
                cause = (
                    f"the springs of {case.scene.path(body)} have a damping ratio of {ratio:.3g}, and 1 is critical: "
                    "they creep back instead of swinging"
                )
                cure = f"divide damping by {ratio:.2g} or more: {ratio:.2g} times less is critical damping"
                yield Finding("sluggish", cause, cure, ratio)
    if case.recording is None:
        return
    drift = worst_drift(case.recording)
    if abs(drift) > WRONG_DRIFT and is_loss(case, drift):
        cause = (
            f"{case.plan.integrator} itself took {-drift:.2g} of the energy in motion, which is no damping of the scene"
        )
        yield Finding("sluggish", cause, "take a smaller dt, or pc.VelocityVerlet(), which takes none", -drift)


def _damping_ratios(body: SpringNetwork) -> FloatArray:
    """Damping ratios ζ = c/(2√(k m)) of single springs, m the reduced mass of their ends; 0 for immobile springs."""
    inverse = np.where(body.fixed, 0.0, 1.0 / body.mass)[body.pairs].sum(axis=1)
    springs = (inverse > 0.0) & (body.damping > 0.0) & (body.stiffness > 0.0) & np.isfinite(body.stiffness)
    ratios = np.zeros(len(body.pairs))
    ratios[springs] = 0.5 * body.damping[springs] * np.sqrt(inverse[springs] / body.stiffness[springs])
    return ratios
