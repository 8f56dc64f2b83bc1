"""Probes, which measure the pressure of fluids at a point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import ClassVar

from physcore.checks import Vector, span, text, vector
from physcore.scene.fields import Element
from physcore.scene.items import SceneItem


@dataclass(frozen=True)
class Probe(SceneItem):
    """Probe: a point at which the pressure of fluids is measured, like a sensor in a wall.

        water = pc.Fluid.block((0.0, 0.0), (0.4, 0.6), spacing=0.05)
        probe = pc.Probe((1.2, 0.0), name="P1")
        tank = pc.Box((0.0, 0.0), (1.2, 1.0))
        recording = pc.simulate(pc.Scene(water, pc.Gravity(), tank, probe), 0.5)
        recording[probe].pressure  # (F,)
        recording[tank].force  # (F, D), on the tank

    A probe within a tenth of `radius` from a boundary measures the pressure [Pa] of the fluid on the wall. The pressure
    is a mean over the part of the wall within `radius`, weighted by the fluid's kernel with this support. Elsewhere the
    pressure is the mean over the space within `radius`. Dry parts count with 0; regions behind boundaries or in other
    bodies are excluded. Each particle's pressure is extrapolated hydrostatically to the probe. If at least four fifths
    are wet, the mean is over the wet part. In frames and recordings, the pressure is a time average over all steps
    since the previous frame. The force on a boundary or body is averaged likewise. In the first frame, and in
    `simulation[probe].pressure`, the value is that of the present.

    A weakly compressible fluid has acoustic oscillations. A front of water is one particle thick, and a wall stops it
    within the time in which sound travels one spacing. Averages over a few acoustic times, radius / sound speed,
    therefore show the method and not the water. Frames at intervals of at least twenty acoustic times show the values
    of a sensor of this size, if the radius has at least five spacings. With fewer, a front is reflected as a whole,
    with several times the pressure.

    Args:
        position: position [m], in the fluid's domain or on its wall.
        radius: radius of the mean [m]; None: the kernel's support, three spacings.
        name: name of the probe, also a key into results.

    Raises:
        SceneError: a value is out of range. Scene raises it if there is no fluid, or if the position is behind a
            boundary
            or outside of the periodic domain.

    Source: D. Shepard, ACM National Conference (1968) 517.
    """

    section: ClassVar[str] = "probes"
    elements: ClassVar[Mapping[Element, int]] = MappingProxyType({"probes": 1})

    position: Vector
    radius: float | None = field(default=None, kw_only=True)
    name: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        self._set(
            position=vector(self.position, "Probe.position"),
            radius=None if self.radius is None else span(self.radius, "Probe.radius"),
            name=None if self.name is None else text(self.name, "Probe.name"),
        )
