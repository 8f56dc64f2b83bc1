"""Probes: points at which the pressure of fluids is measured."""

from __future__ import annotations

from dataclasses import dataclass, field

from physcore.checks import Vector, span, text, vector
from physcore.scene.items import SceneItem


@dataclass(frozen=True)
class Probe(SceneItem):
    """A point at which the pressure of fluids is measured, as a sensor in a wall does.

        water = pc.Fluid.block((0.0, 0.0), (0.4, 0.6), spacing=0.05)
        probe = pc.Probe((1.2, 0.0), name="P1")
        tank = pc.Box((0.0, 0.0), (1.2, 1.0))
        recording = pc.simulate(pc.Scene(water, pc.Gravity(), tank, probe), 0.5)
        recording[probe].pressure  # (F,)
        recording[tank].force  # (F, D), on the tank

    The pressure [Pa] at a wall, within a tenth of `radius` from a boundary, is what the wall bears of the fluid, as a
    mean over its part within `radius`, weighted by the fluid's kernel with that support. Elsewhere it is the mean over
    what is within `radius`, dry parts with 0 and what is behind boundaries or in other bodies left out; each particle's
    pressure is carried to the probe hydrostatically, and where four fifths are wet, the mean is over those. In frames
    and recordings it is the mean over the time since the frame before, over all steps, and so is the force on a
    boundary or body: of the first frame, as of `simulation[probe].pressure`, it is that of the present.

    A weakly compressible fluid rings, and a front of water, which is a particle thin, is stopped by a wall within the
    time that sound takes for a spacing: values over a few times of sound through the radius are the method's and not
    the water's. Frames that are twenty or more of these apart show what a sensor of that size would, if there are five
    spacings or more along its radius: a coarser front bounces off as a whole, with several times the pressure.

    Args:
        position: where [m], in the fluid's domain or on a wall of it.
        radius: of the mean [m]; None: the kernel's support, three spacings.
        name: a name by which results can be asked for.

    Raises:
        SceneError: a value is out of range; later, with a scene, there is no fluid, or the position is behind a
            boundary or outside of the periodic domain.

    Source: D. Shepard, ACM National Conference (1968) 517.
    """

    position: Vector
    radius: float | None = field(default=None, kw_only=True)
    name: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        self._set(
            position=vector(self.position, "Probe.position"),
            radius=None if self.radius is None else span(self.radius, "Probe.radius"),
            name=None if self.name is None else text(self.name, "Probe.name"),
        )
