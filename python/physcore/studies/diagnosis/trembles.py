"""Symptom "jitters" of rigid bodies: they stay in place, and their velocities turn around from frame to frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

import numpy as np

from physcore.arithmetic import lengths
from physcore.scene.marks import gyrations, mark_velocities, marks
from physcore.scene.rigid import RigidBodies
from physcore.scene.scene import Scene
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding
from physcore.studies.diagnosis.jitters import FEWEST_FRAMES, REVERSED, VISIBLE

BOUNCY = 0.5
"""Restitution from which on it is the cause. Bounces then last for more than three times the first one."""
STAYS = 0.25
"""Largest range of the positions of a body at rest, relative to its radius of gyration."""


def trembles(case: Case) -> Iterator[Finding]:
    """Find rigid bodies that stay in place and tremble, in the last third of a recording."""
    fields, recording = case.rigid, case.recording
    if fields is None or recording is None or not {"rigid_velocities", "angular_velocities"} <= fields.keys():
        return
    late = slice(2 * len(recording) // 3, None)
    if len(recording.times[late]) < FEWEST_FRAMES:
        return
    scene = case.scene
    parts = {name: values[late] for name, values in fields.items()}
    shape = (len(recording.times[late]), scene.dimension, -1, scene.dimension)  # frames, marks, bodies, components
    places, rates = marks(scene, parts).reshape(shape), mark_velocities(scene, parts).reshape(shape)
    size = gyrations(scene)
    fixed = np.concatenate([body.fixed for body in scene.bodies if body.is_rigid])
    stays = (lengths(np.ptp(places, axis=0)).max(axis=0) < STAYS * size) & ~fixed
    turned = (np.diff(rates, axis=0) ** 2).sum(axis=(0, 1, 3))
    whole = 2.0 * (rates[1:] ** 2 + rates[:-1] ** 2).sum(axis=(0, 1, 3))
    share = np.divide(turned, whole, out=np.zeros(len(size)), where=whole > 0.0)
    jumps = np.sqrt(np.mean(np.diff(places, n=2, axis=0) ** 2, axis=(0, 1, 3)) * scene.dimension) / 2.0
    restless = stays & (share > REVERSED) & (jumps > VISIBLE * 2.0 * size)
    if restless.any():
        worst = int(np.argmax(np.where(restless, jumps / size, 0.0)))
        count = int(restless.sum())
        others = f"; so do {count - 1} others of {len(size)}" if count > 1 else ""
        cause = (
            f"{_path(scene, worst)} stays in place, and {share[worst]:.0%} of its kinetic energy turns around from one "
            f"frame to the next, in jumps of {jumps[worst]:.2g}{scene.units.suffix('m')}{others}"
        )
        yield Finding("jitters", cause, _cure(case), float(share[worst]))


def _path(scene: Scene, index: int) -> str:
    """The path of a rigid body, by its index among all of the scene."""
    bodies = [body for body in scene.bodies if body.is_rigid]
    for body in bodies:
        if index < len(body):
            break
        index -= len(body)
    path = str(scene.path(scene.index(body)))
    return path if len(body) == 1 else f"{path}[{index}]"


def _cure(case: Case) -> str:
    """A remedy: less restitution, or more substeps and sweeps."""
    given = [cast("RigidBodies", body).restitution.max(initial=0.0) for body in case.scene.bodies if body.is_rigid]
    most = float(max(*given, *(boundary.restitution for boundary in case.scene.boundaries), 0.0))
    if most > BOUNCY:
        return f"take a restitution of {0.5 * most:.2g} or less, of bodies and boundaries"
    shorter = f"dt={0.5 * case.plan.dt:.2g}"
    if case.solver is None:
        return f"take {shorter}"
    solver = f"substeps={2 * case.solver.substeps}, iterations={2 * case.solver.iterations}"
    return f"take contacts=pc.ContactSolver({solver}), or {shorter}"
