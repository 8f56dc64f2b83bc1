"""Projective dynamics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import count
from physcore.numerics.integrators.base import MOST_ITERATIONS, Integrator


@dataclass(frozen=True)
class ProjectiveDynamics(Integrator):
    """Projective dynamics, order 1: backward Euler, solved by iterations with a single factorized matrix.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.ProjectiveDynamics(), dt=1 / 60)

    An iteration projects each spring to its rest length, and then solves (M + h² Σ k Dᵀ D) Δu = residual for all
    particles. The matrix is factorized once for each step size. Errors of all wavelengths decrease together, unlike in
    sweeps over the springs. The initial guess is the displacement at constant velocity. A state of rest therefore does
    not depend on the number of iterations, and few iterations preserve motion. L-BFGS corrects the matrix by the
    observed stiffness. The method is stable at any stiffness. Cloth of a stiffness far beyond the resolution of the
    step needs more iterations; compare by `pc.tradeoff`.

    The method has the numerical damping of backward Euler, and is not symplectic. Both errors appear as a drift of the
    energy balance. Supported are springs, external fields such as Gravity and Drag, and boundaries; other forces are
    refused.

    Args:
        iterations: number of iterations per step, at least 1.

    Source: S. Bouaziz et al., ACM Trans. Graph. 33, 154 (2014); T. Liu, S. Bouaziz, L. Kavan, ACM Trans. Graph. 36, 23
    (2017).

    Raises:
        SceneError: `iterations` is below 1.
    """

    order: ClassVar[int] = 1
    symplectic: ClassVar[bool] = False
    stiff: ClassVar[bool] = True

    iterations: int = 10

    def __post_init__(self) -> None:
        iterations = count(self.iterations, "ProjectiveDynamics.iterations", least=1, most=MOST_ITERATIONS)
        object.__setattr__(self, "iterations", iterations)
