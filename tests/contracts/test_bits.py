"""The bits of results do not change from one version to the next, nor from one processor to another.

Those of `bits.json` are the reference.

A change that means to change them writes the file anew, in a commit of its own that says why:

    PYTHONPATH=tests python -m contracts.test_bits
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import physcore as pc
from contracts.comparison import plain
from contracts.scenes import SCENES

REFERENCE = Path(__file__).with_name("bits.json")
LEVELS = ("portable", "avx2", "avx512")


def _of_case(name: str) -> list[np.ndarray]:
    """Positions, velocities, fields, time and the energy budget after some steps, in double precision."""
    run = plain(name)
    energy = run.energy()
    budget = [run.time, energy.kinetic, *energy.by_term.values(), energy.internal, *energy.dissipated_by.values()]
    fields = [values for system in run.scene.systems for values in run[system].fields.values()]
    turned = [values for body in run.scene.bodies if body.is_rigid for values in run[body].fields.values()]
    return [run.positions, run.velocities, *fields, *turned, np.array([*budget, energy.work])]


def _slanted() -> list[np.ndarray]:
    """A sheet along slanted axes, a block and a disc, and the time steps that follow."""
    axes = ((0.7, 0.1, 0.2), (-0.3, 0.65, 0.725))
    cloth = pc.cloth((7, 6), 0.1, 50.0, 0.03, origin=(0.1, 0.2, 0.3), axes=axes, material=pc.materials.denim)
    jelly = pc.soft_body((4, 5, 3), 0.3, 100.0, 0.1, origin=(0.1, 0.7, -0.2))
    plane = pc.Plane((0.1, 0.2, -0.9), normal=(0.3, -0.2, 1.3))
    scene = pc.Scene(cloth, jelly, pc.Dihedral(cloth, 0.01), pc.Gravity((0.0, 0.0, -9.81)), plane)
    steps = [pc.Simulation(scene, integrator).dt for integrator in (pc.VelocityVerlet(), pc.RungeKutta4())]
    disc = pc.ball((0.1, 0.2), 0.7, 0.1)
    return [cloth.positions, jelly.positions, cloth.rest_length, cloth.mass, disc, np.array(steps)]


def _pulses() -> list[np.ndarray]:
    """Packets and pulses that the package computes."""
    grid = pc.Grid((30, 20), 0.13, periodic=(True, False))
    return [pc.wave_packet(grid, (1.7, 1.1), (3.0, -2.0), (0.4, 0.3)), pc.Ricker(0.7)(np.linspace(0.0, 4.0, 99))]


def _exponents() -> list[np.ndarray]:
    """Lyapunov exponents of tracers, and of rods, with their errors."""
    starts = np.random.default_rng(3).uniform((-1.0, -1.0, 24.0), (1.0, 1.0, 26.0), (6, 3))
    flow = pc.lyapunov(pc.Tracers(starts, pc.Lorenz()), duration=2.0, dt=0.01)
    rods = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [[0, 1], [1, 2]], np.inf, fixed=[0])
    pendulum = pc.lyapunov(pc.Scene(rods, pc.Gravity((0.0, -9.81))), duration=2.0, exponents=2, dt=0.01)
    return [np.asarray(getattr(found, name)) for found in (flow, pendulum) for name in ("exponents", "errors", "each")]


def _accurate() -> list[np.ndarray]:
    """A run whose steps follow from the accuracy that it is asked for."""
    ball = pc.Particles([[1.0, 0.0]], [[0.0, 0.8]])
    scene = pc.Scene(ball, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))
    recording = pc.simulate(scene, 6.0, fps=4.0, accuracy=1e-6)
    return [recording.positions, np.array([recording.plan.dt])]


RESULTS: dict[str, Callable[[], list[np.ndarray]]] = {
    **{name: lambda name=name: _of_case(name) for name in SCENES},
    "bodies along slanted axes": _slanted,
    "packets and pulses": _pulses,
    "Lyapunov exponents": _exponents,
    "accuracy": _accurate,
}
"""What the package computes from numbers that are rounded alike everywhere."""


def bits(name: str) -> str:
    """A hash of a result."""
    content = b"".join(np.asarray(values).tobytes() for values in RESULTS[name]())
    return hashlib.blake2b(content, digest_size=12).hexdigest()


def reference() -> dict[str, str]:
    """The hashes that results have to have."""
    return json.loads(REFERENCE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", RESULTS)
def test_the_bits_are_those_of_the_reference(name):
    assert bits(name) == reference()[name]


def test_the_reference_has_no_scene_that_is_gone():
    assert set(reference()) == set(RESULTS)


def _vector_units() -> str:
    """All sets of instructions that NumPy can do without, of those that the processor has."""
    from numpy._core import _multiarray_umath as core

    return " ".join(unit for unit in core.__cpu_dispatch__ if core.__cpu_features__.get(unit))


OTHER_MACHINES = {
    "NumPy without vector instructions": lambda: {"NPY_DISABLE_CPU_FEATURES": _vector_units()},
    "BLAS of an old processor": lambda: {"OPENBLAS_CORETYPE": "Prescott"},
    "a C library without FMA": lambda: {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F"},
}
"""What other processors do to the libraries below, as variables of the environment."""


@pytest.mark.parametrize("machine", OTHER_MACHINES)
def test_the_bits_are_the_same_on_other_machines(machine):
    """Each machine computes with another level, of those that this processor and this build have."""
    program = "from contracts.test_bits import *; print(json.dumps({name: bits(name) for name in RESULTS}))"
    package = os.path.dirname(os.path.dirname(pc.__file__))
    path = os.pathsep.join([str(Path(__file__).parent.parent), package])
    first = list(OTHER_MACHINES).index(machine)
    for level in LEVELS[first:] + LEVELS[:first]:
        environment = {**os.environ, "PYTHONPATH": path, "PHYSCORE_SIMD": level, **OTHER_MACHINES[machine]()}
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if "PHYSCORE_SIMD: expected a level that is here" not in done.stderr:
            break
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == reference()


if __name__ == "__main__":
    REFERENCE.write_text(json.dumps({name: bits(name) for name in RESULTS}, indent=2) + "\n", encoding="utf-8")
