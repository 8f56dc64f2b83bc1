"""The base of all integrators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.scene.items import Equation


@dataclass(frozen=True)
class Integrator:
    """A way to advance an equation of motion, such as x' = v, v' = a(x, v, t). Integrators of the same kind and
    parameters are equal.

        integrator = pc.RungeKutta4()  # an Integrator
        integrator.order  # 4

    To add one: a file here, a line in `INTEGRATORS`, and its counterpart in Rust.
    """

    order: ClassVar[int]
    """Nominal order: the error at a fixed time shrinks like dt^order. `plan.order` is what holds in a scene."""
    symplectic: ClassVar[bool]
    """Whether it keeps the area in phase space: without dissipation its energy error then stays bounded."""
    embedded: ClassVar[bool] = False
    """Whether it estimates the error of each step, from a method of the order below that is embedded in it."""
    self_adaptive: ClassVar[bool] = False
    """Whether it chooses the steps itself with dt="auto", by a `tolerance` of its own."""
    stiff: ClassVar[bool] = False
    """Whether it is for motion that steps do not resolve: it is then compared where it is named."""
    holds_rods: ClassVar[bool] = False
    """Whether it keeps springs of infinite stiffness at their lengths."""
    solves: ClassVar[tuple[Equation, ...]] = ("bodies", "second order")
    """The kinds of equations of motion that it can advance."""
