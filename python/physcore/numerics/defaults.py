"""Defaults: the integrator of the bodies where none is named, and which scenes are small."""

from __future__ import annotations

import numpy as np

from physcore.numerics.integrators import (
    RATTLE,
    BlanesMoan4,
    Boris,
    DormandPrince5,
    Integrator,
    VelocityVerlet,
)
from physcore.scene.scene import Scene

SMALL = 1000
"""Largest number of particles, and of pairs at a distance, of a small scene.

Ten periods of the slowest motion of a chain of so many particles are 6000 periods of its fastest one. With 24
evaluations in each these are 10⁸ evaluations of a particle, or a second or two.
"""


def default_integrator(scene: Scene, automatic: bool) -> Integrator:
    """The integrator of the bodies where none is named.

    With an automatic time step it is the cheapest one for an error of 1 % after ten periods in the scenes of
    `tests/textbook.py`: a splitting of order 4 where forces are smooth and conserve energy, Dormand and Prince's method
    where they are smooth, and Verlet's method at contacts. Verlet's method advances large scenes, and steps of a given
    length.
    """
    fine = automatic and is_small(scene) and _is_smooth(scene)
    if scene.has_rods or (scene.constraints and fine):
        return RATTLE(order=4) if fine and not _is_damped(scene) else RATTLE()
    if is_magnetic(scene) and not scene.constraints:
        return Boris()
    if not fine:
        return VelocityVerlet()
    return DormandPrince5() if _is_damped(scene) else BlanesMoan4()


def is_small(scene: Scene) -> bool:
    """Whether accuracy costs little: bodies of few particles, without fluids, rigid bodies and contacts of meshes, and
    no other systems.

    Atoms are left out, because their limit of accuracy resolves their bonds.
    """
    count = scene.particles
    pairs = count * (count - 1) // 2 if any(force.is_distant for force in scene.forces) else 0
    atoms = any(force.binds for force in scene.forces)
    few = 0 < count <= SMALL and pairs <= SMALL
    meets = not all(constraint.is_smooth for constraint in scene.constraints)
    return few and not (atoms or scene.systems or scene.fluids or scene.has_rigid_bodies or meets)


def is_magnetic(scene: Scene) -> bool:
    """Whether there is a magnetic field."""
    return any(force.is_magnetic for force in scene.forces)


def _is_smooth(scene: Scene) -> bool:
    """Whether the motion has no contacts, cuts and tears, at which a method of high order loses its order."""
    cut = any(force.is_contact for force in scene.forces)
    kinked = any(network.can_tear or np.isfinite(network.strain_limit).any() for network in scene.networks)
    return not (scene.boundaries or cut or kinked)


def _is_damped(scene: Scene) -> bool:
    """Whether forces may depend on velocities, which lowers splittings to order 2."""
    damped = any(network.damping.any() for network in scene.networks)
    return damped or any(force.dissipates for force in scene.forces)
