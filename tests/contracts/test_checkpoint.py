"""A run that is saved and loaded, copied or sent to another process on its way ends in the same bits."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import physcore as pc
from contracts.comparison import plain
from contracts.scenes import SCENES, STEPS
from physcore.scene.records import Record
from physcore.simulation import step_size


def loaded(run: pc.Simulation, folder: Path) -> pc.Simulation:
    run.save(folder / "half")
    result = pc.load(folder / "half")
    assert isinstance(result, pc.Simulation)
    return result


WAYS: dict[str, Callable[[pc.Simulation, Path], pc.Simulation]] = {
    "file": loaded,
    "pickle": lambda run, folder: pickle.loads(pickle.dumps(run)),
    "copy": lambda run, folder: copy.copy(run),
    "deep copy": lambda run, folder: copy.deepcopy(run),
}


def outcome(run: pc.Simulation) -> dict[str, Any]:
    """Everything that two runs of the same bits have in common."""
    return {"hash": run.state_hash(), "dt": run.dt, "provenance": run.provenance, "energy": vars(run.energy())}


def ways(run: pc.Simulation) -> dict[str, Callable[[pc.Simulation, Path], pc.Simulation]]:
    """How this run can be passed on: not as code, which tests/storage/test_storage.py holds."""
    has_code = any(Record.of(item).code for item in (*run.scene.forces, *run.scene.systems))
    return {name: way for name, way in WAYS.items() if not (has_code and name in ("file", "pickle"))}


@pytest.mark.parametrize("name", SCENES)
def test_a_run_goes_on_from_its_checkpoint_in_the_same_bits(name, tmp_path):
    """And so does the run that was saved. Where steps follow the motion, an interval's end is part of its history."""
    case = SCENES[name]
    part = STEPS // 3
    whole, first = case.simulation() if case.adaptive else plain(name), case.simulation()
    if case.adaptive:
        for steps in (part, STEPS - part):
            case.advance(whole, steps)
    case.advance(first, part)
    present = outcome(first)
    for way, passed_on in ways(first).items():
        second = passed_on(first, tmp_path)
        assert outcome(first) == outcome(second) == present, way
        case.advance(second, STEPS - part)
        assert outcome(second) == outcome(whole), way
    case.advance(first, STEPS - part)
    assert outcome(first) == outcome(whole)


UNBOUNDED = {
    "network ExplicitEuler": "has no stable step",
    "grains BackwardEuler": "has forces that jump, for which long steps have no solution",
    "swarm quadratic drag": "becomes unstable as it falls, before the limit is looked at again",
}


def keeps_to_a_limit(name: str) -> bool:
    case = SCENES[name]
    # Of rods dt="auto" follows the motion.
    return not case.adaptive and not case.is_self_adaptive and not case.shared.has_rods and name not in UNBOUNDED


@pytest.mark.parametrize("name", [name for name in SCENES if keeps_to_a_limit(name)])
def test_limits_that_the_time_step_keeps_to_are_part_of_a_checkpoint(name, tmp_path, monkeypatch):
    """With dt="auto" the limit is looked at every 8 steps in fluids, and every 256 elsewhere, here 32: past the
    checkpoint.
    """
    monkeypatch.setattr(step_size, "CHECK_INTERVAL", 32)
    case = SCENES[name]
    steps, part = (30, 11) if case.shared.fluids else (80, 40)
    whole, first = case.simulation(dt="auto"), case.simulation(dt="auto")
    whole.step(steps)
    first.step(part)
    second = next(iter(ways(first).values()))(first, tmp_path)
    second.step(steps - part)
    assert outcome(second) == outcome(whole)


def test_a_run_that_diverges_is_saved_and_read_back(tmp_path):
    """Its positions and velocities are finite, its accelerations and energies, some 1e154², are not any more."""
    scene = pc.Scene(pc.soft_body((2, 2), 7e5, 7e5, 2.5e5, 2.5e-5))
    with pytest.warns(pc.StabilityWarning, match="will blow up|may blow up"):
        run = pc.Simulation(scene, pc.BogackiShampine3(), 1e-2, on_divergence="ignore")
    with pytest.raises(pc.SimulationDiverged):
        run.step(40)
    assert loaded(run, tmp_path).state_hash() == run.state_hash()
