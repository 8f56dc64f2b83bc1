"""Linear and quadratic drag in a uniform wind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import TimedVector, number, timed
from physcore.scene.items import Force


@dataclass(frozen=True)
class Drag(Force):
    """Drag of the surrounding medium: F = −(b + c |u|) u, where u = v − wind.

        ball = pc.Particles([[0.0, 0.0]], velocities=[[10.0, 0.0]], name="ball")
        scene = pc.Scene(ball, pc.Drag(linear=0.1, wind=(0.0, 1.0), on="ball"))

    The linear term is Stokes' law for slow motion, the quadratic one Newton's for fast motion. The power in the frame
    of the wind, (b + c |u|) |u|², counts as dissipated. The power of the wind counts as work.

    Args:
        linear: b [N·s/m], at least zero.
        quadratic: c [N·s²/m²], at least zero.
        wind: velocity of the medium [m/s], or a function of the time [s] that returns it, called in every evaluation;
            None: at rest.
        on: the body or bodies that the drag acts on; all except fluids by default.

    Raises:
        SceneError: a coefficient is negative, or a value is not finite.

    Source: L. D. Landau, E. M. Lifshitz, "Fluid Mechanics", §§ 20 and 45.
    """

    linear: float = 0.0
    quadratic: float = 0.0
    wind: TimedVector | None = None

    spares_fluids: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            linear=number(self.linear, "Drag.linear", least=0.0),
            quadratic=number(self.quadratic, "Drag.quadratic", least=0.0),
            wind=None if self.wind is None else timed(self.wind, "Drag.wind"),
        )
