"""Flows: velocity fields for `Tracers`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import ClassVar

from numpy.typing import ArrayLike

from physcore.checks import DIMENSIONS, FloatArray, number, shown
from physcore.errors import SceneError


# To add a flow: a class here, a line in `FLOWS`, and its counterpart in Rust.
@dataclass(frozen=True)
class VelocityField:
    """Base class of flows: a velocity field v(x, t) [m/s]."""

    dimensions: ClassVar[tuple[int, ...]] = (3,)
    """Supported numbers of dimensions."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            path = f"{type(self).__name__}.{entry.name}"
            object.__setattr__(self, entry.name, number(getattr(self, entry.name), path))


@dataclass(frozen=True)
class Lorenz(VelocityField):
    """Lorenz system: three modes of convection, with a butterfly-shaped chaotic attractor.

        dust = pc.Tracers(rng.normal(size=(1000, 3)) + (0, 0, 25), pc.Lorenz())

        x' = σ (y − x),  y' = x (ρ − z) − y,  z' = x y − β z

    With the defaults the Lyapunov exponents are 0.9056, 0 and −14.572 (Sprott 2003). Volumes shrink at the rate σ + 1 +
    β.

    Args:
        sigma: σ [1/s].
        rho: ρ.
        beta: β [1/s].

    Raises:
        SceneError: a number is not finite.

    Source: E. N. Lorenz, J. Atmos. Sci. 20, 130 (1963); J. C. Sprott, "Chaos and Time-Series Analysis", 2003.
    """

    sigma: float = 10.0
    rho: float = 28.0
    beta: float = 8.0 / 3.0


@dataclass(frozen=True)
class Rossler(VelocityField):
    """Rössler system: a chaotic attractor in the form of a band that is stretched and folded.

        dust = pc.Tracers(rng.normal(size=(1000, 3)), pc.Rossler())

        x' = −y − z,  y' = x + a y,  z' = b + z (x − c)

    Args:
        a, b, c: parameters; the defaults are Rössler's.

    Raises:
        SceneError: a number is not finite.

    Source: O. E. Rössler, Phys. Lett. A 57, 397 (1976).
    """

    a: float = 0.2
    b: float = 0.2
    c: float = 5.7


@dataclass(frozen=True)
class Aizawa(VelocityField):
    """Aizawa system: a chaotic attractor in the form of a sphere of shells with a tube along its axis.

        dust = pc.Tracers(0.1 * rng.normal(size=(1000, 3)), pc.Aizawa())

        x' = (z − b) x − d y
        y' = d x + (z − b) y
        z' = c + a z − z³/3 − (x² + y²)(1 + e z) + f z x³

    Args:
        a, b, c, d, e, f: parameters.

    Raises:
        SceneError: a number is not finite.

    Source: W. F. Langford, Int. Ser. Numer. Math. 70, 215 (1984), with the parameters named after Y. Aizawa.
    """

    a: float = 0.95
    b: float = 0.7
    c: float = 0.6
    d: float = 3.5
    e: float = 0.25
    f: float = 0.1


@dataclass(frozen=True)
class Thomas(VelocityField):
    """Thomas system: three equal feedback loops with cyclic symmetry; without damping, a chaotic walk through all
    space.

        dust = pc.Tracers(rng.normal(size=(1000, 3)), pc.Thomas())

        x' = sin y − b x,  y' = sin z − b y,  z' = sin x − b z

    The flow is chaotic below b = 0.208186. Volumes shrink at the rate 3 b.

    Args:
        b: the damping [1/s].

    Raises:
        SceneError: the damping is not finite.

    Source: R. Thomas, Int. J. Bifurcation Chaos 9, 1889 (1999).
    """

    b: float = 0.208186


@dataclass(frozen=True)
class Halvorsen(VelocityField):
    """Halvorsen system: a chaotic attractor with three wings in cyclic symmetry.

        dust = pc.Tracers(rng.normal(size=(1000, 3)), pc.Halvorsen())

        x' = −a x − 4 y − 4 z − y²,  y' = −a y − 4 z − 4 x − z²,  z' = −a z − 4 x − 4 y − x²

    Far from the attractor, tracers go to infinity in a finite time. Volumes shrink at the rate 3 a.

    Args:
        a: the damping [1/s].

    Raises:
        SceneError: the damping is not finite.

    Source: J. C. Sprott, "Chaos and Time-Series Analysis", 2003, appendix A.
    """

    a: float = 1.89


@dataclass(frozen=True)
class Flow(VelocityField):
    """User-defined flow in 2D or 3D, given by a NumPy function of all points at once.

        stirring = pc.Flow(lambda time, x: np.column_stack([np.sin(x[:, 1] + time), np.sin(x[:, 0])]))
        dye = pc.Tracers(rng.uniform(size=(5000, 2)), stirring)

    The function is called once per stage of each step, on one thread. Its arguments are the time [s] and the positions
    [m] of all tracers, shape (N, D), which it may modify. It returns their velocities [m/s], of the same shape. The
    velocity of a tracer must not depend on other tracers. A flow can be called as its function, and be the wind of
    `Drag` and `Wind`.

    Args:
        function: function that returns the velocities.

    Raises:
        SceneError: the value is not a function.
    """

    function: Callable[[float, FloatArray], ArrayLike]
    dimensions: ClassVar[tuple[int, ...]] = DIMENSIONS

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise SceneError(f"Flow.function: must be a function of time and positions, got {shown(self.function)}")

    def __call__(self, time: float, positions: FloatArray) -> ArrayLike:
        """The velocities [m/s] at a time [s] and positions [m]."""
        return self.function(time, positions)


FLOWS: tuple[type[VelocityField], ...] = (Lorenz, Rossler, Aizawa, Thomas, Halvorsen, Flow)
"""All flows, except systems of a scene."""
