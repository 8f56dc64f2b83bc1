"""Symptoms "overlaps" and "sinks": rigid bodies are within each other, at the start or at rest."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from physcore.simulation.notes import SUNK
from physcore.simulation.overlapping import RigidOverlap, overlaps
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

PLACED = 1e-4
"""Largest overlap at the start, relative to the size of the smaller body: below what is seen, above rounding."""
GROWING = 1.1
"""Ratio of the last depth to the first one above which bodies still sink."""
AIM = 0.5
"""Overlap that a cure leaves, relative to the largest one."""
LATE, MOST_FRAMES = 2.0 / 3.0, 8
"""Fraction of a recording after which bodies should rest, and number of frames that are examined."""


def overlapping(case: Case) -> Iterator[Finding]:
    """Find overlaps of rigid bodies at the start of a run."""
    fields = case.rigid
    if fields is None or case.begin > 0.0:
        return
    worst = _deepest(overlaps(case.scene, {name: values[:1] for name, values in fields.items()})[0])
    if worst is not None and worst.depth > PLACED * worst.size:
        figure = f"{_length(case, worst.depth)}, {worst.depth / worst.size:.2g} of the size of the smaller one"
        cause = f"{worst.one} and {worst.other} overlap at the start by {figure}: pushing them apart adds energy"
        cure = f"place them {_length(case, worst.depth)} farther apart; bodies may touch"
        yield Finding("overlaps", cause, cure, worst.depth / worst.size)


def sinks(case: Case) -> Iterator[Finding]:
    """Find rigid bodies that stay within each other, in the last third of a recording or at present."""
    fields = case.rigid
    if fields is None or (case.recording is None and case.begin == 0.0):
        return
    count = len(fields["rigid_positions"])
    frames = np.unique(np.linspace(LATE * (count - 1), count - 1, MOST_FRAMES).astype(np.int64))
    states = overlaps(case.scene, {name: values[frames] for name, values in fields.items()})
    pairs = [{(each.one, each.other): each for each in state} for state in states]
    lasting = [[state[pair] for state in pairs] for pair in pairs[0] if all(pair in state for state in pairs)]
    worst = max(lasting, key=lambda row: min(each.depth / each.size for each in row), default=None)
    if worst is None:
        return
    depth = min(each.depth / each.size for each in worst)
    if depth > SUNK:
        first, last = worst[0], worst[-1]
        still = (
            f", {last.depth / first.depth:.2g} times as deep as before" if last.depth > GROWING * first.depth else ""
        )
        cause = (
            f"{last.one} and {last.other} rest within each other by {_length(case, last.depth)}, {depth:.2g} of the "
            f"size of the smaller one{still}: their contact is not solved for"
        )
        yield Finding("sinks", cause, _cure(case, depth), depth)


def _cure(case: Case, depth: float) -> str:
    """A remedy by more substeps: overlaps at rest fall with their square."""
    solver = case.solver
    factor = math.sqrt(depth / (AIM * SUNK))
    shorter = f"dt={case.plan.dt / factor:.2g}"
    if solver is None:
        return f"take {shorter}"
    return f"take contacts=pc.ContactSolver(substeps={math.ceil(solver.substeps * factor)}), or {shorter}"


def _deepest(found: list[RigidOverlap]) -> RigidOverlap | None:
    """The overlap that is deepest relative to the size of the smaller body."""
    return max(found, key=lambda each: each.depth / each.size, default=None)


def _length(case: Case, value: float) -> str:
    """A length with its unit."""
    return f"{value:.2g}{case.scene.units.suffix('m')}"
