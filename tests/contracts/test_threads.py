"""The bits are the same for any number of threads."""

from __future__ import annotations

import pytest

import physcore as pc
from contracts.scenes import SCENES, Case

LARGE = {name: case for name, case in SCENES.items() if case.large is not None}
BLOCK = 4096
"""The most particles in a block, which one thread takes whole."""
SHARED_STEPS = 12
"""A batch of so many steps of a large scene takes more than the 2 ms that the calling thread takes by itself."""
PAIRS = 100_000
"""With so many pairs a quarter of the steps does."""


def after(case: Case, scene: pc.Scene, threads: int) -> tuple[str, dict[str, object]]:
    """The state and the energy budget of a large scene of a case after some steps."""
    run = case.simulation(scene, dt=case.dt / 10.0, threads=threads)
    cells = sum(values.size for system in run.scene.systems for values in run[system].fields.values())
    assert sum(map(len, run.scene.bodies)) + cells > BLOCK
    assert run.plan.threads == threads
    run.step(SHARED_STEPS if run.plan.pairs < PAIRS else SHARED_STEPS // 4)
    return run.state_hash(), vars(run.energy())


@pytest.mark.parametrize("name", LARGE)
def test_any_number_of_threads_gives_the_same_bits(name):
    """Every particle sums its own forces in a fixed order, and reductions run over fixed blocks.

    Scenes run with two and with three threads in turns: kinds of items stand in several.
    """
    threads = 2 + list(LARGE).index(name) % 2
    case = LARGE[name]
    assert case.large is not None
    scene = case.large()
    assert after(case, scene, threads) == after(case, scene, 1)
