"""Boris' method, the default with magnetic fields."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import flag
from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class Boris(Integrator):
    """Boris' method, order 2, one force evaluation: the default with a magnetic field.

        pc.simulate(scene, 10.0, integrator=pc.Boris())

    A step has the following parts: half a drift; half a kick by all other forces; a rotation of the velocity by 2
    atan(|q B| dt/2m) about q B; half a kick; half a drift. The method is reversible and conserves phase-space volume.
    In a magnetic field alone it conserves the speed at any q B dt/m. Without a magnetic field it is position Verlet. It
    is not symplectic. A magnetic field limits the step only by accuracy, to a hundredth of the gyration period
    2πm/|qB|. Drag and damping are evaluated at a predicted velocity, which preserves order 2.

    Args:
        exact_angle: whether to rotate velocities by |q B| dt/m instead, the exact angle in a uniform field.

    Raises:
        SceneError: `exact_angle` is neither True nor False.

    Source: J. P. Boris, Proc. 4th Conf. Numerical Simulation of Plasmas, 3 (1970); H. Qin et al., Phys. Plasmas 20,
    084503 (2013).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = False
    resolving: ClassVar[float] = 0.022

    exact_angle: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "exact_angle", flag(self.exact_angle, "Boris.exact_angle"))
