"""Base class of all integrators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore._core import advances
from physcore.scene.records import Record

MOST_ITERATIONS = 100_000
"""Largest number of iterations per step; a larger one is a mistake."""


# To add an integrator: a module here, a line in `INTEGRATORS`, and its counterpart in Rust.
@dataclass(frozen=True)
class Integrator:
    """Integrator: a method to advance an equation of motion, such as x' = v, v' = a(x, v, t).

        integrator = pc.RungeKutta4()  # an Integrator
        integrator.order  # 4

    Integrators of the same class with equal parameters are equal.
    """

    order: ClassVar[int]
    """Nominal order: the error at a fixed time is proportional to dt^order. `plan.order` is the order in a scene."""
    symplectic: ClassVar[bool]
    """Whether the method is symplectic. Its energy error is then bounded without dissipation."""
    embedded: ClassVar[bool] = False
    """Whether the method estimates the error of each step, by an embedded method of lower order."""
    self_adaptive: ClassVar[bool] = False
    """Whether the method chooses its steps with dt="auto", by its own `tolerance`."""
    stiff: ClassVar[bool] = False
    """Whether the method is for motion that steps do not resolve. `tradeoff` compares such methods only if they are
    named.
    """
    resolving: ClassVar[float] = 1.0
    """Fraction of the limit of stability up to which an undamped oscillation is off by at most half a percent of its
    amplitude after ten periods; 1 for methods that `AutoStep(resolve=True)` leaves alone.
    """
    continuous: ClassVar[bool] = True
    """Whether a step that becomes short changes the state by less and less."""
    holds_rods: ClassVar[bool] = False
    """Whether the method keeps springs of infinite stiffness (rods) at their lengths."""

    @classmethod
    def advances(cls, kind: str) -> bool:
        """Whether the method can advance the items of a kind: "bodies", or a kind of system, such as "Wave".

        The engine decides it. What else is in a scene can exclude more methods, which a Simulation then refuses.
        """
        if (cls, kind) not in _answers:
            _answers[cls, kind] = advances(kind, Record.of(cls()).described())
        return _answers[cls, kind]


_answers: dict[tuple[type[Integrator], str], bool] = {}
"""Answers of the engine, for the default parameters of a method."""
