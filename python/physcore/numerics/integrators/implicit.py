"""Implicit methods for bodies: what they share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number
from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class Implicit(Integrator):
    """Method whose steps solve the equations of motion by Newton's method with line search and conjugate gradients.

    Args:
        tolerance: largest residual force relative to the largest force in the step, above 0.

    Raises:
        SceneError: `tolerance` is not above 0.
    """

    symplectic: ClassVar[bool] = False
    stiff: ClassVar[bool] = True

    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        path = f"{type(self).__name__}.tolerance"
        object.__setattr__(self, "tolerance", number(self.tolerance, path, above=0.0))
