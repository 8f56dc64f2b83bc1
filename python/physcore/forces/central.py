"""Central force with a power law."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.checks import Vector, number, vector
from physcore.scene.items import Force


@dataclass(frozen=True)
class CentralForce(Force):
    """Central force of a fixed center: F = −strength · s^(exponent − 1) · r, r = x − center, s = √(|r|² + softening²).

        planet = pc.Particles([[1.0, 0.0]], velocities=[[0.0, 1.0]])
        scene = pc.Scene(planet, pc.CentralForce((0.0, 0.0), strength=1.0, exponent=-2))

    Without softening the magnitude of the force is strength · r^exponent. The force does not depend on the particle's
    mass. For the gravity of a mass M on particles of mass m, the strength is therefore G M m.

    Args:
        center: position of the center [m], one number for each dimension of the scene.
        strength: the force at a distance of 1 m [N]; positive attracts, negative repels.
        exponent: −2 for gravity and electrostatics, 1 for a harmonic well.
        softening: softening length [m], which keeps the force finite at the center (Plummer 1911).
        on: the body or bodies that the force acts on; all by default.

    Raises:
        SceneError: a value is not finite, or `softening` is negative.
    """

    center: Vector
    strength: float
    exponent: float = -2.0
    softening: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            center=vector(self.center, "CentralForce.center"),
            strength=number(self.strength, "CentralForce.strength"),
            exponent=number(self.exponent, "CentralForce.exponent"),
            softening=number(self.softening, "CentralForce.softening", least=0.0),
        )
