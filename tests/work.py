"""A clock that runs by work: what studies measure in tests does not depend on how busy a machine is."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from physcore import Simulation
from physcore.studies import clock

CALL, STEP, PARTICLE = 2e-5, 1.5e-6, 4e-8
"""Durations of a call, of an evaluation of the forces, and of that for one particle or cell [s]."""
NEIGHBORS = 20.0
"""Duration of an evaluation that looks for neighbors, over that of one without."""


class Work:
    """The work so far [s], and whether a run is being counted."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.counting = False

    def read(self) -> float:
        """The time; reading takes some."""
        self.seconds += CALL
        return self.seconds

    def counted(self, method: Callable[..., Any]) -> Callable[..., Any]:
        """A method of a simulation that adds the work of its steps, those of inner calls once."""

        @functools.wraps(method)
        def wrapped(simulation: Simulation, *arguments: Any, **options: Any) -> Any:
            if self.counting:
                return method(simulation, *arguments, **options)
            self.counting, before = True, simulation.steps
            try:
                return method(simulation, *arguments, **options)
            finally:
                self.counting = False
                grids = [system.grid for system in simulation.scene.systems if hasattr(system, "grid")]
                size = simulation.scene.particles + sum(math.prod(grid.cells) for grid in grids)
                evaluations = (simulation.steps - before) * simulation.evaluations
                evaluations *= NEIGHBORS if simulation.plan.pairs or simulation.scene.fluids else 1.0
                self.seconds += CALL + evaluations * (STEP + PARTICLE * size)

        return wrapped


@contextmanager
def counted() -> Iterator[None]:
    """Let studies read the work of simulations as their time."""
    work = Work()
    with pytest.MonkeyPatch.context() as patch:
        for name in ("step", "run", "record"):
            patch.setattr(Simulation, name, work.counted(getattr(Simulation, name)))
        patch.setattr(clock, "seconds", work.read)
        yield
