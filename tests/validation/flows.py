"""What the validation of fluids shares: scenes with the defaults of `pc.Fluid`, and how their budget is judged."""

from __future__ import annotations

from typing import Any

import numpy as np

import physcore as pc
from physics.laboratory import Array

GRAVITY = pc.Gravity((0.0, -9.81))

SOLITARY: dict[str, Any] = {"threads": 1}


def start(*items: Any, **numerics: Any) -> pc.Simulation:
    """On one thread, with what is chosen for a fluid by default: half of the limit, in single precision."""
    return pc.Simulation(pc.Scene(*items), **{**SOLITARY, **numerics})


def hole(energy: pc.EnergySeries) -> float:
    """What is missing from the energy budget at the worst, in units of what was released (`energy.drift`)."""
    return float(np.abs(energy.drift).max())


def widest_hole(energy: pc.EnergySeries) -> float:
    """What may be missing, in the same units, at half of the limit.

    A leapfrog keeps the energy of an oscillation to (ω dt)²/8 of it: with dt = 1/ω that is one eighth for the shortest
    sound and nothing for the flow, so one eighth of what compression stores if all of it were in such waves. What is
    taken is metered in the middle of a step: it adds less.
    """
    scale = energy.kinetic.max() + np.ptp(energy.potential) + np.ptp(energy.internal)
    return float(np.ptp(energy.internal) / 8.0 / scale)


def half_axes(positions: Array) -> Array:
    """Of an ellipse that particles fill evenly, along x and y (…, 2): the mean of x² is a²/4."""
    return 2.0 * np.sqrt((positions**2).mean(axis=-2))


def covered_area(positions: Array, spacing: float) -> float:
    """The area that discs around the particles cover, with a radius of spacing/√2: on a square lattice without a gap.

    Counted in cells of an eighth of the spacing.
    """
    cell = spacing / 8.0
    reach = np.arange(-6, 7)
    disc = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2)
    disc = disc[(disc**2).sum(axis=1) <= (spacing / cell) ** 2 / 2.0]
    cells = np.rint(positions / cell).astype(int)[:, None] + disc
    return len(np.unique(cells.reshape(-1, 2), axis=0)) * cell**2


def damped_wave(times: Array, values: Array, omega: float, loss: float = 0.22) -> tuple[float, float]:
    """ω and γ of exp(−γt) cos(ωt + φ), by least squares over shifts of ω by 5 % and 2πγ/ω of up to `loss`."""
    best, found = np.inf, (0.0, 0.0)
    for frequency in omega * np.linspace(0.95, 1.05, 201):
        waves = np.stack([np.cos(frequency * times), np.sin(frequency * times)], axis=1)
        for rate in omega / (2.0 * np.pi) * np.linspace(-0.02, loss, 121):
            basis = np.exp(-rate * times)[:, None] * waves
            amplitudes = np.linalg.solve(basis.T @ basis, basis.T @ values)
            error = float(((basis @ amplitudes - values) ** 2).sum())
            if error < best:
                best, found = error, (float(frequency), float(rate))
    return found
