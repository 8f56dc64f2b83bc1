"""The defaults on textbook scenes: right whatever the frame rate."""

from __future__ import annotations

import math
import os

import pytest

import physcore as pc
from physcore.integrators import INTEGRATORS
from textbook import TEN, TEXTBOOK, Textbook

LONG = os.environ.get("PHYSCORE_TESTS") == "long"
RATES = [5.0, 30.0, 120.0]
"""Frames per second: all of them in `make test-long`, else one for each scene in turns."""


@pytest.mark.parametrize(
    ("case", "fps"),
    [
        pytest.param(case, fps, id=f"{case.name}-{fps}")
        for number, case in enumerate(TEXTBOOK)
        for fps in (RATES if LONG else [RATES[number % 3]])
    ],
)
def test_all_defaults_are_within_a_percent_of_the_truth(case: Textbook, fps: float) -> None:
    recording = pc.simulate(case.scene, case.duration, fps=fps)
    assert case.error(recording) <= 0.01


@pytest.mark.parametrize("kind", [kind for kind in INTEGRATORS if kind.resolving < 1.0], ids=lambda kind: kind.__name__)
def test_a_resolved_oscillation_is_off_by_half_a_percent(kind: type[pc.Integrator]) -> None:
    """Not by far less either, which would cost steps for nothing, but for a method whose amplitude falls for ever."""
    ends = [[0.0, 0.0], [1.2, 0.0]]
    scene = pc.Scene(pc.SpringNetwork(ends, [[0, 1]], 1.0, rest_length=1.0, mass=1.0, fixed=[0]))
    largest = kind.resolving * pc.stability_limit(scene, kind())
    steps = math.ceil(TEN / largest)
    simulation = pc.Simulation(scene, kind(), dt=TEN / steps)
    worst = 0.0
    for _ in range(steps):
        simulation.step()
        worst = max(worst, abs(simulation.positions[1, 0] - 1.0 - 0.2 * math.cos(simulation.time)))
    least = 0.0 if kind is pc.DormandPrince5 else 0.2 * 0.005 / 3.0
    assert least <= worst <= 0.2 * 0.005
