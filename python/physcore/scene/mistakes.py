"""Warnings of probable mistakes in a scene: charges without a force, fluid within bodies, masses and gaps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import cast

import numpy as np

from physcore.arithmetic import dots, power
from physcore.errors import SceneWarning, warn
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.fluid import CLOSEST, Fluid
from physcore.scene.items import Force
from physcore.scene.overlaps import close_pairs
from physcore.scene.rigid import RigidBodies

MOST_RATIO = 1e10
"""Ratio of the masses of rigid bodies that contacts and joints resolve: they are solved to its inverse."""


def warn_of_mistakes(bodies: Sequence[Body], forces: Sequence[Force], path: Callable[[Body], str]) -> None:
    """Warn of what a scene can hardly mean; `path` is the name of a body in messages."""
    _warn_of_charges(bodies, forces, path)
    _warn_of_shared_places(bodies, path)
    rigid = [cast("RigidBodies", body) for body in bodies if body.is_rigid]
    if rigid:
        _warn_of_masses(rigid, path)
        _warn_of_gaps(rigid, bodies, path)


def _warn_of_charges(bodies: Sequence[Body], forces: Sequence[Force], path: Callable[[Body], str]) -> None:
    """Warn if there are charges but no force that acts on charges, or Coulomb's force and no charges."""
    charged = [body for body in bodies if body.charge.any()]
    if bodies and not charged:
        for index, force in enumerate(forces):
            if force.needs_charges:
                warn(f"forces[{index}]: no body has a charge: give Particles(…, charge=…)", SceneWarning)
    if charged and not any(force.feels_charges for force in forces):
        warn(
            f"{path(charged[0])}.charge: no force of the scene acts on charges; "
            "add Coulomb() between them, or an ElectromagneticField(…)",
            SceneWarning,
        )


def _warn_of_shared_places(bodies: Sequence[Body], path: Callable[[Body], str]) -> None:
    """Warn if a fluid with obstacles fills places that the particles of another body fill."""
    fluids = [fluid for fluid in (cast("Fluid", body) for body in bodies if body.is_fluid) if fluid.obstacles]
    for body in bodies:
        for fluid in fluids if not (body.is_fluid or body.is_rigid) else ():
            filled = [first[first < len(fluid)] for first, second in _shared(fluid, body.positions)]
            count = len(np.unique(np.concatenate(filled))) if filled else 0
            if count > 0:
                warn(
                    f"{path(body)}: {count} particles of {path(fluid)} start within half "
                    "of their spacing of its own, so that both fill one place and are thrown apart; leave them out",
                    SceneWarning,
                )


def _warn_of_masses(rigid: Sequence[RigidBodies], path: Callable[[Body], str]) -> None:
    """Warn if the masses of rigid bodies differ by more than contacts and joints can resolve."""
    free = [(body.mass[~body.fixed], body) for body in rigid]
    least, light = min(((masses.min(initial=math.inf), body) for masses, body in free), key=lambda pair: pair[0])
    most, heavy = max(((masses.max(initial=0.0), body) for masses, body in free), key=lambda pair: pair[0])
    if most > MOST_RATIO * least:
        warn(
            f"{path(heavy)}.mass: one is {most / least:.1e} times that of the lightest body, {least:g} kg in "
            f"{path(light)}; contacts and joints are solved to {1.0 / MOST_RATIO:g}, so that a light body that bears "
            "a heavy one is thrown about; hold the heavy one with fixed=",
            SceneWarning,
        )


def _warn_of_gaps(rigid: Sequence[RigidBodies], bodies: Sequence[Body], path: Callable[[Body], str]) -> None:
    """Warn if rigid bodies are so small that they pass between the particles of a network."""
    smallest, body = min(((_radius(each), each) for each in rigid), key=lambda pair: pair[0])
    for mesh in (each.network for each in bodies):
        gap = 0.0 if mesh is None else _widest_gap(mesh)
        if mesh is not None and gap - smallest > mesh.radius.min():
            warn(
                f"{path(body)}: passes between the particles of {path(mesh)}, because faces do not meet rigid bodies; "
                f"it has the volume of a ball of radius {smallest:.3g} m, and a face has room for one of {gap:.3g} m: "
                f"give {path(mesh)} a radius above {gap - smallest:.3g} m or a finer spacing",
                SceneWarning,
            )


def _radius(body: RigidBodies) -> float:
    """The radius of a ball of the volume of a body, or of a disc of its area [m]."""
    size = body.shape.properties(body.dimension).size
    return math.sqrt(size / math.pi) if body.dimension == 2 else float(power(0.75 * size / math.pi, 1.0 / 3.0))


def _widest_gap(mesh: SpringNetwork) -> float:
    """The radius of the largest ball that fits between the corners of a face at the start [m]: that of the circle
    through them, or half of the longest edge if the face is obtuse. In a plane half of an edge at the rim. 0 without
    faces.
    """
    corners = mesh.positions[mesh.faces]
    edges = np.roll(corners, -1, axis=1) - corners
    squares = dots(edges, edges)
    if mesh.dimension == 2:
        sides = np.sort(np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=-1), axis=-1).reshape(-1, 2)
        _, place, count = np.unique(sides, axis=0, return_index=True, return_counts=True)
        return 0.5 * math.sqrt(squares.ravel()[place[count == 1]].max(initial=0.0))
    across = np.cross(edges[:, 0], edges[:, 1])
    longest, doubled = squares.max(axis=1, initial=0.0), dots(across, across)  # the square of twice the area
    obtuse = 2.0 * longest >= squares.sum(axis=1)
    diameters = np.where(obtuse, longest, squares.prod(axis=1) / np.where(obtuse, 1.0, doubled))
    return 0.5 * math.sqrt(diameters.max(initial=0.0))


def _shared(fluid: Fluid, positions: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[tuple[np.ndarray, ...]]:
    """Pairs of a particle of a fluid and a particle of a body that are closer than particles of a fluid can be."""
    points = np.concatenate([fluid.positions, positions])
    pairs: list[tuple[np.ndarray, ...]] = []
    for one, other, _ in close_pairs(points, CLOSEST * fluid.spacing):
        first, second = np.minimum(one, other), np.maximum(one, other)
        mixed = (first < len(fluid)) & (second >= len(fluid))
        pairs.append((first[mixed], second[mixed]))
    return pairs
