"""A heavy fluid lies on a light one, sinks into it as a mushroom and rolls up at its rim; pale is fast.

The physics checked: the first ripple grows nearly as the linear theory has it, and what the heavy fluid loses in
height both have as motion or heat.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

DENSITIES = (1.0, 1.8)
"""Of the light and the heavy fluid [kg/m³]."""
RIPPLE = 0.04
"""The amplitude that the surface between them begins with [m]; its wavelength is the width of the tank, one meter."""

DURATION = 6.0
"""[s]"""


def scene() -> pc.Scene:
    """Fill a tank of two square meters, where gravity is one meter per second squared."""
    spacing, upper = 1 / 64, (1.0, 2.0)
    cells = pc.block((0.0, 0.0), upper, spacing)
    above = cells[:, 1] > 1.0 + RIPPLE * np.cos(2.0 * np.pi * cells[:, 0])
    light, heavy = (
        pc.Fluid(cells[part], spacing, density, name=name)
        for part, density, name in zip((~above, above), DENSITIES, ("light", "heavy"), strict=True)
    )
    return pc.Scene(light, heavy, pc.Gravity((0.0, -1.0)), pc.Box((0.0, 0.0), upper))


def main(path: str | os.PathLike[str] = "rayleigh_taylor.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=15, progress=progress)
    light, heavy = recording.scene.bodies
    styles = [
        pc.styles.Fluid(on=light, colormap="water", top=1.2, surface=True),
        pc.styles.Fluid(on=heavy, colormap="ember", top=1.2, surface=True),
    ]
    pc.film(recording, path, size=(360, 720), style=styles, progress=progress)
    return {"fluids": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """How much the ripple has grown after a second: by cosh(√(A g k) t) from rest, A = 0.8/2.8 by the densities.

    Its amplitude a is what Σ cos(kx) over the heavy fluid says, −a/2 by area. In the first second viscosity takes νk² t
    from the exponent: 2μ/(ρ₁ + ρ₂) and αhc/8 together 0.05, so 5 % of the growth. The rest that is missing, less than
    twice as much, is what rows of the lattice withstand before they slip.

    Source: G. I. Taylor, Proc. R. Soc. A 201, 192 (1950).
    """
    heavy = recordings["fluids"]["heavy"]
    ripple = -np.cos(2.0 * np.pi * heavy.positions[..., 0]).sum(axis=1)
    growth = ripple[np.argmin(abs(heavy.times - 1.0))] / ripple[0]
    light, dense = DENSITIES
    expected = np.cosh(np.sqrt((dense - light) / (dense + light) * 2.0 * np.pi))
    return Figure("growth of the ripple in a second", float(growth), float(expected), "by the linear theory", 0.15)
