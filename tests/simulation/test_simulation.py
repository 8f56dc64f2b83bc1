"""Simulations: the state and its parts, and what may be done to them between steps."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import physcore as pc

GRAVITY = pc.Gravity((0.0, -10.0))
LINE = np.arange(5.0)[:, None] * [1.0, 0.0]


def test_bodies_are_joined_in_scene_order_and_found_again():
    one = pc.Particles([[0.0, 0.0]], name="one")
    two = pc.Particles([[1.0, 0.0], [2.0, 0.0]], velocities=[0.0, 3.0])
    simulation = pc.Simulation(pc.Scene(two, GRAVITY, one), dt=0.5)
    assert simulation.positions.tolist() == [[1.0, 0.0], [2.0, 0.0], [0.0, 0.0]]
    assert simulation[two].velocities.tolist() == [[0.0, 3.0], [0.0, 3.0]]
    assert simulation["one"].positions.tolist() == simulation[1].positions.tolist() == [[0.0, 0.0]]
    simulation.step(2)
    assert simulation[one].time == 1.0
    assert simulation[one].positions.tolist() == [[0.0, -5.0]]
    with pytest.raises(KeyError):
        simulation["three"]


@pytest.mark.parametrize(
    ("items", "pairs"),
    [
        ([pc.Particles(LINE, radius=0.1), GRAVITY, pc.Drag(linear=1.0), pc.Drag(quadratic=1.0)], 0),
        ([pc.rope(5, 1.0, 10.0), GRAVITY], 4),
        ([pc.Particles(LINE, radius=3.0), pc.SoftSpheres(1.0)], 5 * 4),
        ([pc.Particles(LINE), pc.LennardJones(1.0, 1.0, cutoff=9.0)], 5 * 4),
        ([pc.Fluid(pc.block((0.0, 0.0), (0.2, 0.2), 0.1), 0.1, surface_tension=0.1)], 2 * 4 * 3),
    ],
)
def test_the_plan_counts_springs_and_the_neighbors_of_each(items, pairs):
    """All are near each other here. A fluid goes through its neighbors twice: for densities and for forces."""
    assert pc.Simulation(pc.Scene(*items), dt=1e-6).plan.pairs == pairs


def test_results_are_copies():
    simulation = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]])))
    simulation.positions[:] = 7.0
    assert simulation.positions.tolist() == [[0.0, 0.0]]


def test_a_fixed_particle_keeps_its_velocity_and_is_left_out_of_the_momentum():
    body = pc.Particles([[0.0, 0.0], [1.0, 0.0]], velocities=[[0.5, 0.0], [0.0, 1.0]], mass=2.0, fixed=[0])
    simulation = pc.Simulation(pc.Scene(body, GRAVITY), dt=0.25)
    assert simulation.momentum().tolist() == [0.0, 2.0]
    assert simulation.energy().kinetic == 1.0
    simulation.step(8)
    assert simulation.positions[0].tolist() == [1.0, 0.0]
    assert simulation.velocities[0].tolist() == [0.5, 0.0]


def test_the_energy_budget_of_a_falling_particle():
    body = pc.Particles([[0.0, 3.0]], velocities=[[4.0, 0.0]], mass=2.0)
    energy = pc.Simulation(pc.Scene(body, GRAVITY)).energy()
    assert energy.kinetic == 16.0
    assert energy.by_term == {"gravity": 60.0}
    assert energy.potential == 60.0
    assert energy.total == energy.balance == 76.0
    assert (energy.dissipated, energy.work, energy.time) == (0.0, 0.0, 0.0)


def test_a_scene_without_forces_has_no_potential_energy():
    energy = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]], velocities=1.0))).energy()
    assert energy.by_term == {}
    assert energy.potential == 0.0
    assert energy.total == 1.0


def test_setting_the_state_counts_as_work():
    body = pc.Particles([[0.0, 0.0], [1.0, 0.0]], mass=2.0)
    other = pc.Particles([[5.0, 0.0]])
    simulation = pc.Simulation(pc.Scene(body, other, GRAVITY), dt=0.1)
    before = simulation.energy().balance
    simulation.set(velocities={body: [[1.0, 0.0], [0.0, 2.0]]}, positions={other: [5.0, 1.0]})
    assert simulation[other].positions.tolist() == [[5.0, 1.0]]
    assert simulation[body].velocities.tolist() == [[1.0, 0.0], [0.0, 2.0]]
    energy = simulation.energy()
    assert energy.work == 1.0 + 4.0 + 10.0
    assert energy.balance == before
    simulation.set(positions=np.zeros((3, 2)))
    assert not simulation.positions.any()


def test_divergence_explains_itself_and_the_simulation_stands_before_it():
    scene = pc.Scene(pc.SpringNetwork([[0.0, 0.0], [1.1, 0.0]], [[0, 1]], 100.0, rest_length=1.0))
    dt = 2.0 * pc.stability_limit(scene, pc.VelocityVerlet())
    with pytest.warns(pc.StabilityWarning):
        simulation = pc.Simulation(scene, dt=dt)
    with pytest.raises(pc.SimulationDiverged) as caught:
        simulation.step(10_000)
    error = caught.value
    assert error.step == simulation.steps + 1
    assert error.time == pytest.approx(error.step * dt)
    assert error.particle in (0, 1)
    assert "dt" in error.hint
    assert isinstance(error, ArithmeticError)
    last_good = error.last_good
    assert last_good is not None
    assert last_good.time == simulation.time
    assert (last_good.positions == simulation.positions).all()
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.step, copy.hint) == (str(error), error.step, error.hint)


def test_a_step_that_becomes_unstable_is_replaced():
    # A strong spring that rests at length 1 and is pressed to 0.2, where it is far stiffer across than along: the bound
    # of the start does not hold until it opens. The run has to end, and on time.
    network = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 1e4, damping=1.0)
    simulation = pc.Simulation(pc.Scene(network))
    simulation.set(positions=[[0.4, 0.0], [0.6, 0.0]])
    simulation.run(2.0)
    assert simulation.time == pytest.approx(2.0, rel=1e-12)
    assert np.isfinite(simulation.positions).all()


def test_states_are_short_as_text():
    """Shapes in place of arrays, as of trajectories."""
    body = pc.Particles(np.zeros((500, 2)), name="gas")
    run = pc.Simulation(pc.Scene(body, pc.Gravity()), dt=0.1)
    frame = next(iter(run.frames(duration=0.1)))
    assert repr(frame) == f"Frame(0 s: {', '.join(f'{name} {each.shape}' for name, each in frame.fields.items())})"
    assert repr(frame["gas"]).startswith("Snapshot(0 s: positions (500, 2), velocities (500, 2)")
    run.step()
    assert repr(run["gas"]).startswith("Part(0.1 s: positions (500, 2), velocities (500, 2)")
