"""Symptom "jitters": a network oscillates faster than the frame rate resolves, where it should be at rest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore.scene.bodies import SpringNetwork
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

REVERSED = 0.35
"""Largest fraction of the kinetic energy whose velocity reverses between frames. An oscillation with a period of n
frames has sin²(π/n), which is this value for five frames. Uncorrelated velocities have a half.
"""
VISIBLE = 2e-3
"""Smallest visible jump between frames, relative to the extent of the body: one pixel for an extent of 500 pixels."""
DAMPED = 0.25
"""Damping ratio of a spring between two particles in a cure. The ratio of a mode of the mesh is in proportion to its
frequency. At a fifth of the frequency it is 0.05. An oscillation has then decayed after ten periods.
"""
FEWEST_FRAMES = 10
"""Least number of frames for a finding."""
FEWEST_SPRINGS = 16
"""Least number of springs for a finding. Smaller networks are oscillators whose motion is intended."""


def jitters(case: Case) -> Iterator[Finding]:
    """Find velocities that reverse from frame to frame, in the last third of a recording."""
    if case.recording is None or case.positions is None or case.velocities is None:
        return
    late = slice(2 * len(case.recording) // 3, None)
    if len(case.recording.times[late]) < FEWEST_FRAMES:
        return
    for body in case.scene.networks:
        if len(body.pairs) < FEWEST_SPRINGS:
            continue
        part = case.scene.slice(body)
        positions, velocities = case.positions[late, part], case.velocities[late, part]
        mass = body.mass[np.newaxis, :, np.newaxis]
        # Relative to the center of mass, whose velocity may reverse too.
        inner = velocities - (mass * velocities).sum(axis=1, keepdims=True) / body.mass.sum()
        energy = float((mass * (inner[1:] ** 2 + inner[:-1] ** 2)).sum())
        share = float((mass * np.diff(inner, axis=0) ** 2).sum()) / (2.0 * energy) if energy > 0.0 else 0.0
        jumps = np.sqrt(np.mean(np.diff(positions, n=2, axis=0) ** 2) * body.dimension) / 2.0
        extent = float(np.ptp(positions, axis=(0, 1)).max())
        if share > REVERSED and jumps > VISIBLE * extent:
            cause = (
                f"{share:.0%} of the kinetic energy in {case.scene.path(body)} turns around from one frame to the "
                f"next, in jumps of {jumps:.2g}{case.scene.units.suffix('m')}, where it should be at rest"
            )
            yield Finding("jitters", cause, _cure(body), share)


def _cure(body: SpringNetwork) -> str:
    """A remedy by more damping."""
    stiff = np.isfinite(body.stiffness) & (body.stiffness > 0.0)
    critical = (
        2.0 * np.sqrt(float(np.median(body.stiffness[stiff])) * float(np.median(body.mass)) / 2.0)
        if stiff.any()
        else 0.0
    )
    damping = max(DAMPED * critical, 2.0 * float(np.median(body.damping)))
    if damping > critical > 0.0:
        return "take a smaller stiffness, or bend_stiffness and pc.Dihedral: its springs are damped enough"
    much = f"damping={damping:.2g} or more for its springs"
    return f"give {much}, and bend_stiffness or pc.Dihedral where it folds" if len(body.faces) else f"give {much}"
