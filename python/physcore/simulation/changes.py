"""Changes of the state of a simulation between two steps."""

from __future__ import annotations

from collections.abc import Mapping

from numpy.typing import ArrayLike

from physcore._core import World
from physcore.checks import FloatArray, broadcast, shown
from physcore.errors import SceneError
from physcore.scene.contents import BodyKey, ItemKey
from physcore.scene.rotations import unit_quaternions
from physcore.scene.scene import Scene
from physcore.simulation import engine


class Changes:
    """New values of fields of bodies, which replace those of a world together."""

    def __init__(self, world: World, scene: Scene) -> None:
        self._world, self._scene = world, scene
        self.fields: dict[str, FloatArray] = {}
        """New values by name of the field."""

    def put(self, name: str, given: ArrayLike | Mapping[BodyKey, ArrayLike]) -> None:
        """Take new values of a field of all particles, or of some bodies.

        Raises:
            SceneError: there is no such body, a shape does not fit, or a value is not finite.
        """
        if not isinstance(given, Mapping):
            shape = (self._scene.particles, self._scene.dimension)
            self.fields[name] = broadcast(given, shape, f"set.{name}")
            return
        for key, own in given.items():
            try:
                body = self._scene.bodies[self._scene.index(key)]
            except KeyError as error:
                raise SceneError(f"set.{name}: {error.args[0]}") from None
            self.put_part(body, name, own, key)

    def put_part(self, item: ItemKey, name: str, given: ArrayLike, key: object) -> None:
        """Take new values of a field of an item, called `key` in messages.

        Raises:
            SceneError: a shape does not fit, a value is not finite, or a quaternion is zero.
        """
        field, rows = self._scene.parts(item)[name]
        if field not in self.fields:
            self.fields[field] = engine.read(self._world, self._scene, field)
        values, path = self.fields[field], f"set.{name}[{shown(key)}]"
        shape = values[rows].shape
        turns = name == "orientations"
        values[rows] = unit_quaternions(given, shape[0], path) if turns else broadcast(given, shape, path)
