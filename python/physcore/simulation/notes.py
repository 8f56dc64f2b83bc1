"""Notes of a plan on probable mistakes, found in a scene before the run or in its recording afterward."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import numpy as np

from physcore.arithmetic import along_own_axes, dots, lengths, row_space
from physcore.checks import FloatArray, Vector
from physcore.numerics.choices import Numerics
from physcore.scene.fluid import Fluid
from physcore.scene.items import Boundary
from physcore.scene.marks import gyrations
from physcore.scene.scene import Scene
from physcore.simulation.energy import FAIR_DRIFT, verdict
from physcore.simulation.gaps import narrow
from physcore.simulation.recording import Recording

ROWS = 6
"""Number of rows of particles across a fluid below which sloshing loses more than 5 % of its amplitude in a period."""

MANY = 20_000
"""Number of particles from which the principal axes of a fluid are found."""

UNSEEN = 1e-6
"""Motion during a run that nobody sees, relative to the extent of the bodies."""

SUNK = 0.02
"""Overlap at rest that is barely seen, relative to the size of a rigid body: one pixel of a body 100 pixels wide."""

ROUNDING = 1e-12
"""Tolerance of a plane, relative to the extent of a body."""


def noted(recording: Recording) -> Recording:
    """A recording whose plan includes the notes on the recording."""
    notes = (*recording.plan.notes, *_drift(recording), *_untouched(recording))
    return replace(recording, plan=replace(recording.plan, notes=notes))


def material_drift(recording: Recording) -> float:
    """The largest relative drift of the energy balance; 0 where it is of no account.

    A change of the balance is of no account if it is rounding, or below the energy of a motion by a millionth of the
    extent of the bodies during the run: in a stack at rest there is no motion that it could be compared with. For the
    same reason the settling of stacks is of no account, as far as it is not seen.
    """
    energy, bodies = recording.energy, [body for body in recording.scene.bodies if len(body)]
    duration = float(recording.times[-1] - recording.times[0])
    if bodies and duration > 0.0:
        mass = sum(float(body.mass.sum()) for body in bodies)
        extent = float(np.ptp(np.concatenate([body.positions for body in bodies]), axis=0).max())
        speed = UNSEEN * extent / duration
        unseen = max(0.5 * mass * speed * speed, _settling(recording.scene))
        if float(np.abs(energy.balance - energy.balance[0]).max()) <= unseen:
            return 0.0
    return energy.material_drift


def _settling(scene: Scene) -> float:
    """The energy that presses stacks of rigid bodies together by overlaps that are not seen [J]; 0 where there are
    joints, on which bodies may swing a little.
    """
    falls = [fall for force in scene.forces if (fall := force.fall(scene.dimension)) is not None]
    if not falls or not scene.has_rigid_bodies or scene.count("joints"):
        return 0.0
    bodies, pull = [body for body in scene.bodies if body.is_rigid], np.sum(falls, axis=0)
    weights = np.concatenate([np.where(body.fixed, 0.0, body.mass) for body in bodies])
    depths = dots(np.concatenate([body.positions for body in bodies]), pull)
    return SUNK * float((weights * (depths.max() - depths + lengths(pull) * gyrations(scene))).sum())


def _drift(recording: Recording) -> Iterator[str]:
    """A note on the drift, if it is not even fair."""
    largest = material_drift(recording)
    if not largest <= FAIR_DRIFT:
        yield (
            f"the energy balance drifted by {largest:.2g} of the energy in motion: {verdict(largest)}; "
            "pc.diagnose(recording) says more"
        )


def _untouched(recording: Recording) -> Iterator[str]:
    """Notes on planes that no particle can have touched, even between two frames."""
    scene, channels = recording.scene, recording.channels
    if scene.periodic is not None or not {"positions", "velocities"} <= channels.keys():
        return
    for place, boundary in enumerate(scene.boundaries):
        plane = cast("Boundary", boundary.resolved(scene.dimension)).flat
        if plane is None or any(body.is_rigid for body in scene.targets(boundary)):
            continue  # The surfaces of rigid bodies were not recorded.
        nearest = np.inf
        for body in scene.targets(boundary):
            part = scene.slice(scene.index(body))
            point, normal = map(np.array, plane)
            height = dots(channels["positions"][:, part] - point, normal)
            fastest = np.abs(dots(channels["velocities"][:, part], normal)).max(axis=0, initial=0.0)
            size = cast("Fluid", body).spacing if body.is_fluid else body.radius
            room = height.min(axis=0, initial=np.inf) - size - 0.5 * fastest / recording.fps
            nearest = min(nearest, float(room.min(initial=np.inf)))
        if 0.0 < nearest < np.inf:
            kind = type(boundary).__name__
            room = f"{nearest:.2g}{scene.units.suffix('m')}"
            yield f"boundaries[{place}]: nothing touched this {kind}, the nearest was {room} away"


def of_scene(scene: Scene, numerics: Numerics) -> list[str]:
    """Notes on what a scene does not resolve, and on unstable equilibrium."""
    notes = [*_edge_on(scene), *_thin(scene), *narrow(scene), *_at_rest(scene)]
    for system in scene.systems:
        path = str(scene.system(system))
        integrator = numerics.integrators.get(path, numerics.integrator)
        notes += [f"{path}: {each}" for each in system.unresolved(type(integrator).__name__)]
    return notes


def _thin(scene: Scene) -> Iterator[str]:
    """Notes on fluids of few rows of particles, or between walls with room for few."""
    sides = [np.ptp(np.array(room), axis=0) for room in _rooms(scene)]
    for body in scene.fluids:
        some = body.positions[:: 1 + len(body) // MANY]
        across = [np.ptp(turned, axis=0) for turned in (body.positions, along_own_axes(some))]
        extents = [*(np.array(across) + body.spacing), *sides]
        thinnest = float(np.min(extents))
        rows = round(thinnest / body.spacing)
        if rows < ROWS:
            yield (
                f"{scene.path(body)}: {rows} rows of particles across its thinnest side or its container; waves in "
                f"fewer than {ROWS} rows lose more than 5 % of their height in a period; a spacing of "
                f"{thinnest / ROWS:.2g} m keeps that"
            )


def _at_rest(scene: Scene) -> Iterator[str]:
    """A note on bodies at rest at boundaries, if no force moves them."""
    moving = any(body.velocities.any() or not body.is_loose for body in scene.bodies)
    if scene.bodies and scene.boundaries and not (moving or scene.forces):
        kind = type(scene.boundaries[0]).__name__
        yield f"boundaries[0]: nothing moves, and no force pulls toward this {kind}: add pc.Gravity()"


def _rooms(scene: Scene) -> list[tuple[Vector, Vector]]:
    """The corners of the boxes that contain the bodies of a scene."""
    return [room for room in (boundary.room for boundary in _resolved(scene)) if room is not None]


def _resolved(scene: Scene) -> list[Boundary]:
    """The boundaries as the engine has them."""
    return [cast("Boundary", boundary.resolved(scene.dimension)) for boundary in scene.boundaries]


def _edge_on(scene: Scene) -> list[str]:
    """A note on a flat network that falls on its edge in unstable equilibrium, because nothing acts normal to its
    plane.
    """
    network = scene.bodies[0].network if len(scene.bodies) == 1 else None
    if network is None or network.fixed.any() or not scene.boundaries:
        return []
    normal = _normal(network.positions)
    if normal is None or dots(network.velocities, normal).any():
        return []
    pull = np.zeros(scene.dimension)
    for force in scene.forces:
        fall = force.fall(scene.dimension)
        if fall is None:
            return []
        pull += fall
    middle = network.positions.mean(axis=0)
    symmetric = all(boundary.is_symmetric(middle, normal, ROUNDING) for boundary in _resolved(scene))
    if not pull.any() or abs(dots(pull, normal)) > ROUNDING * lengths(pull) or not symmetric:
        return []
    return [
        f"{scene.path(0)}: falls edge-on, and nothing acts across its plane: it stays flat, in unstable balance, "
        "however hard it lands; tilt it a little, or shift its positions by a thousandth of its springs' length"
    ]


def _normal(positions: FloatArray) -> FloatArray | None:
    """The normal of the plane, in 2D of the line, through all positions; None if there is no such plane, or several."""
    if len(positions) <= positions.shape[1]:
        return None
    away = positions - positions.mean(axis=0)
    within = row_space(away / (lengths(away).max() or 1.0), ROUNDING)
    if len(within) != positions.shape[1] - 1:
        return None
    normal: FloatArray = np.cross(*within) if len(within) == 2 else within[0, ::-1] * (-1.0, 1.0)
    return normal
