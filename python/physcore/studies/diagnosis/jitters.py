"""Jitters: a network that trembles faster than a film shows, where it should have come to rest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore.scene.bodies import SpringNetwork
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

REVERSED = 0.35
"""Share of the kinetic energy whose velocity reverses from frame to frame, above which motion is not resolved: an
oscillation of n frames has sin²(π/n), which is this for five of them; velocities without memory have a half."""
VISIBLE = 2e-3
"""Jumps from frame to frame, over the extent of the body, that are seen: a pixel where it is 500 wide."""
FEWEST_FRAMES = 10
"""Frames below which nothing is said."""
FEWEST_SPRINGS = 16
"""Springs below which a network is an oscillator whose motion is meant, and no cloth."""


def jitters(case: Case) -> Iterator[Finding]:
    """Velocities that turn around from frame to frame, in the last third of a recording."""
    if case.recording is None or case.positions is None or case.velocities is None:
        return
    late = slice(2 * len(case.recording) // 3, None)
    if len(case.recording.times[late]) < FEWEST_FRAMES:
        return
    for index, body in enumerate(case.scene.bodies):
        if not isinstance(body, SpringNetwork) or len(body.pairs) < FEWEST_SPRINGS:
            continue
        part = case.scene.slice(index)
        positions, velocities = case.positions[late, part], case.velocities[late, part]
        mass = body.mass[np.newaxis, :, np.newaxis]
        # Without the motion of the whole: what falls or flies turns around together.
        inner = velocities - (mass * velocities).sum(axis=1, keepdims=True) / body.mass.sum()
        energy = float((mass * (inner[1:] ** 2 + inner[:-1] ** 2)).sum())
        share = float((mass * np.diff(inner, axis=0) ** 2).sum()) / (2.0 * energy) if energy > 0.0 else 0.0
        jumps = np.sqrt(np.mean(np.diff(positions, n=2, axis=0) ** 2) * body.dimension) / 2.0
        extent = float(np.ptp(positions, axis=(0, 1)).max())
        if share > REVERSED and jumps > VISIBLE * extent:
            cause = (
                f"{share:.0%} of the kinetic energy in {case.scene.path(index)} turns around from one frame to the "
                f"next, in jumps of {jumps:.2g} m, where it should be at rest"
            )
            yield Finding("jitters", cause, _cure(body), share)


def _cure(body: SpringNetwork) -> str:
    """More damping, as a share of what is critical: at a ratio of 0.05 an oscillation is gone after ten swings."""
    stiff = np.isfinite(body.stiffness) & (body.stiffness > 0.0)
    critical = (
        2.0 * np.sqrt(float(np.median(body.stiffness[stiff])) * float(np.median(body.mass)) / 2.0)
        if stiff.any()
        else 0.0
    )
    much = f"damping={0.05 * critical:.2g} or more for its springs"
    return f"give {much}, and bend_stiffness or pc.Dihedral where it folds" if len(body.faces) else f"give {much}"
