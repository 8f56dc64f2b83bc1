"""Projective dynamics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import MOST, count
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class ProjectiveDynamics(Integrator):
    """Projective dynamics, order 1: backward Euler's equation by iterations that share one factorized matrix.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.ProjectiveDynamics(), dt=1 / 60)

    An iteration projects each spring to its rest length, then solves (M + h² Σ k Dᵀ D) Δu = residual for all particles
    at once; the matrix is factorized once for each step size. Errors of all wavelengths fall together, unlike those
    of sweeps. Iterations start from the displacements that keep all velocities, so that a state of rest does not depend
    on their number, and few of them keep motion. What they learn of the true stiffness corrects the matrix (L-BFGS).
    Stable at any stiffness. Cloth far stiffer than a step resolves takes more iterations: compare by `pc.tradeoff`.

    It damps as backward Euler does, and is not symplectic: errors of the method, which show as drift of the energy
    balance. For springs and fields such as Gravity and Drag, with boundaries; other forces are refused.

    Args:
        iterations: in each step, at least 1.

    Source: S. Bouaziz et al., ACM Trans. Graph. 33, 154 (2014); T. Liu, S. Bouaziz, L. Kavan, ACM Trans. Graph. 36, 23
    (2017).

    Raises:
        SceneError: `iterations` is below 1.
    """

    order: ClassVar[int] = 1
    symplectic: ClassVar[bool] = False
    stiff: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("bodies",)

    iterations: int = 10

    def __post_init__(self) -> None:
        iterations = count(self.iterations, "ProjectiveDynamics.iterations", least=1, most=MOST)
        object.__setattr__(self, "iterations", iterations)
