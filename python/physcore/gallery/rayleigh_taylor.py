"""A heavy fluid lies on a light one, sinks into it as a mushroom and rolls up at its rim; pale is fast.

The physics checked: the initial ripple grows nearly as in the linear theory. The energy released by the heavy fluid
becomes motion and heat of both.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

DENSITIES = (1.0, 1.8)
"""Densities of the light and the heavy fluid [kg/m³]."""
RIPPLE = 0.04
"""Initial amplitude of the interface [m]; its wavelength is the width of the tank, 1 m."""

DURATION = 6.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """Two fluids in a tank of 2 m², with a gravity of 1 m/s²."""
    spacing, upper = 1 / 64, (1.0, 2.0)
    cells = pc.block((0.0, 0.0), upper, spacing)
    above = cells[:, 1] > 1.0 + RIPPLE * np.cos(2.0 * np.pi * cells[:, 0])
    light, heavy = (
        pc.Fluid(cells[part], spacing, density, name=name)
        for part, density, name in zip((~above, above), DENSITIES, ("light", "heavy"), strict=True)
    )
    return pc.Scene(light, heavy, pc.Gravity((0.0, -1.0)), pc.Box((0.0, 0.0), upper))


def main(path: str | os.PathLike[str] = "rayleigh_taylor.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=15, progress=progress)
    light, heavy = recording.scene.bodies
    styles = [
        pc.styles.Fluid(on=light, top=1.2, surface=True),
        pc.styles.Fluid(on=heavy, colormap="ember", top=1.2, surface=True),
    ]
    pc.film(
        recording,
        path,
        size=(360, 772),
        style=styles,
        max_bytes=3_000_000,
        title="Rayleigh–Taylor instability",
        subtitle="A heavy fluid sinks into a light one as a mushroom",
        progress=progress,
    )
    return {"fluids": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Growth of the ripple in the first second: cosh(√(A g k) t) from rest, with the Atwood number A = 0.8/2.8.

    The amplitude a follows from Σ cos(kx) over the heavy fluid, which is −a/2 per area. In the first second, viscosity
    reduces the exponent by νk² t. Together 2μ/(ρ₁ + ρ₂) and αhc/8 give 0.05, which is 5 % of the growth. The remaining
    difference is less than twice as large; rows of the particle lattice resist shear until they slip.

    Source: G. I. Taylor, Proc. R. Soc. A 201, 192 (1950).
    """
    heavy = recordings["fluids"]["heavy"]
    ripple = -np.cos(2.0 * np.pi * heavy.positions[..., 0]).sum(axis=1)
    growth = ripple[np.argmin(abs(heavy.times - 1.0))] / ripple[0]
    light, dense = DENSITIES
    expected = np.cosh(np.sqrt((dense - light) / (dense + light) * 2.0 * np.pi))
    return Figure("growth of the ripple in a second", float(growth), float(expected), "by the linear theory", 0.15)
