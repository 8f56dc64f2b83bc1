"""Numerics of the contacts and joints of rigid bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from physcore.checks import count, is_word, shown
from physcore.errors import SceneError
from physcore.scene.scene import Scene

MOST_PARTS = 1_000_000
"""A larger number is a mistake: a step would not end."""


@dataclass(frozen=True)
class ContactSolver:
    """Numerics of the contacts and joints of rigid bodies. Solvers of the same parameters are equal.

        discs = pc.RigidBodies(pc.Disc(0.1), [(0.03 * k, 0.1 + 0.2 * k) for k in range(40)])
        scene = pc.Scene(discs, pc.Floor(0.0), pc.Gravity())
        recording = pc.simulate(scene, 0.1, dt=1 / 60, contacts=pc.ContactSolver(substeps=8))

    In each step, bodies that are joined or may touch form a group. A group of at most `sequential` bodies is computed
    accurately: each impact is taken at its time, one after the other, and the forces of contacts and joints are
    solved for to rounding. Its cost grows with the number of impacts and with the cube of the number of contacts. A
    larger group, and a smaller one after many impacts, takes the step in `substeps` equal parts, in each of which all
    contacts and joints are solved together by `iterations` sweeps. There impacts take place at the ends of parts, and
    what sweeps leave unsolved shows as overlaps and as joints that yield. Its cost grows with the number of contacts
    only. A step in which a body moves by more than a tenth of the thickness of the thinnest one has at least one part
    for each such tenth. Bodies at rest sink into each other by an overlap that falls with the square of the substeps,
    which more iterations do not change.

    Args:
        substeps: equal parts of a step of a large group whose bodies are slow, at least 1.
        iterations: sweeps over all contacts and joints in each half of a part, at least 1. Where bodies strike each
            other, the first half takes all but one of both.
        sequential: number of bodies of the largest group that is computed accurately, at least 0; particles that meet
            the bodies do not count.

    Raises:
        SceneError: a value is no whole number or out of range; later, with a scene, it has no rigid bodies.

    Sources: M. Macklin et al., "Small Steps in Physics Simulation", Symposium on Computer Animation 2019; E. Catto,
    "Solver2D", 2024.
    """

    substeps: int = 4
    iterations: int = 2
    sequential: int = 32

    def __post_init__(self) -> None:
        for name, least in (("substeps", 1), ("iterations", 1), ("sequential", 0)):
            value = count(getattr(self, name), f"ContactSolver.{name}", least=least, most=MOST_PARTS)
            object.__setattr__(self, name, value)


Contacts: TypeAlias = ContactSolver | Literal["auto"]
"""How contacts of rigid bodies are computed; "auto": ContactSolver()."""


def contact_solver(value: object, scene: Scene, path: str = "contacts") -> ContactSolver | None:
    """The solver of the contacts of a scene; None without rigid bodies.

    Raises:
        SceneError: it is no solver, or there are no rigid bodies.
    """
    if is_word(value, "auto"):
        return ContactSolver() if scene.has_rigid_bodies else None
    if not isinstance(value, ContactSolver):
        hint = f"; write {value.__name__}()" if value is ContactSolver else ""
        raise SceneError(f"{path}: must be a ContactSolver(…) or 'auto', got {shown(value)}{hint}")
    if not scene.has_rigid_bodies:
        raise SceneError(f"{path}: there are no rigid bodies in this scene")
    return value
