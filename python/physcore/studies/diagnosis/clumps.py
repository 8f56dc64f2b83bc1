"""Symptoms "clumps" and "scatters": the particles of a fluid do not have the given spacing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore.checks import FloatArray
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

LARGEST_RATIO = 1.15
"""Largest ratio of the given spacing to that of the particles, or its inverse.

At this ratio the density of the particles is off by a third in 2D and by a half in 3D. The density of the fluid, in
contrast, varies by a percent. Particles shifted randomly by a tenth of their spacing, or filling a ball, are below this
ratio.
"""
SAMPLE = 500
"""Number of particles whose neighbors are examined. The error of their median is a few percent of the scatter."""


def clumps(case: Case) -> Iterator[Finding]:
    """Compare the spacing of the particles of each fluid with the given one."""
    for body in case.scene.fluids:
        if len(body) <= 2 * body.dimension:
            continue
        lattice = lattice_spacing(body.positions)
        ratio = body.spacing / lattice
        if 1.0 / LARGEST_RATIO <= ratio <= LARGEST_RATIO:
            continue
        close = ratio > 1.0
        name = case.scene.path(body)
        what = "each is pushed by more neighbors than there is room for" if close else "each has too few neighbors"
        meter = case.scene.units.suffix("m")
        cause = (
            f"{name} has spacing={body.spacing:.4g}{meter}, and its particles start {lattice:.4g}{meter} apart: "
            f"{ratio:.3g} times, so that {what}"
        )
        cure = f"give it spacing={lattice:.4g}, or fill it with pc.block(lower, upper, {body.spacing:.4g})"
        yield Finding("clumps" if close else "scatters", cause, cure, ratio)


def lattice_spacing(positions: FloatArray) -> float:
    """Median over the particles of the mean distance of their 2 D nearest neighbors [m], as in a square or cubic
    lattice.
    """
    count = 2 * positions.shape[1]
    some = np.linspace(0, len(positions) - 1, min(len(positions), SAMPLE)).astype(np.int64)
    means = np.empty(len(some))
    for row, particle in enumerate(some):
        squared = ((positions - positions[particle]) ** 2).sum(axis=1)
        nearest = np.partition(squared, count)[: count + 1]  # including itself at distance 0
        means[row] = np.sqrt(nearest).sum() / count
    return float(np.median(means))
