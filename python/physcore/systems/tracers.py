"""Tracers: massless points in a flow."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar, cast

from numpy.typing import ArrayLike

from physcore.checks import FloatArray, shown, text
from physcore.errors import SceneError
from physcore.scene.points import PointSystem, points
from physcore.scene.system import System
from physcore.systems.flows import FLOWS, Flow, VelocityField
from physcore.systems.point_vortices import PointVortices


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Tracers(PointSystem):
    """Tracers: massless points without interaction in a velocity field, x' = v(x, t).

        dust = pc.Tracers(rng.normal(size=(1000, 3)) + (0, 0, 25), pc.Lorenz())
        recording = pc.simulate(pc.Scene(dust), duration=2.0)
        recording[dust].positions  # (F, 1000, 3)

    Tracers use integrators of first-order equations, by default RungeKutta4(). With dt="auto" the time step is
    0.05/max|∇v| at the initial tracers, half of the limit of accuracy. AdaptiveStep() takes half of the present limit.
    |∇v| is the Frobenius norm, the root of the summed squares of all derivatives. Films show few tracers with trails,
    and many as a density.

    Args:
        positions: initial positions [m], shape (N, D) with D = 2 or 3.
        flow: the velocity field: `Lorenz`, `Rossler`, `Aizawa`, `Thomas` or `Halvorsen` in 3D, `PointVortices` of the
            scene in 2D, or a `Flow`.
        name: name of the system, also a key into results.

    Raises:
        SceneError: a shape does not fit, a number is not finite, or the flow has another dimension.
        SimulationDiverged: during a run, a tracer went to infinity.
    """

    parts: ClassVar[tuple[type, ...]] = FLOWS
    linking: ClassVar[tuple[str, ...]] = ("flow",)

    positions: FloatArray
    """Initial positions [m], shape (N, D)."""
    flow: VelocityField | PointVortices
    """The velocity field."""

    def __init__(self, positions: ArrayLike, flow: VelocityField | PointVortices, name: str | None = None) -> None:
        places = points(positions, "Tracers.positions")
        if not isinstance(flow, (*FLOWS, PointVortices)):
            known = ", ".join(f"{kind.__name__}(…)" for kind in (*FLOWS, PointVortices))
            raise SceneError(f"Tracers.flow: must be one of {known}, got {shown(flow)}")
        if places.shape[1] not in flow.dimensions:
            raise SceneError(
                f"Tracers.flow: {type(flow).__name__} is in {flow.dimensions[0]}D, and the positions are in "
                f"{places.shape[1]}D"
            )
        self._set(positions=places, flow=flow, name=None if name is None else text(name, "Tracers.name"))

    def timed(self) -> Iterator[tuple[str, Callable[[float], object]]]:
        """The flow at the first tracer, if it is a function."""
        if isinstance(flow := self.flow, Flow) and len(self):
            yield "flow", lambda time: flow(time, self.positions[:1].copy())

    @property
    def partners(self) -> tuple[System, ...]:
        """The systems that a scene of the tracers has to have: the vortices, if the flow is theirs."""
        return tuple(cast("System", other) for others in self.named().values() for other in others or ())

    @property
    def start(self) -> FloatArray:
        """The initial positions [m], shape (N, D)."""
        return self.positions
