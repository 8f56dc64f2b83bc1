"""Warnings of probable mistakes in a scene: charges without a force, fluid within bodies, masses."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import cast

import numpy as np

from physcore.errors import SceneWarning, warn
from physcore.scene.bodies import Body
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


def _shared(fluid: Fluid, positions: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[tuple[np.ndarray, ...]]:
    """Pairs of a particle of a fluid and a particle of a body that are closer than particles of a fluid can be."""
    points = np.concatenate([fluid.positions, positions])
    pairs: list[tuple[np.ndarray, ...]] = []
    for one, other, _ in close_pairs(points, CLOSEST * fluid.spacing):
        first, second = np.minimum(one, other), np.maximum(one, other)
        mixed = (first < len(fluid)) & (second >= len(fluid))
        pairs.append((first[mixed], second[mixed]))
    return pairs
