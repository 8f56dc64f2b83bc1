"""The base of all methods for fluids."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.scene.fluid import Fluid
from physcore.units.systems import UnitSystem


@dataclass(frozen=True)
class FluidMethod:
    """A way to compute the flow of a Fluid. Methods of the same kind and parameters are equal.

        method = pc.WeaklyCompressible(sound_speed=40.0)  # a FluidMethod
        water, tank = pc.Fluid.block((0.0, 0.0), (0.4, 0.6), spacing=0.05), pc.Box((0.0, 0.0), (1.2, 1.0))
        recording = pc.simulate(pc.Scene(water, pc.Gravity(), tank), 0.1, fluids=method)

    To add one: a file here, a line in `FLUID_METHODS`, and a scheme of the same name in Rust (`ARCHITECTURE.md`).
    """

    def check(self, fluid: Fluid, path: str, units: UnitSystem) -> None:
        """Look at a fluid that it is to compute, and warn of what was hardly meant; `path` is where it stands,
        `units` are those of the scene.
        """
