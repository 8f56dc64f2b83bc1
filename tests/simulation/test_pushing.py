"""What pushing overlapping bodies apart adds is metered, stated in the plan, and the drift of the balance."""

from __future__ import annotations

import re

import numpy as np
import pytest

import physcore as pc

OVERLAPS = pytest.mark.filterwarnings("ignore:.* overlaps .* at the start by:physcore.SceneWarning")
G, SIDE = 9.81, 0.2
SOLVERS = {"small": pc.ContactSolver(), "large": pc.ContactSolver(sequential=0)}


def stack(overlap: float) -> pc.Scene:
    """Three boxes of 1 kg, each of which overlaps with what is below."""
    heights = [(0.5 + k) * SIDE - (k + 1) * overlap for k in range(3)]
    boxes = pc.RigidBodies(pc.Rectangle(SIDE, SIDE), [(0.0, y) for y in heights], mass=1.0, friction=0.5, name="boxes")
    return pc.Scene(boxes, pc.Gravity((0.0, -G)), pc.Floor(0.0, restitution=0.0, friction=0.5))


def stated(plan: pc.Plan) -> float:
    """The energy that the plan states [J]; 0 without a note."""
    texts = [note for note in plan.notes if "pushing" in note]
    found = [re.search(r"has added (\S+) J so far, which shows as drift", text) for text in texts]
    return float(found[0][1]) if found and found[0] else 0.0


@OVERLAPS
@pytest.mark.filterwarnings("ignore:the energy balance drifted")
@pytest.mark.parametrize("solver", SOLVERS)
def test_pushing_adds_the_energy_by_which_it_lifts(solver):
    """The bodies are lifted by up to three overlaps, and land softly again: the balance drifts by both.

    The meter is the force of contacts times the growth of gaps. The overlaps that remain in a large group, and the
    speeds at which pushing begins and ends, are 3 % of it.
    """
    overlap = 5e-4
    recording = pc.simulate(stack(overlap), 1.0, dt=1 / 240, contacts=SOLVERS[solver])
    heights, energy = recording["boxes"].positions[:, :, 1], recording.energy
    lifted = G * float((heights[-1] - heights[0]).sum())
    assert lifted == pytest.approx(G * 6.0 * overlap, rel=0.02)
    drift = float(energy.balance[-1] - energy.balance[0])
    assert drift == pytest.approx(lifted + energy.dissipated[-1], rel=1e-9)
    assert stated(recording.plan) == pytest.approx(drift, rel=0.03)
    assert (np.diff(energy.dissipated) >= 0.0).all()
    assert energy.dissipated[-1] < 0.02 * lifted
    assert (energy.work == 0.0).all()


def test_few_bodies_that_touch_are_not_pushed():
    assert stated(pc.simulate(stack(0.0), 0.2, dt=1 / 240).plan) == 0.0


@pytest.mark.filterwarnings("ignore:the energy balance drifted")
def test_many_bodies_that_sink_and_are_pushed_up_again_drift_by_it():
    """Sweeps begin without loads: the stack sinks by 2e-5 m, is pushed up, and falls back."""
    recording = pc.simulate(stack(0.0), 1.0, dt=1 / 240, contacts=SOLVERS["large"])
    drift = float(recording.energy.balance[-1] - recording.energy.balance[0])
    assert drift > 0.0
    assert stated(recording.plan) == pytest.approx(drift, rel=0.2)


@OVERLAPS
def test_a_checkpoint_has_what_was_added(tmp_path):
    run = pc.Simulation(stack(5e-4), dt=1 / 240)
    run.step(10)
    run.save(tmp_path / "stack")
    assert stated(run.plan) > 0.0
    assert stated(pc.load(tmp_path / "stack").plan) == stated(run.plan)


def test_an_impact_of_bodies_that_overlap_dissipates_no_less():
    """Two discs that meet at 2 m/s without restitution lose all of their energy, whatever they overlap by then."""
    for solver in SOLVERS.values():
        discs = pc.RigidBodies(
            pc.Disc(0.1), [(-0.1003, 0.0), (0.1, 0.0)], velocities=[(1.0, 0.0), (-1.0, 0.0)], mass=1.0, friction=0.0
        )
        recording = pc.simulate(pc.Scene(discs), 0.2, dt=1 / 240, contacts=solver)
        assert recording.energy.dissipated[-1] == pytest.approx(1.0, rel=1e-3)
        assert np.abs(recording.energy.drift).max() < 1e-3
