"""Checkpoints: the content of their files, and functions that can be pickled."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from physcore._core import World
from physcore.checks import MOST, shown
from physcore.errors import FileError, SceneError
from physcore.numerics.choices import Limit, Numerics, check
from physcore.scene.fields import FLOW
from physcore.scene.records import Record
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.earlier import EARLIER
from physcore.simulation.provenance import SEGMENTS
from physcore.simulation.serial import pack_numerics, unpack_numerics, unpack_scene
from physcore.simulation.stepper import Captured
from physcore.storage.archive import Tree
from physcore.storage.schema import of, real, record, several, table


class Checkpoint(NamedTuple):
    """Scene with its numerics, in a state from which a simulation goes on with the same bits."""

    scene: Scene
    numerics: Numerics
    stepper: Captured
    """State of the stepper."""
    world: Tree
    """Captured world."""

    @classmethod
    def from_content(cls, content: Mapping[str, Tree]) -> Checkpoint:
        """The checkpoint from the content of its file.

        Raises:
            FileError: an entry is missing or wrong; with its path.
        """
        bounds = dict.fromkeys(("dt", "stability", "accuracy", "certified", "endured"), real(least=0.0, finite=False))
        limits = several(of(Limit, **bounds), lengths=(0, 2))
        stepper = of(Captured, limits=limits, segments=SEGMENTS, earlier=EARLIER)
        shape = record(scene=unpack_scene, numerics=unpack_numerics, stepper=stepper, world=table(_numbers))
        checked = shape(content, "")
        return cls(**{**checked, "numerics": check(checked["numerics"], checked["scene"])})

    def content(self) -> dict[str, Tree]:
        """The checkpoint as plain values, for a file.

        Raises:
            FileError: the scene has a CustomForce.
        """
        return {
            "scene": self.scene.packed(),
            "numerics": pack_numerics(self.numerics),
            "stepper": self.stepper,
            "world": self.world,
        }

    def verify(self, world: World) -> None:
        """Check the world that was restored from this checkpoint.

        Raises:
            FileError: a number of its state is not finite.
        """
        if self.numerics.on_divergence != "ignore":
            for name, numbers in self.world.items():
                if name.endswith("tallies") and not np.isfinite(numbers).all():
                    raise FileError(f"world.{name}: must be finite")
        if not np.isfinite(world.time):
            raise FileError("world.clock: must be a time that is finite")
        for info in engine.fields(world, self.scene):
            # Particles that are no fluid's have no density.
            whole = info.state and info.name not in FLOW
            if whole and not np.isfinite(engine.read(world, self.scene, info.name)).all():
                raise FileError("world.columns: must be finite in the precision of the run")

    def require_pickles(self) -> None:
        """Refuse a scene with a function that cannot be pickled.

        Raises:
            SceneError: it has one.
        """
        for section in ("forces", "systems"):
            for position, item in enumerate(getattr(self.scene, section)):
                for path, function in Record.of(item).functions():
                    _require_pickle(function, f"{section}[{position}]{path}")


def _numbers(value: object, path: str) -> NDArray[np.generic]:
    """A part of a captured state: numbers. Positions and velocities are looked at when they are restored; accelerations
    and energies may be beyond the range of numbers in a run that diverges.
    """
    if not isinstance(value, np.ndarray):
        raise FileError(f"{path}: must be an array, got {shown(value)}")
    steps = value.dtype.kind in "iu" and value.size > 0 and int(value.max()) > MOST
    if steps or (path.endswith(("clock", "adaptation")) and not np.isfinite(value).all()):
        raise FileError(f"{path}: must be finite numbers, with at most {MOST} steps")
    return value


def _require_pickle(function: object, path: str) -> None:
    """Refuse a function that has no name by which another process could find it.

    Raises:
        SceneError: it has none.
    """
    try:
        pickle.dumps(function)
    except Exception as error:
        raise SceneError(
            f"{path}: cannot be pickled ({error}); define it with def at the top level of a module"
        ) from error
