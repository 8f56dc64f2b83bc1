"""Linear and quadratic drag in a wind."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from physcore.checks import FloatArray, PlacedVector, number, placed
from physcore.scene.items import Force


@dataclass(frozen=True)
class Drag(Force):
    """Drag of the surrounding medium: F = −(b + c |u|) u, where u = v − wind.

        ball = pc.Particles([[0.0, 0.0]], velocities=[[10.0, 0.0]], name="ball")
        scene = pc.Scene(ball, pc.Drag(linear=0.1, wind=(0.0, 1.0), on="ball"))
        shear = pc.Drag(0.1, wind=lambda t, x: np.column_stack([x[:, 1], 0.0 * x[:, 1]]))

    The linear term is Stokes' law for slow motion, the quadratic one Newton's for fast motion. The power in the frame
    of the wind, (b + c |u|) |u|², counts as dissipated. The power of the wind counts as work.

    Args:
        linear: b [N·s/m], at least zero.
        quadratic: c [N·s²/m²], at least zero.
        wind: velocity of the medium [m/s]; None: at rest. Or a function, called in every evaluation. `wind(time)`
            returns one velocity. `wind(time, positions)` has the positions [m] of the particles that the drag acts on,
            shape (N, D), and returns a velocity for each, (N, D). A `pc.Flow` is such a function.
        on: the body or bodies that the drag acts on; all except fluids by default.

    Raises:
        SceneError: a coefficient is negative, a value is not finite, or a function takes other arguments. In a run: a
            function raised an exception, or returned what is no array of numbers; the message begins with
            `forces[i].wind`.

    Source: L. D. Landau, E. M. Lifshitz, "Fluid Mechanics", §§ 20 and 45.
    """

    linear: float = 0.0
    quadratic: float = 0.0
    wind: PlacedVector | None = None
    by_place: bool = field(init=False, repr=False, compare=False)
    """Whether the wind is a function of time and positions."""

    spares_fluids: ClassVar[bool] = True
    timed: ClassVar[tuple[str, ...]] = ("wind",)

    @property
    def dissipates(self) -> bool:
        """True."""
        return True

    def fall(self, dimension: int) -> FloatArray | None:
        """Zero without wind."""
        return np.zeros(dimension) if self.wind is None else None

    def __post_init__(self) -> None:
        super().__post_init__()
        wind, by_place = (None, False) if self.wind is None else placed(self.wind, "Drag.wind")
        self._set(
            linear=number(self.linear, "Drag.linear", least=0.0),
            quadratic=number(self.quadratic, "Drag.quadratic", least=0.0),
            wind=wind,
            by_place=by_place,
        )
