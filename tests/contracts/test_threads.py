"""The bits are the same for any number of threads, and on every level of vector instructions."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import physcore as pc
from contracts.scenes import SCENES, Case

LARGE = {name: case for name, case in SCENES.items() if case.large is not None}
BLOCK = 4096
"""The most particles in a block, which one thread takes whole."""
SHARED_STEPS = 12
"""A batch of so many steps of a large scene takes more than the 2 ms that the calling thread takes by itself."""


def after(case: Case, threads: int) -> tuple[str, dict[str, object]]:
    """The state and the energy budget of a large scene after some steps."""
    assert case.large is not None
    run = case.simulation(case.large(), dt=case.dt / 10.0, threads=threads)
    cells = sum(values.size for system in run.scene.systems for values in run[system].fields.values())
    assert run.scene.particles + cells > BLOCK
    assert run.plan.threads == threads
    run.step(SHARED_STEPS)
    return run.state_hash(), vars(run.energy())


@pytest.mark.parametrize("name", LARGE)
def test_any_number_of_threads_gives_the_same_bits(name):
    """Every particle sums its own forces in a fixed order, and reductions run over fixed blocks."""
    alone = after(LARGE[name], 1)
    for threads in (2, 3):
        assert after(LARGE[name], threads) == alone


def fingerprints() -> list[str]:
    """Of every scene after its steps: the state, and the budget to the bit."""
    result = []
    for name, case in SCENES.items():
        run = case.advance(case.simulation(threads=1))
        energy = run.energy()
        budget = (energy.total, energy.dissipated, energy.work)
        result.append(" ".join([name, run.state_hash(), *(value.hex() for value in budget)]))
    return result


@pytest.fixture(scope="module")
def present() -> list[str]:
    return fingerprints()


@pytest.mark.parametrize("level", ["scalar", "avx2", "avx512"])
def test_every_level_of_vector_instructions_gives_the_same_bits(level, present):
    """No fused multiply-add, no reciprocal estimates, and the same lanes on every level."""
    program = "from contracts.test_threads import fingerprints; print(*fingerprints(), sep='\\n')"
    package = os.path.dirname(os.path.dirname(pc.__file__))
    path = os.pathsep.join([str(Path(__file__).parent.parent), package])
    environment = {**os.environ, "PHYSCORE_SIMD": level, "PYTHONPATH": path}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0 and "PHYSCORE_SIMD" in done.stderr:
        pytest.skip(f"this machine has no {level}")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == present
