"""Electric and magnetic fields of a scene at a frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias, cast

import numpy as np

from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.film.colors.themes import Theme
from physcore.forces import Coulomb
from physcore.scene.bodies import Body, Particles
from physcore.scene.items import Force
from physcore.scene.scene import Scene
from physcore.scene.selection import Selection
from physcore.simulation.simulation import Simulation
from physcore.simulation.sources import SourceFrame

Kind: TypeAlias = Literal["electric", "magnetic"]


def require(scene: Scene, kind: Kind, path: str) -> None:
    """Check that a scene has such a field.

    Raises:
        SceneError: the scene has none.
    """
    charged = any(body.charge.any() for body in scene.bodies) and any(force.needs_charges for force in scene.forces)
    if kind == "electric" and not charged and not any(force.is_electric for force in scene.forces):
        raise SceneError(f"{path}: this scene has no electric field: no charges under Coulomb(), no electric=")
    if kind == "magnetic" and not any(force.is_magnetic for force in scene.forces):
        raise SceneError(f"{path}: this scene has no magnetic field: ElectromagneticField(magnetic=…) is one")
    if kind == "magnetic" and scene.dimension == 2:
        raise SceneError(f"{path}: in 2D the magnetic field points out of the plane, and has no lines in it")


def mixed(theme: Theme, strength: float) -> FloatArray:
    """The color of text mixed with the background. Such an opaque color avoids darker spots where pieces of a line
    overlap.
    """
    text, background = (np.array(color, dtype=float) for color in (theme.text, theme.background))
    color: FloatArray = background + strength * (text - background)
    return color


def places_of(body: Body, scene: Scene, frame: SourceFrame) -> FloatArray:
    """The positions of the particles or rigid bodies of a body in a frame [m].

    Raises:
        SceneError: they were not recorded.
    """
    name, rows = scene.parts(body)["positions"]
    if name not in frame.fields:
        raise SceneError(f"channels: {name} were not recorded, and charges of {body!r} have fields")
    return frame.fields[name][rows]


@dataclass(frozen=True, eq=False)
class Fields:
    """The fields of a scene, with its charges at the positions of a frame."""

    scene: Scene
    frame: SourceFrame

    @cached_property
    def _simulation(self) -> Simulation:
        places = (places_of(body, self.scene, self.frame) for body in self.scene.bodies)
        held = [
            Particles(at, charge=body.charge, fixed=True) for body, at in zip(self.scene.bodies, places, strict=True)
        ]

        def body_of(body: object) -> Particles:
            return held[self.scene.bodies.index(cast("Body", body))]

        def alone(force: Force) -> Force:
            named = force.targets("sources") if "sources" in force.naming else None
            if named is None:
                return replace(force, on=None)
            sources = [
                (body_of(each.body), each.index) if isinstance(each, Selection) else body_of(each) for each in named
            ]
            return replace(cast("Coulomb", force), on=None, sources=sources)

        forces = (force for force in self.scene.forces if force.needs_charges or force.is_electric or force.is_magnetic)
        return Simulation(Scene(*held, *map(alone, forces)), dt=1.0)

    def at(self, kind: Kind, points: FloatArray) -> FloatArray:
        """The field (M, D) at points (M, D); NaN where it is not finite."""
        return self._sample(f"{kind}_field", points)[:, : self.scene.dimension]

    def potential(self, points: FloatArray) -> FloatArray:
        """The electric potential (M,) [V]; NaN where it is not finite."""
        return self._sample("electric_potential", points)[:, 0]

    def _sample(self, field: str, points: FloatArray) -> FloatArray:
        world = self._simulation._world
        try:
            return world.sample(field, points, None, self.frame.time)
        except SceneError as error:
            if ".points[" not in str(error) and "places" not in str(error):
                raise
        # One of the points is at a charge: bisect, so that only this point becomes NaN.
        if len(points) == 1:
            return np.full((1, 3), np.nan)
        half = len(points) // 2
        return np.concatenate([self._sample(field, part) for part in (points[:half], points[half:])])
